"""Which sub-assemblies move inside, what carries their frames, the origin as a body, hidden instances."""

import numpy as np
import orjson
import pytest

from linkwright.stages.graph.onshape.bodies import find_bodies
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.hidden import without_hidden
from linkwright.stages.graph.section import DepthSection, GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import AssemblyError
from tests.fake_onshape.definition import definition
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import frame
from tests.support.building import plan_of, robot_of
from tests.support.kit import SIDE, TOP, Kit
from tests.support.reported import codes, only, reports


def read(kit, edit=None):
    data = definition(kit.document)
    if edit:
        edit(data)
    return read_assembly(orjson.dumps(data))


def joined(kit, edit=None, welds=(), **depth):
    log = Diagnostics()
    assembly = read(kit, edit)
    return find_bodies(assembly, GraphSections(depth=DepthSection(**depth)), log, welds), log


@pytest.fixture
def nested(kit):
    """An arm with a gripper of two fingers inside, used twice: three levels, four joints each."""
    finger = kit.document.assembly("Finger")
    nail, tip = kit.place("Nail", finger), kit.place("Tip", finger)
    finger.revolute("Bend", (tip, TOP), (nail, SIDE))
    gripper = kit.document.assembly("Gripper")
    palm, left = kit.place("Palm", gripper), gripper.add(finger)
    gripper.slider("Close", (left / nail, TOP), (palm, SIDE))
    arm = kit.document.assembly("Fore arm")
    bone, hand = kit.place("Bone", arm), arm.add(gripper)
    arm.revolute("Wrist", (hand / palm, TOP), (bone, SIDE))
    base = kit.place("Base", fixed=True)
    for number in (1, 2):
        arm_path = kit.root.add(arm)
        kit.root.revolute(f"Elbow {number}", (arm_path / bone, TOP), (base, frame((number, 0, 0))))
    return kit


def titles(kept):
    """The joints inside both arms whose titles pass."""
    inside = ("Wrist", "Gripper <1>/Close", "Gripper <1>/Finger <1>/Bend")
    return [title for n in (1, 2) for rest in inside if kept(title := f"Fore arm <{n}>/{rest}")]


ALL, FIRST = titles(lambda title: True), titles(lambda title: "arm <1>" in title)
WRISTS, BENDS = titles(lambda title: "Wrist" in title), titles(lambda title: "Bend" in title)
ELBOWS = {"Elbow 1", "Elbow 2"}


def moving(bodies):
    return {mate.title for mate in bodies.moving}


@pytest.mark.parametrize(
    ("depth", "stay"),
    [
        ({}, ALL), ({"max": 3}, ALL), ({"max": 2}, [title for title in ALL if title not in BENDS]),
        ({"max": 1}, WRISTS), ({"max": 0}, []), ({"rigid": ["*"]}, []), ({"rigid": ["Fore arm"]}, []),
        ({"rigid": ["fore_arm"]}, [title for title in ALL if title not in FIRST]),
        ({"rigid": ["fore_arm_2"]}, FIRST), ({"rigid": ["Fore arm <2>"]}, FIRST),
        ({"rigid": ["*grip*"]}, WRISTS),
        ({"rigid": ["Fore arm <1>/*"]}, titles(lambda title: not title.startswith("Fore arm <1>/G"))),
        ({"rigid": ["*"], "flexible": ["*arm*"]}, WRISTS), ({"max": 0, "flexible": ["*"]}, ALL),
        ({"rigid": ["Fore arm"], "flexible": ["Finger"]}, BENDS),
    ],
    ids=str,
)  # fmt: skip
def test_depth_says_what_moves_inside(nested, depth, stay):
    bodies, log = joined(nested, **depth)
    assert moving(bodies) == {*stay, *ELBOWS}
    assert len(bodies.members) == 1 + len({*stay, *ELBOWS})
    assert not log.problems
    assert set(codes(log)) <= {"I-RIGID"}


def test_frozen_joints_are_counted_for_the_outermost_assembly(nested):
    _, log = joined(nested, max=1)
    counted = [(problem.where, problem.message.split(": ")[1]) for problem in log.notes]
    assert counted == [(f"Fore arm <{n}>/Gripper <1>", "2 joints inside it cannot move") for n in (1, 2)]


@pytest.mark.parametrize(("depth", "related"), [({}, 1), ({"max": 0}, 0)])
def test_a_relation_goes_with_the_joints_that_are_frozen(kit, depth, related):
    made, case, _ = motor(kit)
    made.revolute("Roll", (kit.place("Wheel", made), TOP), (case, SIDE))
    made.gear("Gear", *made.features)
    kit.root.fasten("Bolt", (kit.root.add(made) / case, TOP), (kit.place("Base", fixed=True), SIDE))
    robot = robot_of(kit.document, plan_of(depth=depth))
    assert len(robot.relations) == related
    assert set(codes(robot)) == ({"W-LIMIT"} if related else {"I-RIGID"})


