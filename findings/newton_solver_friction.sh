#!/usr/bin/env bash
# In Newton the friction between a tire and the road depends on the solver that was chosen.
#
# Expected:  a scene states the friction of each shape, and the engine one rule for a pair of them; solvers differ by a few
#            per cent.
# Happens:   a block of friction 0.8 that slides on a ground of 0.2, and the reverse, are slowed by 0.5 g with the XPBD solver
#            (the mean) and by 0.8 g with the MuJoCo solver (the larger one). With 0.5 on both sides they agree.
# Matters:   a road that is made slippery in the scene keeps the grip of the tire with one solver and loses three eighths of it
#            with the other one; with neither is it the 0.2 of ice. A controller that is tuned with one is wrong in the other.
# Source:    newton 1.8.0 (2026) on PyPI with warp-lang 1.19.0 and mujoco 3.17.0, on a CPU, run on 2026-11-28.
# Guess written down before: the mean with every solver.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv packages
packages/bin/pip install --quiet newton==1.8.0 warp-lang==1.19.0 mujoco==3.17.0 mujoco-warp==3.17.0 2>/dev/null
cat >slide.py <<'END'
import newton
import warp as wp

STEP, STEPS, SPEED = 1 / 1200, 360, 3.0


def braking(solver, block, ground):
    """Return the mean deceleration of a sliding block, in g, over 0.3 s."""
    builder = newton.ModelBuilder()
    builder.add_ground_plane(cfg=newton.ModelBuilder.ShapeConfig(mu=ground))
    body = builder.add_body(xform=wp.transform((0.0, 0.0, 0.1), wp.quat_identity()))
    builder.add_shape_box(body, hx=0.4, hy=0.4, hz=0.1, cfg=newton.ModelBuilder.ShapeConfig(mu=block, density=1000.0))
    model = builder.finalize(device="cpu")
    states, control = [model.state(), model.state()], model.control()
    pipeline = newton.CollisionPipeline(model)
    contacts, solver = pipeline.contacts(), solver(model)
    speeds = model.joint_qd.numpy()
    speeds[0] = SPEED
    states[0].joint_qd.assign(speeds)
    newton.eval_fk(model, states[0].joint_q, states[0].joint_qd, states[0])
    seen = []
    for _ in range(STEPS):
        states[0].clear_forces()
        pipeline.collide(states[0], contacts)
        solver.step(states[0], states[1], control, contacts, STEP)
        states.reverse()
        seen.append(float(states[0].body_qd.numpy()[0, 0]))
    return (SPEED - seen[-1]) / (STEP * STEPS) / 9.81


wp.config.quiet = True
wp.config.enable_backward = False
wp.config.mode = "debug"  # compiles faster
wp.init()
solvers = {
    "XPBD": lambda model: newton.solvers.SolverXPBD(model, iterations=20),
    "MuJoCo": lambda model: newton.solvers.SolverMuJoCo(model, use_mujoco_cpu=True),
}
for name, solver in solvers.items():
    equal, tire, road = (braking(solver, *pair) for pair in ((0.5, 0.5), (0.8, 0.2), (0.2, 0.8)))
    print(f"{name}: 0.5 on 0.5 brakes with {equal:.2f} g, 0.8 on 0.2 with {tire:.2f} g, 0.2 on 0.8 with {road:.2f} g")
    assert abs(equal - 0.5) < 0.05
    assert all(abs(value - {"XPBD": 0.5, "MuJoCo": 0.8}[name]) < 0.05 for value in (tire, road))
END
WARP_CACHE_PATH="$folder/kernels" packages/bin/python slide.py 2>/dev/null | grep -v Module
