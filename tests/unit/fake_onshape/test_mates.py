"""Every type of mate in the documents' own kinematics: by closed forms, differences and two engines."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.fake_onshape.definition import definition
from tests.fake_onshape.differences import differences_hold
from tests.fake_onshape.document import ORIGIN, Document
from tests.fake_onshape.feature_replies import features
from tests.fake_onshape.frames import frame, inverse
from tests.support.engines import Mujoco, Pinocchio
from tests.support.kit import OFF, ON, Kit

QUAT = (0.5, 0.5, -0.5, 0.5)
VALUES = {
    "revolute": 0.4,
    "slider": 0.03,
    "cylindrical": (0.03, 0.4),
    "pin_slot": (0.05, -0.6),
    "planar": (0.02, -0.04, 0.9),
    "parallel": (0.02, -0.04, 0.06, 0.9),
    "ball": QUAT,
}
SLIDES = {"slider": "z", "cylindrical": "z", "pin_slot": "x", "planar": "xy", "parallel": "xyz"}


def related(kind: str, value: object) -> np.ndarray:
    """The first frame in the second, written out."""
    made = np.eye(4)
    numbers = list(np.atleast_1d(value))
    if kind == "ball":
        made[:3, :3] = Rotation.from_quat(np.roll(value, -1)).as_matrix()
        return made
    for axis in SLIDES.get(kind, ""):
        made["xyz".index(axis), 3] = numbers.pop(0)
    if numbers:
        (q,) = numbers
        made[:2, :2] = [[math.cos(q), -math.sin(q)], [math.sin(q), math.cos(q)]]
    return made


def joined(kind: str, backwards: bool = False) -> Document:
    """A fixed base, an arm on it by a mate of this kind, and a hand hinged to the arm."""
    kit = Kit()
    base, arm, hand = (kit.place(name) for name in ("Base", "Arm", "Hand"))
    kit.root.instances[0].fixed = True
    ends = [(arm, ON), (base, OFF)]
    getattr(kit.root, kind)("Mate", *(ends[::-1] if backwards else ends), VALUES[kind])
    kit.root.revolute("Hinge", (hand, ON), (arm, OFF), 0.3)
    return kit.document


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", VALUES)
def test_a_mate_means_second_then_slides_then_turn_then_first(kind: str, backwards: bool) -> None:
    document = joined(kind, backwards)
    poses = list(document.truth.poses().values())
    first, second = (poses[0] @ OFF, poses[1] @ ON) if backwards else (poses[1] @ ON, poses[0] @ OFF)
    assert inverse(second) @ first == pytest.approx(related(kind, VALUES[kind]), abs=1e-12)
    edge = document.truth.joint("Mate")
    assert edge.value_at(document.truth.poses()) == pytest.approx(VALUES[kind], abs=1e-12)


def test_names_of_what_a_mate_leaves_free() -> None:
    found = {kind: [dof.name for dof in joined(kind).truth.joint("Mate").dofs] for kind in VALUES}
    assert found == {
        "revolute": ["Mate"],
        "slider": ["Mate"],
        "cylindrical": ["Mate_slide", "Mate_turn"],
        "pin_slot": ["Mate_slide", "Mate_turn"],
        "planar": ["Mate_x", "Mate_y", "Mate_turn"],
        "parallel": ["Mate_x", "Mate_y", "Mate_z", "Mate_turn"],
        "ball": ["Mate"],
    }


@pytest.mark.parametrize("backwards", [False, True])
@pytest.mark.parametrize("kind", VALUES)
def test_jacobians_are_differences_of_poses(kind: str, backwards: bool) -> None:
    truth = joined(kind, backwards).truth
    differences_hold(truth, truth.values(), roots=(None, *truth.leaves))


def test_engines_read_a_ball_as_the_truth_does(tmp_path) -> None:
    """A block on a ball, by hand in both formats: MuJoCo's own ball and three turns in a URDF."""
    kit = Kit()
    base, arm = kit.place("Base"), kit.place("Arm")
    kit.root.instances[0].fixed = True
    kit.root.ball("Ball", (arm, frame((0.01, 0.02, -0.04))), (base, OFF), QUAT)
    truth = kit.document.truth
    mass, com, inertia = arm.last.source.inertial()
    com = com - [0.01, 0.02, -0.04]
    xyz, rpy = OFF[:3, 3], Rotation.from_matrix(OFF[:3, :3]).as_euler("xyz")
    start = (0.6, 0.0, 0.8, 0.0)
    stands = OFF[:3, :3] @ Rotation.from_quat(np.roll(start, -1)).as_matrix()
    quat = np.roll(Rotation.from_matrix(stands).as_quat(), 1)

    def text(numbers):
        return " ".join(f"{number:.17g}" for number in numbers)

    diagonal = text(np.diag(inertia))
    (tmp_path / "ball.xml").write_text(f"""<mujoco><compiler autolimits="true"/><worldbody>
      <body name="arm" pos="{text(xyz)}" quat="{text(quat)}"><joint name="Ball" type="ball"/>
      <inertial mass="{mass:.17g}" pos="{text(com)}" diaginertia="{diagonal}"/></body></worldbody>
      </mujoco>""")
    ixx, iyy, izz = np.diag(inertia)
    urdf = f"""<robot name="ball"><link name="world"/><link name="a"/><link name="b"/>
      <link name="arm"><inertial><origin xyz="{text(com)}"/><mass value="{mass:.17g}"/>
      <inertia ixx="{ixx:.17g}" iyy="{iyy:.17g}" izz="{izz:.17g}" ixy="0" ixz="0" iyz="0"/></inertial></link>
      <joint name="Ball_x" type="continuous"><parent link="world"/><child link="a"/>
      <origin xyz="{text(xyz)}" rpy="{text(rpy)}"/><axis xyz="1 0 0"/></joint>
      <joint name="Ball_y" type="continuous"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/></joint>
      <joint name="Ball_z" type="continuous"><parent link="b"/><child link="arm"/><axis xyz="0 0 1"/></joint>
      </robot>"""
    for value in ((0.8, 0.36, -0.48, 0.0), (0.1, 0.7, 0.1, -0.7)):
        value = tuple(np.array(value) / np.linalg.norm(value))
        q = {"Ball": value}
        pose = truth.poses(q)[arm.path] @ frame((0.01, 0.02, -0.04))
        for engine in (Pinocchio(urdf.encode()), Mujoco(tmp_path / "ball.xml", {"Ball": start})):
            found = engine.poses(q)
            assert found["arm"] == pytest.approx(pose, abs=1e-9)
            assert found["world"] == pytest.approx(np.eye(4))
            assert engine.mass_matrix(q, ["Ball"]) == pytest.approx(truth.mass_matrix(q), abs=1e-9)
            assert engine.gravity(q, ["Ball"]) == pytest.approx(truth.gravity_torque(q), abs=1e-9)


