"""No number of a robot's files is the noise of its making."""

import json
import re

import numpy as np
import pytest

from linkwright.stages.formats.xml import parse
from linkwright.stages.robot.model.poses import rotation_from_rpy
from linkwright.stages.robot.model.robot import Dynamics, Frame, Inertial, Limits, Relation, frozen
from tests.support.building import NO_MESHES, plan_of, write
from tests.support.robots import from_parts, joint, robot_with

NOISE = 1e-13
"""m, rad: what is written and is smaller, and not zero."""

SCALED = ("mass", "inertia", "diaginertia", "solref", "solimp")
"""What may be small: measured by its own scale, or given."""


def noisy(rng):
    """A transform by quarter turns and lengths of a millimetre, with the noise of much arithmetic."""
    quarters = rng.integers(0, 4, 3) * np.pi / 2
    place = from_parts(
        rotation_from_rpy(tuple(quarters)), np.round(rng.uniform(-0.1, 0.1, 3), 3) * rng.integers(0, 2, 3)
    )
    place[:3] += rng.uniform(-8e-14, 8e-14, (3, 4))
    return place


def robot(seed):
    rng = np.random.default_rng(seed)
    few = 7e-14
    ends = {"arm_joint": (-few, 1.5), "hand_joint": (-0.2, few), "finger_joint": (0.0, 0.05)}
    limits = {name: Limits(*both) for name, both in ends.items()}
    strong = Dynamics(effort=3.0)
    rows = [
        joint("revolute", "base", "arm", (few,), place=noisy(rng), limits=limits),
        joint("prismatic", "arm", "hand", (-few,), place=noisy(rng), limits=limits, dynamics=strong),
        joint("fixed", "hand", "plate", place=noisy(rng)),
        joint("prismatic", "plate", "finger", (0.01,), place=noisy(rng), limits=limits),
        joint("revolute", "arm", "wheel", place=noisy(rng)),
    ]
    frames = [Frame("tool", "hand", frozen(noisy(rng)), ""), Frame("eye", "plate", frozen(noisy(rng)), "")]
    tensor = np.diag([2e-3, 3e-3, 4e-3]) + rng.uniform(-1e-18, 1e-18, (3, 3))
    body = Inertial(0.7, frozen(np.array([0.0, few, 0.02])), frozen((tensor + tensor.T) / 2))
    relation = Relation("gears", "wheel_joint", "arm_joint", 0.5, few)
    return robot_with(
        rows, relations=[relation], frames=frames, fixed=bool(seed % 2),
        inertials={"hand": body, "plate": body},
    )  # fmt: skip


def words(text):
    match = re.fullmatch(r"[-+0-9.e ]+", text)
    return [float(word) for word in text.split()] if match else []


def attributes(data):
    nodes = parse(data).iter()
    return [(key, value) for node in nodes for key, value in node.attrib.items() if key not in SCALED]


def leaves(value, key=""):
    if isinstance(value, dict):
        for name, inside in value.items():
            yield from leaves(inside, name)
    elif isinstance(value, list) and not all(isinstance(item, int | float) for item in value):
        for inside in value:
            yield from leaves(inside, key)
    else:
        yield key, value


@pytest.mark.parametrize("seed", range(6))
def test_no_file_has_noise_or_a_negative_zero(tmp_path, seed):
    plan = plan_of(actuators={"*": "position"}, scene__cameras={"view": {"frame": "eye"}})
    files = write(robot(seed), tmp_path, plan, NO_MESHES).files
    for name in ("robot.urdf", "robot.xml", "scene.xml"):
        total = 0
        for key, text in attributes(files[name]):
            numbers = words(text)
            total += len(numbers)
            assert not [number for number in numbers if 0 < abs(number) < NOISE], (name, key, text)
            assert "-0" not in text.split(), (name, key, text)
        assert total > 40 or name == "scene.xml"
    for key, value in leaves(json.loads(files["robot.json"])):
        numbers = value if isinstance(value, list) else [value]
        small = [number for number in numbers if isinstance(number, float) and 0 < abs(number) < NOISE]
        assert not small or key in ("mass", "inertia"), (key, value)
