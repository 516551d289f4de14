#!/usr/bin/env bash
# Jolt's wheeled vehicle takes the square root of tire friction times ground friction.
#
# Expected:  the curve of a tire gives its friction, and the friction of the ground scales it: a locked tire of
#            friction 1 on a ground of 0.2 brakes with 0.2 g, and half of the tire is half of the force.
# Happens:   0.45 g = sqrt(1 x 0.2), and 0.71 g for half of the tire. This is the rule for two bodies in contact; the
#            curve, which belongs to a tire on a road, goes through it, too.
# Matters:   a curve copied from measured data is flattened even on a ground of friction 1 (a peak of 1.44 becomes 1.2),
#            and ice of friction 0.1 brakes a good tire with 0.32 g.
# Source:    jolt-physics 1.1.0 on npm (WebAssembly of Jolt Physics), run under Node 20 on 2026-11-28.
# Guess written down before: the product of the two.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --prefix . jolt-physics@1.1.0 >/dev/null
cat >car.mjs <<'END'
import start from "./node_modules/jolt-physics/dist/jolt-physics.wasm-compat.js";
const J = await start();

/** Mean deceleration, in g, of a car with locked wheels that moves at 20 m/s at an angle to its wheels. */
function brake(tire, ground, degrees) {
  const settings = new J.JoltSettings();
  const pairs = new J.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(0, 1);
  const layers = new J.BroadPhaseLayerInterfaceTable(2, 2);
  layers.MapObjectToBroadPhaseLayer(0, new J.BroadPhaseLayer(0));
  layers.MapObjectToBroadPhaseLayer(1, new J.BroadPhaseLayer(1));
  settings.mObjectLayerPairFilter = pairs;
  settings.mBroadPhaseLayerInterface = layers;
  settings.mObjectVsBroadPhaseLayerFilter = new J.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  const world = new J.JoltInterface(settings);
  const system = world.GetPhysicsSystem();
  const bodies = system.GetBodyInterface();
  const upright = new J.Quat(0, 0, 0, 1);
  const slab = new J.BoxShape(new J.Vec3(1000, 1, 1000), 0.05);
  const floor = bodies.CreateBody(
    new J.BodyCreationSettings(slab, new J.RVec3(0, -1, 0), upright, J.EMotionType_Static, 0));
  floor.SetFriction(ground);
  bodies.AddBody(floor.GetID(), J.EActivation_DontActivate);
  const box = new J.BoxShapeSettings(new J.Vec3(0.9, 0.2, 2), 0.05);
  const shape = new J.OffsetCenterOfMassShapeSettings(new J.Vec3(0, -0.3, 0), box).Create().Get();
  const turned = J.Quat.prototype.sRotation(new J.Vec3(0, 1, 0), (degrees * Math.PI) / 180);
  const chassis = new J.BodyCreationSettings(shape, new J.RVec3(0, 0.9, 0), turned, J.EMotionType_Dynamic, 1);
  chassis.mOverrideMassProperties = J.EOverrideMassProperties_CalculateInertia;
  chassis.mMassPropertiesOverride.mMass = 1500;
  chassis.mLinearDamping = 0;
  chassis.mAngularDamping = 0;
  const car = bodies.CreateBody(chassis);
  bodies.AddBody(car.GetID(), J.EActivation_Activate);
  const vehicle = new J.VehicleConstraintSettings();
  vehicle.mWheels.clear();
  for (const [x, z] of [[0.8, 1.4], [-0.8, 1.4], [0.8, -1.4], [-0.8, -1.4]]) {
    const wheel = new J.WheelSettingsWV();
    wheel.mPosition = new J.Vec3(x, -0.1, z);
    wheel.mMaxBrakeTorque = 1e5;
    for (const [curve, last] of [[wheel.mLongitudinalFriction, 1], [wheel.mLateralFriction, 90]]) {
      curve.Clear();
      curve.AddPoint(0, tire);
      curve.AddPoint(last, tire);
    }
    vehicle.mWheels.push_back(wheel);
  }
  const drive = new J.WheeledVehicleControllerSettings();
  drive.mDifferentials.clear();
  vehicle.mController = drive;
  const constraint = new J.VehicleConstraint(car, vehicle);
  constraint.SetVehicleCollisionTester(new J.VehicleCollisionTesterRay(1));
  system.AddConstraint(constraint);
  system.AddStepListener(new J.VehicleConstraintStepListener(constraint));
  for (let i = 0; i < 300; i++) world.Step(1 / 120, 1);
  bodies.SetLinearVelocity(car.GetID(), new J.Vec3(0, 0, 20));
  J.castObject(constraint.GetController(), J.WheeledVehicleController).SetDriverInput(0, 0, 1, 0);
  for (let i = 0; i < 20; i++) world.Step(1 / 120, 1);
  const before = car.GetLinearVelocity().GetZ();
  for (let i = 0; i < 40; i++) world.Step(1 / 120, 1);
  return ((before - car.GetLinearVelocity().GetZ()) * 3) / 9.81;
}
const [tire, ground] = process.argv.slice(2).map(Number);
console.log(`${tire} ${ground} ${brake(tire, ground, 0).toFixed(2)}`);
END
{ for case in "1 1" "1 0.5" "1 0.2" "0.5 1"; do node car.mjs $case; done; } >seen
echo "tire  ground  braking in g"
cat seen
diff seen - <<'END'
1 1 1.00
1 0.5 0.71
1 0.2 0.45
0.5 1 0.71
END
