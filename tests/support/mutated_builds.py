"""Two finished builds to plant faults in: the sample, and a robot that has what the sample lacks."""

from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from linkwright.pipeline.checking.run import checked
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.sample import sample_document
from tests.support.building import bundle_of, plan_of, write
from tests.support.kit import SIDE, TOP, Kit

RESISTS = {"effort": 20, "velocity": 3, "damping": 0.1, "friction": 0.02, "armature": 0.01}

FORMATS = {"urdf": {}, "mjcf": {}, "sdf": {}, "ros2": {}, "python": {}}
FORMATS |= {"usd": {}} if find_spec("pxr") else {}

FEW_FACES = {"max_faces": 300}
"""Bounds the visual meshes: each check reads and compiles them several times."""

SAMPLE = {
    "export": FORMATS,
    "mesh": {"collider": "hull", "colliders": {"*[Pp]late*": "box"}, "visual": FEW_FACES},
    "contact": {"self": "auto"},
    "joints": {"*": RESISTS},
    "actuators": {
        "*": {"type": "motor"},
        "shoulder*": {"type": "position", "kp": 50, "kv": 1},
        "lift": {"type": "position", "kp": 5000, "kv": 500},
    },
}

ROVER = {
    "export": FORMATS,
    "root": {"select": "Body", "base": "free"},
    "mesh": {"collider": "primitives", "visual": FEW_FACES},
    "contact": {"self": "auto"},
    "joints": {"*": RESISTS},
    "actuators": {"*": {"type": "motor", "gear": 5}},
    "sensors": {
        "imu": {"type": "imu", "frame": "mast"},
        "angle": {"type": "joint", "joints": "neck", "measure": ["pos"]},
    },
    "keyframes": {"crouch": {"neck": 0.3}},
}


@dataclass(frozen=True)
class Build:
    """A finished build in `folder`: the robot's files and its robot.json, without report.json."""

    folder: Path
    name: str


def checks_of(folder):
    """What `linkwright check` makes of a folder."""
    return checked(str(folder), "standard").checks


def built(document, folder, keys):
    """A document of the local Onshape, built with these keys."""
    plan, bundle = plan_of(**keys), bundle_of(document)
    robot = build_robot(bundle, plan)
    geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
    folder.mkdir()
    write(robot, folder, plan, geometry)
    return Build(folder, robot.name)


def sample(folder):
    return built(sample_document(), folder, SAMPLE)


def rover(folder):
    """A free body with a neck, two geared wheels, a ball and a frame."""
    return built(rover_document(), folder, ROVER)


def rover_document():
    kit = Kit()
    body = kit.place("Body")
    head, left, right, hand = (kit.place(name) for name in ("Head", "Left", "Right", "Hand"))
    kit.root.revolute("Neck", (head, turn((1, 0, 0), 0.4)), (body, TOP), limits=(-1, 1))
    first = kit.root.revolute("Roll", (left, TOP), (body, SIDE), limits=(-3, 3))
    second = kit.root.revolute("Idle", (right, TOP), (body, turn((1, 0, 0), 1, (0, 0.3, 0))), limits=(-3, 3))
    kit.root.gear("Gear", first, second, 1.5)
    kit.root.slider("Reach", (hand, np.eye(4)), (head, frame((0.2, 0, 0.1))), limits=(-0.1, 0.2))
    kit.root.connector("Mast", head, SIDE)
    kit.root.connector("Hook", hand, TOP)
    return kit.document


def hinge_document():
    """Two parts on a hinge."""
    kit = Kit()
    first, other = kit.place("One"), kit.place("Other")
    kit.root.revolute("Hinge", (other, TOP), (first, TOP), limits=(-1, 1))
    return kit.document
