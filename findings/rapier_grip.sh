#!/usr/bin/env bash
# Rapier's vehicle grips twice as well along its wheels as across them, and its ground has no friction.
#
# Expected:  the one number "frictionSlip" of a wheel is its friction: with 1, locked wheels slow a car by 1.0 of the
#            load in any direction, and less on a ground of friction 0.2.
# Happens:   2.0 of the load straight ahead, 1.0 sideways, 1.3 and a side force in between (half of the brake
#            counts in an ellipse); the same on a ground of friction 0.2 and 1.
# Matters:   who sets the number by a skid pad gets twice the braking, and no number gives a real tire.
# Source:    @dimforge/rapier3d-compat 0.21.0 on npm (WebAssembly), run under Node 20 on 2026-11-28.
# Guess written down before: 1.0 in every direction.
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

for (const [ground, degrees] of [[1, 0], [0.2, 0], [1, 45], [1, 90]]) {
  const { body, car, world } = rolling(1 / 60, { friction: 1, ground, degrees });
  for (let i = 0; i < 4; i++) car.setWheelBrake(i, 1e4);
  let impulse = 0;
  for (let i = 0; i < 20; i++) {
    car.updateVehicle(1 / 60);
    for (let k = 0; k < 4; k++) impulse += car.wheelSuspensionForce(k) / 60;
    world.step();
  }
  console.log(`${ground} ${degrees} ${(((20 - body.linvel().z) * 1500) / impulse).toFixed(1)}`);
}
END
node car.mjs 2>/dev/null >seen
echo "ground  angle in degrees  braking force / load"
cat seen
diff seen - <<'END'
1 0 2.0
0.2 0 2.0
1 45 1.3
1 90 1.0
END