def test_globs_that_fit_no_sub_assembly_list_them(nested):
    _, log = joined(nested, rigid=["Fore*", "leg"], flexible=["Base"])
    assert reports(log)[:2] == [("E-GLOB", "depth.rigid"), ("E-GLOB", "depth.flexible")]
    assert "Fore arm <1>/Gripper <1>/Finger <1>" in log.problems[0].hint
    assert "'leg'" in log.problems[0].message
    single = Kit()
    single.place("Base", fixed=True)
    assert reports(joined(single, rigid=["*"])[1]) == []
    assert reports(joined(single, rigid=["a*"])[1]) == [("E-GLOB", "depth.rigid")]


def motor(kit):
    """A motor whose two parts move against each other."""
    made = kit.document.assembly("Motor")
    case, horn = kit.place("Case", made), kit.place("Horn", made)
    made.revolute("Spin", (horn, TOP), (case, SIDE))
    return made, case, horn


def test_a_rigid_sub_assembly_can_be_held_as_a_whole(kit):
    made, _, _ = motor(kit)
    base, servo = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.revolute("Joint", (servo, TOP), (base, SIDE))
    problem = only(joined(kit)[1])
    assert (problem.code, problem.where) == ("E-MATE-SUBASSEMBLY", "Joint")
    assert "(Case <1>; Horn <1>)" in problem.message
    assert 'depth.rigid: ["Motor <1>"]' in problem.hint
    with pytest.raises(AssemblyError, match="E-MATE-SUBASSEMBLY Joint"):
        robot_of(kit.document)
    bodies, log = joined(kit, rigid=["Motor <1>"])
    assert (moving(bodies), reports(log)) == ({"Joint"}, [("I-RIGID", "Motor <1>")])


def test_a_part_fixed_inside_carries_its_sub_assemblys_frame(kit):
    made, case, _ = motor(kit)
    base, servo = kit.place("Base"), kit.root.add(made)
    kit.root.fix(servo / case)
    kit.root.revolute("Joint", (base, SIDE), (servo, TOP))
    bodies, log = joined(kit)
    assert reports(log) == []
    assert moving(bodies) == {"Joint", "Motor <1>/Spin"}
    assert bodies.members[bodies.world] == ((servo / case).path,)
    assert bodies.of[servo.path] == bodies.world


def test_a_sub_assembly_mated_to_its_origin_is_held_by_its_frame(kit):
    """As parts are to the root's: the frame stands for no part of its own, but for what it is fastened to."""
    made = kit.document.assembly("Carousel")
    arms = [kit.place(name, made) for name in ("One", "Two")]
    made.ground(arms[0], TOP)
    for number, arm in enumerate(arms):
        made.revolute(f"Turn {number}", (arm, TOP), (ORIGIN, np.eye(4)), closing=not number)
    base, wheel = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.fasten("Mount", (wheel, np.eye(4)), (base, TOP))
    bodies, log = joined(kit)
    assert reports(log) == []
    assert moving(bodies) == {"Carousel <1>/Turn 0", "Carousel <1>/Turn 1"}
    assert bodies.of[wheel.path] == bodies.of[base.path] == bodies.world
    assert len(bodies.members) == 3


@pytest.mark.parametrize("kind", ["revolute", "slider", "planar", "ball"])
def test_a_mate_to_the_origin_makes_it_a_body_of_its_own(kit, kind):
    base, arm = kit.elbow()
    base.last.fixed = False
    bodies, _ = joined(kit)
    assert (bodies.world, () in bodies.of, len(bodies.members)) == (None, False, 2)
    getattr(kit.root, kind)("Ground", (base, TOP), (ORIGIN, np.eye(4)))
    bodies, log = joined(kit)
    assert reports(log) == []
    assert bodies.members == [(), *sorted([(base.path,), (arm.path,)])]
    assert bodies.members[bodies.world] == ()
    assert (bodies.of[()], bodies.fixed_by) == (bodies.world, "")
    assert moving(bodies) == {"Ground", "Elbow"}


def test_a_mate_to_the_origin_holds_the_fixed_part(kit):
    base, arm = kit.based("Arm")
    kit.root.revolute("Ground", (arm, TOP), (ORIGIN, np.eye(4)))
    bodies, _ = joined(kit)
    assert bodies.members == sorted([(base.path,), (arm.path,)])
    assert bodies.of[()] == bodies.of[base.path] == bodies.world
    assert (bodies.fixed_by, moving(bodies)) == ("Base <1> is fixed", {"Ground"})