def test_limits_of_every_mate_in_the_definition_and_in_the_list_of_features() -> None:
    kit = Kit()
    base, *arms = (kit.place(f"Bar {n}") for n in range(6))
    kit.root.cylindrical("C", (arms[0], ON), (base, ON), limits=((0, 0.1), (None, 1)))
    kit.root.pin_slot("P", (arms[1], ON), (base, ON), limits=((0, 0.1), (-1, 1)))
    kit.root.planar("F", (arms[2], ON), (base, ON), limits=((0, 0.1), (-0.2, None), (-1, 1)))
    kit.root.parallel("Q", (arms[3], ON), (base, ON), limits=((0, 0.1), (-0.2, 0), (-1, 1), (-3, 3)))
    kit.root.ball("B", (arms[4], ON), (base, ON), limits=0.7)
    expected = {
        "C": {"limitZMin": 0, "limitZMax": 0.1, "limitAxialZMax": 1},
        "P": {"limitXMin": 0, "limitXMax": 0.1, "limitAxialZMin": -1, "limitAxialZMax": 1},
        "F": {"limitXMin": 0, "limitXMax": 0.1, "limitYMin": -0.2, "limitAxialZMin": -1, "limitAxialZMax": 1},
        "Q": {"limitXMin": 0, "limitXMax": 0.1, "limitYMin": -0.2, "limitYMax": 0, "limitZMin": -1,
              "limitZMax": 1, "limitAxialZMin": -3, "limitAxialZMax": 3},
        "B": {"limitEulerConeAngleMax": 0.7},
    }  # fmt: skip
    written = definition(kit.document)["rootAssembly"]["features"]
    assert {one["featureData"]["name"]: one["featureData"]["mateLimits"] for one in written} == expected
    for one in features(kit.root, old=False)["features"]:
        given = {p["parameterId"]: p for p in one["parameters"]}
        assert given["limitsEnabled"]["value"] is True
        for name, number in expected[one["name"]].items():
            unit = "rad" if "A" in name else "m"
            assert given[name]["expression"] == f"{float(number)!r} {unit}"
            assert (given[name]["isNull"], given[name]["nullValue"]) == (False, "")
    first = features(kit.root, old=True)["features"][0]["message"]["parameters"]
    cylinder = {one["message"]["parameterId"]: one["message"] for one in first}
    for name, empty, zero in (
        ("limitAxialZMin", "No minimum", "0 deg"),
        ("limitXMin", "No minimum", "0 mm"),
        ("limitEulerConeAngleMax", "No maximum", "0 deg"),
    ):
        open_ = cylinder[name]
        assert (open_["isNull"], open_["nullValue"], open_["expression"]) == (False, empty, zero)


