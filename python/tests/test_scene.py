"""Scenes as values: reading keys, comparing and copying scenes, and arrays and numbers as settings."""

from __future__ import annotations

import copy
import pickle
from typing import Any

import cosmic
import numpy as np
import pytest
from common import SHORT, same


def test_a_scene_is_read_by_its_keys() -> None:
    scene = cosmic.as_scene({**SHORT, "physics.contact": "coulomb", "controller.goal": [1.5, 0.25]})
    assert (scene["physics.contact"], scene["controller.goal"]) == ("coulomb", [1.5, 0.25])
    assert (scene["lattice.columns"], scene["lattice.mirror"]) == (3, False)
    assert isinstance(scene["physics.gravity"], float) and isinstance(scene["physics.steps"], int)
    assert scene["lattice.file"] == "off"
    assert "physics.gravity" in scene and "physics.gravty" not in scene
    # The values are valid settings, and make the same scene.
    assert cosmic.as_scene({"scene": "earth", **dict(scene)}) == scene


@pytest.mark.parametrize(
    ("key", "says"),
    [
        ("physics.gravty", "unknown key `physics.gravty`: did you mean `gravity`"),
        ("gravity", "did you mean `physics.gravity`"),
        ("phisics.gravity", "did you mean `physics.gravity`"),
        ("phisics.x", "did you mean `physics`"),
        ("physics", "it is a section; its keys are dt, steps"),
        ("", "unknown key ``: "),
    ],
)
def test_an_unknown_key_is_named(key: str, says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.as_scene(SHORT)[key]


def test_scenes_with_equal_settings_are_equal() -> None:
    scene, other = cosmic.as_scene(SHORT), cosmic.as_scene({**SHORT, "physics.friction": 0.5})
    twin = cosmic.as_scene(SHORT)
    assert scene == twin and hash(scene) == hash(twin) and {scene, twin} == {scene}
    assert scene != other and scene != "stability" and len({scene, other}) == 2
    zeros = [cosmic.as_scene({**SHORT, "physics.gravity": zero}) for zero in (0.0, -0.0)]
    assert zeros[0] == zeros[1] and hash(zeros[0]) == hash(zeros[1])


def test_copies_of_scenes_are_equal_and_follow_later_settings() -> None:
    scene = cosmic.as_scene({"scene": "earth"})
    assert "auto" in scene.to_toml()
    for twin in (copy.copy(scene), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene))):
        assert twin == scene and twin.name == scene.name
        # Values that follow from the lattice follow in the copy too.
        larger = [cosmic.as_scene({"scene": own, "lattice.spacing": 0.3}) for own in (scene, twin)]
        assert larger[0] == larger[1]


def test_arrays_and_numpy_numbers_are_settings() -> None:
    points = np.array([[0.8, 0.0], [1.0, 0.05], [1.4, 0.05]])
    rough = cosmic.as_scene({**SHORT, "ground.profile": "points", "ground.points": points})
    assert rough["ground.points"] == points.tolist()
    for own in (points.astype(np.float32).astype(np.float64), points.tolist(), tuple(map(tuple, points))):
        assert np.allclose(cosmic.as_scene({**SHORT, "ground.points": own})["ground.points"], points)
    numbers = {
        "physics.steps": np.int32(64),
        "physics.gravity": np.float32(2.5),
        "lattice.mirror": np.bool_(False),
        "lattice.columns": np.array(4),
        "schedule.horizon": np.array([64, 65]),
    }
    scene = cosmic.as_scene({**SHORT, **numbers})
    assert [scene[key] for key in numbers] == [64, 2.5, False, 4, [64, 65]]
    # The ground is where the points say.
    sim, flat = cosmic.Simulator(rough), cosmic.Simulator(SHORT)
    inputs = sim.initial()
    assert same(sim.rollout(inputs), flat.rollout(inputs))
    inputs = inputs._replace(x0=inputs.x0 + [0.9, 0.06])
    above = [own.rollout(inputs).x[-1, :, 1].mean() for own in (sim, flat)]
    assert above[0] > above[1] + 0.01


def test_floats_without_a_fraction_are_whole_numbers(sim: cosmic.Simulator) -> None:
    scene = cosmic.as_scene({**SHORT, "physics.steps": 100.0, "schedule.horizon": [64.0, 100.0]})
    assert (scene["physics.steps"], scene["schedule.horizon"]) == (100, [64, 100])
    # A large or a negative number keeps its bits.
    for value in (9.0, -0.0, 1e300, 3.5):
        text = cosmic.as_scene({**SHORT, "gradient.cotangent_bound": 1e6, "ground.rise": min(value, 999.0)})
        assert text["ground.rise"] == min(value, 999.0)
    inputs = sim.initial(0.0)
    assert same(sim.rollout(inputs, 64.0, 32), sim.rollout(inputs, 64, 32))


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"physics.gravity": None}, "`physics.gravity` is None: leave the key out"),
        ({"physics": {"gravity": None}}, "`physics.gravity` is None: leave the key out"),
        ({"physics.forces": ["damper", None]}, "`physics.forces` is None"),
        ({"physics.gravity": float("nan")}, "`physics.gravity` is nan; it must be finite"),
        ({"physics.gravity": 1j}, "`physics.gravity` is 1j, which is not a valid scene value"),
        ({"physics.steps": 100.5}, r"`physics.steps` is a number with a point .*: 100.5[\s\S]*a whole number from 1"),
        ({"gravity": 3.7}, "'gravity' is not a section of a scene; write .* as 'physics.gravity'"),
        ({"spacing": 3.7}, "write a single setting as 'lattice.spacing' or 'ground.spacing'"),
        ({"bogus": 3.7}, "'bogus' is not a section of a scene; write .* as 'section.key'"),
        ({"physics": 3.7}, "'physics' is a section; it must be a dictionary"),
        ({"physics": {"physics.steps": 3}}, r"unknown key `physics.steps` in \[physics\]"),
        ({3: 1}, "3: the key of a setting must be a string"),
        ({"ground.points": np.zeros((2, 3))}, r"`ground.points` has 3 entries"),
        ({"ground.points": np.zeros((65, 2))}, r"`ground.points` has 65 points"),
    ],
)
def test_a_wrong_setting_is_named(settings: Any, says: str) -> None:
    with pytest.raises(cosmic.InputError, match=says):
        cosmic.as_scene(settings)
