"""Names of the user's own for links and joints."""

import numpy as np
import pytest

from linkwright.stages.graph.mechanism import Connection, Marker, Mechanism, RelationSpec, RigidBody
from linkwright.stages.graph.onshape.mates.joints import dofs_of
from linkwright.stages.graph.passes.rename import rename_mechanism
from linkwright.stages.graph.section import NamesSection
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import MateRef, Provenance
from tests.support.reported import only

POSE = np.eye(4)


def body(name, *titles):
    return RigidBody(name, (name,), (), frozenset(titles), "", POSE)


def connection(name, mate_type, bodies, cad, title):
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
    return rename_mechanism(MECHANISM, NamesSection(links=links or {}, joints=joints or {}), log), log


def names_after(**names):
    """The names of links and of joints, of a renaming that is allowed."""
    made, log = called(**names)
    assert log.problems == []
    bodies, connections = ([thing.name for thing in group] for group in (made.bodies, made.connections))
    return bodies, connections


LINKS = ["base", "upper_arm_v2", "foot", "foot_2", "world"]
JOINTS = ["revolute_3", "piston", "leg_2_piston"]


@pytest.mark.parametrize("entry", ["base", "Base plate", "Base plate <1>", "Base*", "Arm <1>/*"])
def test_a_link_is_found_by_its_name_its_titles_or_a_glob(entry):
    assert names_after(links={entry: "trunk"}) == (["trunk", *LINKS[1:]], JOINTS)


def test_a_links_name_goes_before_globs_and_names_may_be_swapped():
    assert names_after(links={"foot": "left_foot"})[0][2:4] == ["left_foot", "foot_2"]
    assert names_after(links={"foot": "foot_2", "foot_2": "foot"})[0][2:4] == ["foot_2", "foot"]


@pytest.mark.parametrize("entry", ["piston", "Leg <1>/Piston"])
def test_a_joint_takes_its_dofs_and_bonds_with_it(entry):
    assert names_after(joints={entry: "drive"}) == (LINKS, ["revolute_3", "drive", "leg_2_piston"])
    made, _ = called(joints={entry: "drive", "Revolute 3": "elbow"})
    dofs = [[dof.name for dof in connection.dofs] for connection in made.connections]
    assert dofs[:2] == [["elbow"], ["drive_slide", "drive_turn"]]
    assert made.relations[0].connections == ("drive", "")


@pytest.mark.parametrize("entry", ["eye_mount", "eye*"])
def test_the_joint_that_holds_a_frame_is_renamed(entry):
    made, log = called(joints={entry: "mount"})
    assert log.problems == []
    assert [(marker.name, marker.joint) for marker in made.markers] == [("tip", ""), ("eye", "mount")]


@pytest.mark.parametrize(
    ("sections", "refusal"),
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
def test_a_name_that_cannot_be_given_is_reported(sections, refusal):
    problem = only(called(**sections)[1])
    assert (problem.code, problem.where) == refusal[:2]
    assert refusal[2] in f"{problem.message} {problem.hint}"
    assert problem.hint or "world" in problem.message