def test_a_broken_mate_has_one_entity_and_a_redundant_one_two_but_neither_is_in_the_tree() -> None:
    kit = Kit()
    post, door = kit.place("Post", fixed=True), kit.place("Door")
    kit.root.revolute("Hinge", (door, ON), (post, OFF), 0.3)
    up = frame((0, 0, 0.5))
    kit.root.revolute("Second", (post, OFF @ up), (door, ON @ up), redundant=True)
    kit.root.revolute("Lost", (door, ON), (post, OFF), broken=True)
    truth = kit.document.truth
    assert [edge.name for edge in truth.joints] == ["Hinge"]
    assert [edge.name for edge in truth.redundant] == ["Second"]
    assert truth.saved == pytest.approx({"Hinge": 0.3, "Second": -0.3})
    for value in (-1.0, 2.0):
        assert truth.redundant[0].error(truth.poses({"Hinge": value})) == pytest.approx(
            np.zeros(6), abs=1e-12
        )
    written = definition(kit.document)["rootAssembly"]["features"]
    assert [len(one["featureData"]["matedEntities"]) for one in written] == [2, 2, 1]
    other = truth.cut_at((), redundant={"Hinge"})
    assert other.poses({"Second": 1.0})[door.path] == pytest.approx(truth.poses({"Hinge": -1.0})[door.path])


def test_a_second_hinge_beside_the_first_one_s_axis_is_not_redundant() -> None:
    kit = Kit()
    post, door = kit.place("Post", fixed=True), kit.place("Door")
    kit.root.revolute("Hinge", (door, ON), (post, OFF), 0.3)
    kit.root.revolute("Second", (post, OFF @ frame((0.1, 0, 0))), (door, ON), redundant=True)
    with pytest.raises(ValueError, match="'Second' is open"):
        kit.document.truth.check()


