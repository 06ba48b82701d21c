"""Lets an exported robot walk in MuJoCo from perturbed starts, on ground with several frictions.

Arguments: the folder of the export, the number of walks, the distance by which each coordinate of a start is
moved (m), the seed, the frictions. Prints JSON: for each friction, a list of displacements along the ground (m) of the
payload, or of the body that the scene names, with null for a walk that MuJoCo reset.
"""
import json, sys
import mujoco, numpy

folder, walks, distance, seed = sys.argv[1], int(sys.argv[2]), float(sys.argv[3]), int(sys.argv[4])
sys.path.insert(0, folder)
import walk

model, net = walk.load(folder)
robots = [mujoco.MjData(model) for _ in range(walks)]
steps, mechanical = int(net["steps"]), int(net["steps"] * net["substeps"])


def distances_of(starts):
    for data, moved in zip(robots, starts):
        mujoco.mj_resetDataKeyframe(model, data, 0)
        data.qpos += moved
    begun = [data.qpos.copy() for data in robots]
    for n in range(steps):
        walk.step(model, robots, net, n)
    # If the simulation diverges, MuJoCo resets it to time 0.
    whole = (mechanical - 0.5) * model.opt.timestep
    ended = [data.time > whole and numpy.isfinite(data.qpos[0]) for data in robots]
    ways = [(data.qpos - start)[::2] @ net["weights"] for data, start in zip(robots, begun)]
    return [way if end else None for way, end in zip(ways, ended)]


draw = numpy.random.default_rng(seed)
starts = [distance * draw.choice([-1.0, 1.0], model.nq) for _ in range(walks)]
found = []
for friction in map(float, sys.argv[5:]):
    # MuJoCo uses the larger friction of the two bodies in contact, so all bodies get the same friction.
    model.geom_friction[:, 0] = friction
    found.append(distances_of(starts))
json.dump({"mujoco": mujoco.__version__, "walks": found}, sys.stdout)
