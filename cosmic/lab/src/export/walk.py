"""Lets the robot of this folder walk in MuJoCo (pip install mujoco numpy). Option --view shows it in MuJoCo's viewer."""
import argparse, importlib, json, mujoco, pathlib, sys, time, numpy as np


def load(folder):
    model = mujoco.MjModel.from_xml_path(str(pathlib.Path(folder, "robot.xml")))
    net = json.loads(pathlib.Path(folder, "controller.json").read_text())
    return model, {name: np.array(value) for name, value in net.items()}


def observed(net, data, goal):
    """How a robot observes a goal, a point in the ground's frame (m): as a bounded offset."""
    offset = net["goal_scale"] * (goal - net["mean"] @ data.qpos.reshape(-1, len(goal)))
    return offset / np.sqrt(1 + offset @ offset)


def force(net, data, target):
    """The force of each actuator (N), at most what its law allows. A positive force pushes the ends apart."""
    pull = net["stiffness"] * (data.actuator_length - net["length"] * (1 + target))
    most, relative = net["force"], data.actuator_velocity / net["speed"]
    return -np.clip(np.clip(pull, -most, most), most * (relative - 1), most * (relative + 1))


def step(model, robots, net, n, goal=None):
    """Does control step n for each robot: sets the target strains, and holds them for all substeps.

    Robots whose goals are given go to `goal`; without it, to the goal of controller.json."""
    clock = [np.sin(net["omega"] * (n * net["dt"])), np.cos(net["omega"] * (n * net["dt"]))]
    sensed = np.array([np.concatenate([data.qpos, data.qvel, clock]) for data in robots])
    if "goal" in net:
        sensed = np.hstack([sensed, [observed(net, data, net["goal"] if goal is None else goal) for data in robots]])
    hidden = np.tanh(sensed @ net["w1"].T + net["b1"])
    if "gates" in net:
        axes = len(net["goal"])
        along, across = sensed[:, -axes], sensed[:, 1 - axes] * (axes == 3)
        hidden *= np.transpose([along**0, along, along**2, across, across**2]) @ net["gates"].T
    for data, target in zip(robots, net["strain"] * np.tanh(hidden @ net["w2"].T + net["b2"])):
        if "force" not in net:
            data.ctrl = target
            mujoco.mj_step(model, data, int(net["substeps"]))
            continue
        for _ in range(int(net["substeps"])):
            mujoco.mj_step1(model, data)
            data.ctrl = force(net, data, target)
            mujoco.mj_step2(model, data)


def moved(net, way):
    """How far the robot gets along the ground, and in space across, if its coordinates change by `way`, m."""
    axes = len(way) // len(net["nodes"])
    return np.array([way[k::axes] @ net["weights"] for k in range(axes - 1)])


def told(text):
    """A goal of --goal, such as 1.2 or -1@5: when it begins (s), and its place (m from the payload at the start)."""
    place, _, begin = text.removesuffix("s").partition("@")
    return float(begin or 0), [float(number) for number in place.split(",")]


def point(net, place):
    """The goal that is at this place, as high as the payload at the start."""
    return net["start"] + np.pad(place, (0, len(net["start"]) - len(place)))


def ways(net, goals, path):
    """For each goal: its place (m), when it begins and ends (s), and how far away the robot is then (m)."""
    last = len(path) - 1
    ends = [min(begin, last) for begin, _ in goals[1:]] + [last]
    place = lambda goal: (goal - net["start"])[:-1]
    away = lambda goal, n: np.linalg.norm(place(goal) - moved(net, path[n] - path[0]))
    spans = [(goal, n, end) for (n, goal), end in zip(goals, ends) if n < last]
    return [(place(goal), n * net["dt"], end * net["dt"], away(goal, n), away(goal, end)) for goal, n, end in spans]


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--view", action="store_true", help="show the robot in MuJoCo's viewer")
    options.add_argument("--steps", type=int, help="number of control steps [default: that of the scene]")
    options.add_argument("--path", help="write qpos to this CSV file, one row before each step and one at the end")
    options.add_argument("--goal", type=told, action="append", default=[], metavar="X[,Y]@TIME", help="where the robot "
                         "is to go (m along the ground, in space also across, from where it starts), and from when on (s); can be "
                         "repeated")
    # A goal may begin with a minus sign, as options do.
    words = "\0".join(sys.argv[1:]).replace("--goal\0", "--goal=").split("\0")
    given = options.parse_args([word for word in words if word])
    model, net = load(pathlib.Path(__file__).parent)
    if given.goal and "goal" not in net:
        options.error("--goal: the goal of this robot is a number of its controller")
    if any(len(place) >= len(net["start"]) for _, place in given.goal):
        options.error(f"--goal: a goal of this robot has at most {len(net['start']) - 1} numbers")
    goals = [(round(begin / net["dt"]), point(net, place)) for begin, place in given.goal]
    goals = goals or [(0, net.get("goal"))]
    if goals[0][0] != 0 or any(after <= before for (before, _), (after, _) in zip(goals, goals[1:])):
        options.error("--goal: the first goal must begin at 0 s, and every other one after the goal before it")
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    viewer = given.view and importlib.import_module("mujoco.viewer").launch_passive(model, data)
    path, began = [data.qpos.copy()], time.time()
    while len(path) <= (net["steps"] if given.steps is None else given.steps) and (not viewer or viewer.is_running()):
        n = len(path) - 1
        step(model, [data], net, n, [goal for begin, goal in goals if begin <= n][-1])
        path.append(data.qpos.copy())
        if viewer:
            viewer.sync()
            time.sleep(max(0.0, began + data.time - time.time()))
    if given.path:
        np.savetxt(given.path, path, delimiter=",", fmt="%.17g")
    print(f"{moved(net, path[-1] - path[0])[0]:.4f} m along the ground in {data.time:.3f} s")
    for place, begin, end, way, left in ways(net, goals, path) if "goal" in net else []:
        place = ", ".join(f"{number:.4f}" for number in place)
        print(f"goal {place} m, {begin:.3f} to {end:.3f} s: {way:.4f} m away at first, {left:.4f} m at the end")
