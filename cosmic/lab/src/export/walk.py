"""Lets the robot of this folder walk in MuJoCo (pip install mujoco numpy). Option --view shows it in MuJoCo's viewer."""
import argparse, importlib, json, mujoco, pathlib, time, numpy as np


def load(folder):
    model = mujoco.MjModel.from_xml_path(str(pathlib.Path(folder, "robot.xml")))
    net = json.loads(pathlib.Path(folder, "controller.json").read_text())
    return model, {name: np.array(value) for name, value in net.items()}


def step(model, robots, net, n):
    """Does control step n for each robot: sets the target strains, and holds them for all substeps."""
    clock = [np.sin(net["omega"] * (n * net["dt"])), np.cos(net["omega"] * (n * net["dt"]))]
    sensed = np.array([np.concatenate([data.qpos, data.qvel, clock]) for data in robots])
    hidden = np.tanh(sensed @ net["w1"].T + net["b1"])
    for data, target in zip(robots, net["strain"] * np.tanh(hidden @ net["w2"].T + net["b2"])):
        data.ctrl = target
        mujoco.mj_step(model, data, int(net["substeps"]))


if __name__ == "__main__":
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--view", action="store_true", help="show the robot in MuJoCo's viewer")
    options.add_argument("--steps", type=int, help="number of control steps [default: that of the scene]")
    options.add_argument("--path", help="write qpos to this CSV file, one row before each step and one at the end")
    given = options.parse_args()
    model, net = load(pathlib.Path(__file__).parent)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    viewer = given.view and importlib.import_module("mujoco.viewer").launch_passive(model, data)
    path, began = [data.qpos.copy()], time.time()
    while len(path) <= (net["steps"] if given.steps is None else given.steps) and (not viewer or viewer.is_running()):
        step(model, [data], net, len(path) - 1)
        path.append(data.qpos.copy())
        if viewer:
            viewer.sync()
            time.sleep(max(0.0, began + data.time - time.time()))
    if given.path:
        np.savetxt(given.path, path, delimiter=",", fmt="%.17g")
    print(f"{(path[-1] - path[0])[::2] @ net['weights']:.4f} m along the ground in {data.time:.3f} s")