def test_relations_follow_one_rule() -> None:
    kit = Kit()
    base, *bars = (kit.place(f"Bar {n}") for n in range(6))
    turns = [kit.root.revolute(f"T{n}", (bars[n], ON), (base, ON)) for n in range(2)]
    slides = [kit.root.slider(f"S{n}", (bars[2 + n], ON), (base, ON)) for n in range(2)]
    bolt = kit.root.cylindrical("Bolt", (bars[4], ON), (base, ON), (-0.0025, math.pi))
    kit.root.gear("Gear", *turns, 2.0)
    kit.root.linear("Linear", *slides, 0.5, reverse=True)
    kit.root.rack("Rack", turns[0], slides[0], 0.1)
    kit.root.rack("Pinion", slides[1], turns[1], 0.1, reverse=True)
    kit.root.screw("Screw", bolt, 0.005)
    truth = kit.document.truth
    found = {r.name: (r.driver, r.follower, pytest.approx(r.multiplier)) for r in truth.relations}
    assert found == {
        "Gear": ("T0", "T1", -2.0),
        "Linear": ("S0", "S1", 0.5),
        "Rack": ("T0", "S0", -0.1 / math.tau),
        "Pinion": ("S1", "T1", math.tau / 0.1),
        "Screw": ("Bolt_turn", "Bolt_slide", -0.005 / math.tau),
    }
    truth.check()
    written = {one["featureData"]["name"]: one["featureData"] for one in
               definition(kit.document, swap=["T0", "Bolt"])["rootAssembly"]["features"]}  # fmt: skip
    assert written["Screw"] == {
        "name": "Screw",
        "relationType": "SCREW",
        "relationLength": 0.005,
        "reverseDirection": False,
        "mates": [{"featureId": bolt.id, "occurrence": []}],
    }
    assert [written[n]["reverseDirection"] for n in ("Gear", "Linear", "Rack", "Pinion")] == [
        True,
        True,
        True,
        True,
    ]
    assert written["Linear"]["relationRatio"] == 0.5
    kit.root.gear("Bad", turns[0], slides[0])
    with pytest.raises(ValueError, match="0 freedoms of the kind turn"):
        _ = kit.document.truth


def test_loops_close_through_mates_of_every_type() -> None:
    """A coupler on a ball, a slot and a cylinder: errors leave the closing mate's own freedom out."""
    for kind, freedom in (("ball", QUAT), ("pin_slot", (0.02, 0.4)), ("planar", (0.01, 0.02, 0.4)),
                          ("cylindrical", (0.02, 0.4)), ("parallel", (0.1, 0.2, 0.3, 0.4))):  # fmt: skip
        kit = Kit()
        base, crank, rocker = kit.place("Base", fixed=True), kit.place("Crank"), kit.place("Rocker")
        kit.root.revolute("Drive", (crank, ON), (base, OFF), 0.2)
        kit.root.parallel("Hold", (rocker, ON), (base, OFF), (0.1, 0.0, 0.0, 0.1))
        poses = kit.document.truth.poses()
        there = poses[crank.path] @ ON @ related(kind, freedom)
        getattr(kit.root, kind)(
            "Close", (rocker, inverse(poses[rocker.path]) @ there), (crank, ON), closing=True
        )
        truth = kit.document.truth
        truth.check()
        for name, value in truth.tree.by_dof(truth.joint("Close"), freedom).items():
            assert truth.saved[name] == pytest.approx(value, abs=1e-9)
        if kind != "planar":  # the plane's own tilt meets it nowhere else
            closed = truth.close({"Drive": 0.25}, held=["Drive"])
            assert closed["Drive"] == 0.25
            assert np.abs(truth.loop_errors(closed)["Close"]).max() < 1e-8


def test_a_ball_joins_the_world(tmp_path) -> None:
    kit = Kit()
    arm = kit.place("Arm")
    kit.root.ball("Ball", (arm, ON), (ORIGIN, OFF), QUAT, limits=1.0)
    truth = kit.document.truth
    assert truth.poses()[arm.path] == pytest.approx(OFF @ related("ball", QUAT) @ inverse(ON), abs=1e-12)
    assert truth.mass_matrix().shape == (3, 3)
    mate = definition(kit.document)["rootAssembly"]["features"][0]["featureData"]
    assert [entity["matedOccurrence"] for entity in mate["matedEntities"]] == [list(arm.path), []]
    # With the arm held the world moves about it: gravity does no work on what is held.
    assert truth.gravity_torque(root=arm.path) == pytest.approx(np.zeros(3), abs=1e-15)
