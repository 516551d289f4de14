#!/usr/bin/env bash
# Rapier's vehicle: the engine is a force, the brake an impulse of each step, and with any engine there is no brake.
#
# Expected:  an engine and a brake of the same number at each wheel give equal forces, whatever the step, and together none.
# Happens:   20 at each of four wheels drive with 80 N at every step rate, and brake with 4800 N at 60 steps a second,
#            9600 N at 120, 19200 N at 240 (the reference calls it an impulse). Together the car speeds up as without a brake.
# Matters:   a smaller step makes the brakes stronger, and a pedal that overlaps (left-foot braking, traction control by
#            brake, hill start) has no brake at all.
# Source:    @dimforge/rapier3d-compat 0.21.0 on npm (WebAssembly), run under Node 20 on 2026-11-28.
# Guess written down before: braking does not depend on the step.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
npm install --silent --no-audit --no-fund --prefix . @dimforge/rapier3d-compat@0.21.0 >/dev/null
cat >car.mjs <<'END'
import RAPIER from "@dimforge/rapier3d-compat";
await RAPIER.init();

/** A car of 1500 kg on four wheels that has settled on its ground and then moves at 20 m/s along z. */
function rolling(dt, { friction, ground = 1, degrees = 0 }) {
  const world = new RAPIER.World({ x: 0, y: -9.81, z: 0 });
  world.timestep = dt;
  world.createCollider(RAPIER.ColliderDesc.cuboid(1000, 1, 1000).setTranslation(0, -1, 0).setFriction(ground));
  const half = (degrees * Math.PI) / 360;
  const upright = { x: 0, y: 0, z: 0, w: 1 };
  const body = world.createRigidBody(
    RAPIER.RigidBodyDesc.dynamic().setTranslation(0, 0.75, 0).setCanSleep(false)
      .setRotation({ x: 0, y: Math.sin(half), z: 0, w: Math.cos(half) })
      .setAdditionalMassProperties(1500, { x: 0, y: -0.4, z: 0 }, { x: 1e5, y: 1e5, z: 1e5 }, upright));
  world.createCollider(RAPIER.ColliderDesc.cuboid(0.9, 0.1, 2).setDensity(0), body);
  const car = world.createVehicleController(body);
  car.indexUpAxis = 1;
  car.setIndexForwardAxis = 2;
  for (const [i, [x, z]] of [[0.8, 1.4], [-0.8, 1.4], [0.8, -1.4], [-0.8, -1.4]].entries()) {
    car.addWheel({ x, y: -0.1, z }, { x: 0, y: -1, z: 0 }, { x: -1, y: 0, z: 0 }, 0.4, 0.3);
    car.setWheelSuspensionStiffness(i, 40);
    car.setWheelSuspensionCompression(i, 4);
    car.setWheelSuspensionRelaxation(i, 4);
    car.setWheelMaxSuspensionForce(i, 1e5);
    car.setWheelFrictionSlip(i, friction);
  }
  for (let i = 0; i < Math.round(3 / dt); i++) {
    car.updateVehicle(dt);
    world.step();
  }
  body.setLinvel({ x: 0, y: 0, z: 20 }, true);
  return { body, car, world };
}

for (const rate of [60, 120, 240]) {
  const forces = [[20, 0], [0, 20], [20, 20]].map(([engine, brake]) => {
    const { body, car, world } = rolling(1 / rate, { friction: 10 });
    for (let i = 0; i < 4; i++) {
      car.setWheelEngineForce(i, engine);
      car.setWheelBrake(i, brake);
    }
    for (let i = 0; i < rate / 2; i++) {
      car.updateVehicle(1 / rate);
      world.step();
    }
    return Math.round(((body.linvel().z - 20) * 1500) / 0.5 / 10) * 10;
  });
  console.log(`${rate} ${forces.join(" ")}`);
}
END
node car.mjs 2>/dev/null >seen
echo "steps a second  force in N by engine, brake, both"
cat seen
diff seen - <<'END'
60 80 -4800 80
120 80 -9600 80
240 80 -19200 80
END