def test_welds_from_outside_join_bodies_without_a_report(kit):
    base, arm = kit.elbow()
    kit.root.revolute("Other", (arm, SIDE), (base, TOP), closing=True)
    bodies, log = joined(kit, welds=[(arm.path, base.path)])
    assert bodies.members == [tuple(sorted([base.path, arm.path]))]
    assert (bodies.moving, reports(log)) == ([], [])


def test_a_mate_inside_one_body_is_reported(kit):
    base, plate = kit.based("Plate")
    kit.root.fasten("Bolt", (plate, TOP), (base, TOP))
    kit.root.revolute("Stuck", (plate, SIDE), (base, SIDE), closing=True)
    bodies, log = joined(kit)
    assert (bodies.moving, reports(log)) == ([], [("W-MATE-RIGID", "Stuck")])
    assert codes(robot_of(kit.document)) == ["W-MATE-RIGID"]


def test_a_mate_of_an_unknown_type_is_refused_with_its_place(kit):
    def width(data):
        data["rootAssembly"]["features"][0]["featureData"]["mateType"] = "WIDTH"

    kit.elbow()
    assembly = read(kit, width)
    (problem,) = assembly.diagnostics
    assert (problem.code, problem.where, assembly.mates) == ("E-MATE-TYPE", "Elbow", [])
    assert "BALL" in problem.hint


def test_a_screw_names_one_mate_and_a_rack_has_a_length(kit):
    base, arm, cart, wheel = kit.based("Arm", "Cart", "Wheel")
    thread = kit.root.cylindrical("Thread", (arm, TOP), (base, SIDE))
    rail = kit.root.slider("Rail", (cart, TOP), (base, TOP))
    turn = kit.root.revolute("Pinion", (wheel, TOP), (base, frame((1, 0, 0))))
    kit.root.screw("Screw", thread, 0.002)
    kit.root.rack("Rack", turn, rail, 0.05)
    relations = {r.title: (len(r.mates), r.length) for r in read(kit).relations}
    assert relations == {"Screw": (1, 0.002), "Rack": (2, 0.05)}


def hidden(kit, *names):
    log = Diagnostics()

    def hide(data):
        ids = {i["id"] for i in data["rootAssembly"]["instances"] if i["name"] in names}
        for occurrence in data["rootAssembly"]["occurrences"]:
            if occurrence["path"][-1] in ids:
                occurrence["hidden"] = True
        relation = {"id": "relation", "featureType": "mateRelation", "featureData": {"relationType": "GEAR"}}
        for sub in data["subAssemblies"]:
            sub["features"].append(relation)

    return without_hidden(read(kit, hide), log), log


def test_hidden_instances_go_with_all_that_names_them(nested):
    arm = nested.root.instances[1]
    bolt = nested.place("Bolt")
    nested.root.group("Glue", [(nested.root.add(nested.bar("Plate")), np.eye(4)), (bolt, TOP)])
    assembly, log = hidden(nested, "Fore arm <1>", "Bolt <1>")
    assert all(path[0] not in (arm.id, bolt.path[0]) for path in assembly.occurrences)
    assert {mate.title for mate in assembly.mates} == {*ALL, "Elbow 2"} - {*FIRST}
    assert [len(group.members) for group in assembly.groups] == [1]
    assert {relation.owner[0] for relation in assembly.relations} == {nested.root.instances[2].id}
    note = only(log, "I-HIDDEN")
    words = ("2 hidden instances", "4 mates", "Bolt <1>", "Fore arm <1>")
    assert [word for word in words if word not in note.message] == []


def test_a_sub_assembly_whose_parts_are_all_hidden_goes_as_well(kit):
    made = kit.document.assembly("Cover")
    kit.place("Lid", made, hidden=True)
    base, cover = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.revolute("Hinge", (cover, TOP), (base, SIDE))
    log = Diagnostics()
    assembly = without_hidden(read(kit), log)
    assert set(assembly.occurrences) == {base.path}
    assert not assembly.mates
    assert "Cover <1>/Lid <1>" in log.notes[0].message


def test_an_assembly_that_is_all_hidden_has_no_parts(kit):
    kit.place("Base", fixed=True)
    with pytest.raises(AssemblyError, match="no parts"):
        hidden(kit, "Base <1>")


def test_hidden_instances_are_reported_by_name_up_to_ten(nested):
    assembly, log = hidden(nested)
    assert (reports(log), len(assembly.mates)) == ([], 8)
    for number in range(14):
        nested.place(f"Bolt {number:02}", hidden=True)
    message = only(hidden(nested)[1]).message
    assert (message.endswith("4 more"), message.count("Bolt")) == (True, 10)
