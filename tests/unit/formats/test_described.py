"""The robot as it is written comes back from robot.json and from the cache, with each of its fields."""

import json
from dataclasses import fields, replace

import numpy as np
import pytest

from linkwright.stages.export.robot_json import describe
from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.formats.mjcf import written as mjcf_written
from linkwright.stages.formats.mjcf.form import MjcfForm
from linkwright.stages.formats.robot_json.codec import RobotJsonError
from linkwright.stages.formats.urdf.form import UrdfForm
from linkwright.stages.formats.urdf.urdf_robot import urdf_form
from linkwright.stages.formats.written import Written, decode, encode
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.robot.model.actuation import Actuation, Actuator, Armature
from linkwright.stages.robot.model.amendments import Amendment, Amendments, Surplus
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.robot.model.geometry import Exclude, Geometry, Shape, Touch
from linkwright.stages.robot.model.robot import (
    Dynamics,
    Frame,
    Keyframe,
    Limits,
    MateRef,
    MateValue,
    Primitive,
    Relation,
    Sensor,
    Transmission,
    frozen,
)
from linkwright.stages.robot.model.scene import Ground, Scene
from linkwright.stages.robot.model.sensing import Sensing, SensorCamera, SensorSite
from linkwright.stages.robot.motion.linear_coupling import LinearCoupling
from tests.support.robots import EVERY, LOOPS, at, joint, loop, pose, robot_with, solid
from tests.support.truth import differences

NEAR = 1e-11

BOX = Primitive("box", (0.1, 0.2, 0.3), frozen(at(0, 0, 0.1)), (0.1, 0.2, 0.3, 0.5))
ROD = Primitive("capsule", (0.01, 0.2), frozen(at(0, 0.1, 0)), None, False, True)


def whole(seed):
    """A robot with every type of joint and loop, and something of everything else."""
    rng = np.random.default_rng(seed)
    rows = []
    for index, kind in enumerate(EVERY):
        parent = "base" if kind == "free" else rows[-1].child if rows and index % 3 else "base"
        origins = [pose(rng) for _ in range(3)]
        rows.append(
            joint(kind, parent, f"link{index}", place=pose(rng), backwards=index % 2 == 0, origins=origins)
        )
    turn, slide = rows[1].dofs[0], rows[2].dofs[0]
    moved = replace(
        turn, limits=Limits(-1, None), dynamics=Dynamics(0.1, 0.2, 0.003, 5, 6), saved=0.3,
        given=("limits", "effort"), mate_value=MateValue(-1, 0.25),
    )  # fmt: skip
    rows[1] = replace(rows[1], dofs=(moved,), mate=MateRef(("a", "b"), "F1", "Hinge", "REVOLUTE", "copy1"))
    rows[2] = replace(rows[2], mate=None)
    loops = [
        loop(kind, "link1", "link2", pose(rng), pose(rng), name=f"loop{index}", lever=0.07)
        for index, kind in enumerate(LOOPS)
    ]
    robot = robot_with(
        rows,
        loops=loops,
        relations=[Relation("belt", turn.name, slide.name, -2.5, 0.125)],
        frames=[Frame("tip", "link2", frozen(pose(rng)), "Tip"), Frame("own", "link1", at(1, 0, 0), "")],
        world_from_root=pose(rng), given={"link1": solid(3.0)}, shapes={"link2": (BOX, ROD)}, fixed=False,
    )  # fmt: skip
    (part,) = robot.links[1].parts
    flip = np.diag([-1.0, 1.0, 1.0, 1.0])
    flipped = {key: frozen(getattr(part, key) @ flip) for key in ("link_from_part", "world_from_part")}
    part = replace(part, **flipped, collides=False, seen=False, standard=True, estimated=True)
    links = (robot.links[0], replace(robot.links[1], parts=(part,)), *robot.links[2:])
    return replace(
        robot,
        links=links,
        transmissions=(Transmission("t", turn.name, "Simple", 50.0, ("effort", "position")),),
        keyframes=(Keyframe("up", ((turn.name, 0.5),)),),
        mobility=replace(robot.mobility, redundant=(("loop1", 2),)),
    )


