"""Names of the user's own for links and joints."""

import numpy as np
import pytest

from linkwright.stages.graph.mechanism import Connection, Marker, Mechanism, RelationSpec, RigidBody
from linkwright.stages.graph.onshape.mates.joints import dofs_of
from linkwright.stages.graph.passes.rename import renamed
from linkwright.stages.graph.section import NamesSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import MateRef, Provenance

POSE = np.eye(4)


def body(name: str, *titles: str) -> RigidBody:
    return RigidBody(name, (name,), (), frozenset(titles), "", POSE)


def connection(name: str, mate_type: str, bodies: tuple[int, int], cad: str, title: str) -> Connection:
    kind = {"REVOLUTE": "revolute", "CYLINDRICAL": "cylindrical"}[mate_type]
    dofs = dofs_of(name, mate_type, {}, POSE)
    return Connection(name, kind, bodies, (POSE, POSE), dofs, 0.0, MateRef((), name, cad, mate_type), title)


MECHANISM = Mechanism(
    bodies=(
        body("base", "Base plate <1>", "Arm <1>/Base plate <1>"),
        body("upper_arm_v2", "Upper arm v2 <1>", "Upper arm v2"),
        body("foot", "Leg <1>/Foot <1>"),
        body("foot_2", "Leg <2>/Foot <1>", "foot <1>"),
        body("world"),
    ),
    connections=(
        connection("revolute_3", "REVOLUTE", (0, 1), "Revolute 3", "Revolute 3"),
        connection("piston", "CYLINDRICAL", (1, 2), "Piston", "Leg <1>/Piston"),
        connection("leg_2_piston", "CYLINDRICAL", (1, 3), "Piston", "Leg <2>/Piston"),
    ),
    relations=(RelationSpec("Screw", "SCREW", ("piston", ""), 1.0, 0.1, False),),
    markers=(Marker("tip", "Tip", 1, POSE, "Tip"), Marker("eye", "Eye", 1, POSE, "Eye", "eye_mount")),
    provenance=Provenance("d", "e", "m", ""),
)


def called(links=None, joints=None):
    log = Diagnostics()
    return renamed(MECHANISM, NamesSection(links=links or {}, joints=joints or {}), log), log


def links(mechanism):
    return [one.name for one in mechanism.bodies]


@pytest.mark.parametrize("entry", ["base", "Base plate", "Base plate <1>", "Base*", "Arm <1>/*"])
def test_a_link_is_found_by_its_name_its_titles_or_a_glob(entry):
    made, log = called({entry: "trunk"})
    assert log.problems == []
    assert links(made) == ["trunk", "upper_arm_v2", "foot", "foot_2", "world"]
    assert [one.name for one in made.connections] == [one.name for one in MECHANISM.connections]


def test_the_name_that_a_link_has_goes_before_globs_and_titles():
    made, log = called({"foot": "left_foot"})
    assert log.problems == []
    assert links(made)[2:4] == ["left_foot", "foot_2"]


def test_names_may_be_swapped():
    made, log = called({"foot": "foot_2", "foot_2": "foot"})
    assert log.problems == []
    assert links(made)[2:4] == ["foot_2", "foot"]


@pytest.mark.parametrize("entry", ["piston", "Leg <1>/Piston"])
def test_a_joint_takes_its_dofs_and_bonds_with_it(entry):
    made, log = called(joints={entry: "drive"})
    assert log.problems == []
    assert [one.name for one in made.connections] == ["revolute_3", "drive", "leg_2_piston"]
    assert [dof.name for dof in made.connections[1].dofs] == ["drive_slide", "drive_turn"]
    assert made.relations[0].connections == ("drive", "")
    assert links(made) == links(MECHANISM)


def test_the_dof_of_a_hinge_is_called_as_the_hinge():
    made, _ = called(joints={"Revolute 3": "elbow"})
    assert [dof.name for dof in made.connections[0].dofs] == ["elbow"]


@pytest.mark.parametrize("entry", ["eye_mount", "eye*"])
def test_the_joint_that_holds_a_frame_is_renamed(entry):
    made, log = called(joints={entry: "mount"})
    assert log.problems == []
    assert [(one.name, one.joint) for one in made.markers] == [("tip", ""), ("eye", "mount")]


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        ({"links": {"Head": "x"}}, ("E-RENAME", "names.links", "no link matches 'Head'")),
        ({"links": {"*Foot*": "x"}}, ("E-RENAME", "names.links", "2 links match '*Foot*'")),
        ({"joints": {"Piston": "x"}}, ("E-RENAME", "names.joints", "2 joints match 'Piston'")),
        ({"links": {"base": "x", "Base*": "y"}}, ("E-RENAME", "names.links", "is already renamed to 'x'")),
        ({"links": {"world": "x"}}, ("E-RENAME", "names.links", "always called 'world'")),
        ({"links": {"base": "Oberarm 1"}}, ("E-NAME", "names", "invalid name 'Oberarm 1'")),
        ({"links": {"base": "world"}}, ("E-NAME", "names", "'world' is reserved")),
        ({"links": {"base": "foot"}}, ("E-NAME", "names", "'foot' is taken")),
        ({"links": {"base": "tip"}}, ("E-NAME", "names", "'tip' is taken")),
        ({"links": {"base": "piston_turn"}}, ("E-NAME", "names", "'piston_turn' is taken")),
        ({"links": {"base": "x"}, "joints": {"Revolute 3": "x"}}, ("E-NAME", "names", "'x' is taken")),
        ({"joints": {"Revolute 3": "eye_mount"}}, ("E-NAME", "names", "'eye_mount' is taken")),
        ({"joints": {"Revolute 3": "leg_2_piston_slide"}}, ("E-NAME", "names", "_slide' is taken")),
    ],
)
def test_a_name_that_cannot_be_given_is_reported(asked, told):
    _, log = called(**asked)
    (problem,) = log.problems
    assert (problem.code, problem.where) == told[:2]
    assert told[2] in problem.message
    assert problem.hint or "world" in problem.message


def test_several_hits_are_listed():
    _, log = called({"*Foot*": "x"})
    assert log.problems[0].hint == "name one of: foot, foot_2"