ACTUATION = Actuation(
    actuators=(
        Actuator("servo", "link1_joint", "position", 2.0, 30.0, 1.5, (-1, 1), (-5, 5), (("ki", "0.1"),), 0.3),
        Actuator("push", "link2_joint", "motor", motor="sts3215", sources=(("kp", "a paper"),)),
    ),
    armatures=(Armature("link1_joint", 0.003, "driven"),),
    compensated=(("link1", 0.5),),
    compensating=("link1_joint",),
)
SENSING = Sensing(
    (
        Sensor("turned", "jointpos", "joint", "link1_joint", noise=0.01, cutoff=3.0),
        Sensor("touched", "touch", "site", "pad", shape="box", size=(0.1, 0.2, 0.3)),
        Sensor("where", "framepos", "xbody", "link1", "xbody", "link2"),
        Sensor("time", "clock"),
    ),
    (
        SensorSite("pad", "link1", frozen(at(0, 0, 1)), "sphere", (0.02,)),
        SensorSite("p", "base", at(0, 1, 0)),
    ),
    (SensorCamera("eye", "link2", frozen(at(0, 1, 1)), 45.0, (640, 480)),),
)
PRIMITIVE = Primitive("box", (0.1, 0.2, 0.3), at(0, 0, 0.1))
CONTACT = ContactProperties((1, 0.1, 0.01), 4, (0.01, 1), (0.9, 0.95, 0.001, 0.5, 2), 0.001, 3)
GEOMETRY = Geometry(
    (
        Shape("link1", "collision", "a.stl", None, 8, 12, 0.25, 0.125, None, None, None, 1),
        Shape("link1", "visual", "b.obj", (0.1, 0.2, 0.3, 0.4), 8, 12, 0.25, 0.125, texture="c.png"),
        Shape("link2", "collision", None, None, 0, 0, 0.22, 0.006, PRIMITIVE, CONTACT),
    ),
    {},
    self_contact=True,
    excludes=(Exclude("link1", "link2", "Always", 0.002, ((0, 0),)), Exclude("base", "link1", "User", 0.0)),
    touching=(Touch("base", "link2", 0.001),),
)
FORM = UrdfForm(
    False, (LinearCoupling("link1_joint", "link2_joint", 2.0, 0.5, 0.0, True, -1, 1),), ("loop0",), "arm"
)
AMENDMENTS = Amendments(
    (Amendment("elements.cam", "robot.xml", "body link1", ("site cam",), ("pos",)),),
    (Surplus("robot.xml", 1, 2, 3),),
)
SCENE = Scene(
    frozen(at(0, 0.1, 0.2)),
    (("home", frozen(at(0, 0.1, 0.15))),),
    Ground(frozen(at(0, 0, -0.1)), (1, 0.005, 0.0001)),
    {"timestep": 0.002, "integrator": "RK4", "gravity": (0.0, 0.0, -9.81)},
    {"contact": "disable"},
)


def text(robot):
    form = MjcfForm(("link0",))
    written = Written(robot, ACTUATION, GEOMETRY, FORM, form, SENSING, AMENDMENTS, SCENE)
    return describe(written, files=["robot.xml", "assets/a.stl"])


@pytest.mark.parametrize("seed", range(3))
def test_everything_is_read_back(seed):
    robot = whole(seed)
    truth = read_robot_json(text(robot))
    again = truth.written
    assert (
        differences(with_actuation(robot, ACTUATION), again.robot, NEAR, {"base": "", "keyframes": ""}) == []
    )
    assert (again.robot.base.joint, again.robot.keyframes) == ("base_free", robot.keyframes)
    for first, other in (
        (ACTUATION, again.actuation), (FORM, again.urdf_form), (SENSING, again.sensing),
        (GEOMETRY, again.geometry), (AMENDMENTS, again.amendments), (SCENE, again.scene),
    ):  # fmt: skip
        assert differences(first, other, NEAR, {"files": ""}) == []
    assert again.mjcf_form == MjcfForm(("link0",))
    assert truth.files == ("assets/a.stl", "robot.xml")


def test_robot_json_of_a_build_that_ends_early_is_read():
    truth = read_robot_json(describe(Written(whole(0))))
    assert (truth.written.geometry, truth.written.scene, truth.files) == (None, None, ())
    assert truth.written.urdf_form == UrdfForm()


def leaves(value, path=()):
    """The paths of all values; for a list of numbers only the first."""
    pairs = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    numbers = isinstance(value, list) and all(isinstance(item, float) for item in value)
    for key, item in list(pairs)[: 1 if numbers else None]:
        yield from leaves(item, (*path, key))
    if not isinstance(value, dict | list):
        yield path


@pytest.mark.slow
def test_value_of_a_wrong_type_is_a_named_error_or_not_read():
    """Each value in its turn as a text, a table, or nothing: it is refused with its name, or not read."""
    table = json.loads(text(whole(0)))
    refused = 0
    for number, path in enumerate(leaves(table)):
        above = table
        for key in path[:-1]:
            above = above[key]
        kept = above[path[-1]]
        above[path[-1]] = ({"x": 1}, "\0", [], None)[number % 4]
        try:
            read_robot_json(json.dumps(table).encode())
        except RobotJsonError:
            refused += 1
        above[path[-1]] = kept
    assert refused > 500


@pytest.mark.parametrize("data", [b"", b"[", b"[]", b"null", b"\xff", b"{}", b"[" * 100_000, b'{"a": 1e999}'])
def test_other_data_is_refused(data):
    with pytest.raises(RobotJsonError):
        read_robot_json(data)


@pytest.mark.parametrize("seed", range(3))
def test_cached_robot_is_read_as_it_was_written(seed):
    """Nothing is left out: each field differs from its default, except `srdf_form`, which no build sets."""
    robot = whole(seed)
    forms = urdf_form(robot, merged=True), mjcf_written.mjcf_form(robot)
    written = Written(
        with_actuation(robot, ACTUATION), ACTUATION, GEOMETRY, *forms, SENSING, AMENDMENTS, SCENE
    )
    bare = Written(robot)
    names = [field.name for field in fields(Written)]
    same = [name for name in names if getattr(written, name) == getattr(bare, name)]
    assert same == ["srdf_form"]
    again = decode(encode(written), robot, GEOMETRY)
    assert differences(written, again, 0.0, {"option": "lists"}) == []
