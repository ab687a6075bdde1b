"""Which sub-assemblies move inside, what carries their frames, the origin as a body, hidden instances."""

import numpy as np
import orjson
import pytest

from linkwright.stages.graph.onshape.assembly import Assembly
from linkwright.stages.graph.onshape.bodies import Bodies, find_bodies
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


def read(kit: Kit, edit=None) -> Assembly:
    data = definition(kit.document)
    if edit:
        edit(data)
    return read_assembly(orjson.dumps(data))


def found(kit: Kit, edit=None, welds=(), **depth) -> tuple[Bodies, Diagnostics]:
    log = Diagnostics()
    assembly = read(kit, edit)
    return find_bodies(assembly, GraphSections(depth=DepthSection(**depth)), log, welds), log


def told(log: Diagnostics) -> list[tuple[str, str]]:
    return [(one.code, one.where) for one in (*log.problems, *log.found)]


@pytest.fixture
def nested(kit: Kit):
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
        one = kit.root.add(arm)
        kit.root.revolute(f"Elbow {number}", (one / bone, TOP), (base, frame((number, 0, 0))))
    return kit


BOTH = [
    f"Fore arm <{n}>/{rest}"
    for n in (1, 2)
    for rest in ("Wrist", "Gripper <1>/Close", "Gripper <1>/Finger <1>/Bend")
]
ELBOWS = {"Elbow 1", "Elbow 2"}


def moving(bodies: Bodies) -> set[str]:
    return {mate.title for mate in bodies.moving}


@pytest.mark.parametrize(
    ("depth", "stay"),
    [
        ({}, BOTH),
        ({"max": 3}, BOTH),
        ({"max": 2}, [title for title in BOTH if "Bend" not in title]),
        ({"max": 1}, [title for title in BOTH if "Wrist" in title]),
        ({"max": 0}, []),
        ({"rigid": ["*"]}, []),
        ({"rigid": ["Fore arm"]}, []),
        ({"rigid": ["fore_arm"]}, [title for title in BOTH if "<2>" in title]),
        ({"rigid": ["fore_arm_2"]}, [title for title in BOTH if not title.startswith("Fore arm <2>")]),
        ({"rigid": ["Fore arm <2>"]}, [title for title in BOTH if not title.startswith("Fore arm <2>")]),
        ({"rigid": ["*grip*"]}, [title for title in BOTH if "Wrist" in title]),
        ({"rigid": ["Fore arm <1>/*"]}, [t for t in BOTH if not t.startswith("Fore arm <1>/G")]),
        ({"rigid": ["*"], "flexible": ["*arm*"]}, [title for title in BOTH if "Wrist" in title]),
        ({"max": 0, "flexible": ["*"]}, BOTH),
        ({"rigid": ["Fore arm"], "flexible": ["Finger"]}, [title for title in BOTH if "Bend" in title]),
    ],
    ids=str,
)
def test_depth_says_what_moves_inside(nested: Kit, depth, stay) -> None:
    bodies, log = found(nested, **depth)
    assert moving(bodies) == {*stay, *ELBOWS}
    assert len(bodies.members) == 1 + len({*stay, *ELBOWS})
    assert not log.problems
    assert {one.code for one in log.found} <= {"I-RIGID"}


def test_joints_that_rigid_sub_assemblies_freeze_are_counted_for_the_outermost(nested: Kit) -> None:
    _, log = found(nested, max=1)
    counted = [(one.where, one.message.split(": ")[1]) for one in log.found]
    assert counted == [(f"Fore arm <{n}>/Gripper <1>", "2 joints inside it cannot move") for n in (1, 2)]


@pytest.mark.parametrize(("depth", "related"), [({}, 1), ({"max": 0}, 0)])
def test_a_relation_goes_with_the_joints_that_a_rigid_sub_assembly_freezes(kit: Kit, depth, related) -> None:
    made, case, _ = motor(kit)
    wheel = kit.place("Wheel", made)
    made.revolute("Roll", (wheel, TOP), (case, SIDE))
    made.gear("Gear", *made.features)
    kit.root.fasten("Bolt", (kit.root.add(made) / case, TOP), (kit.place("Base", fixed=True), SIDE))
    robot = robot_of(kit.document, plan_of(depth=depth))
    assert len(robot.relations) == related
    assert {one.code for one in robot.diagnostics} == ({"W-LIMIT"} if related else {"I-RIGID"})


def test_globs_that_fit_no_sub_assembly_list_them(nested: Kit) -> None:
    _, log = found(nested, rigid=["Fore*", "leg"], flexible=["Base"])
    assert told(log)[:2] == [("E-GLOB", "depth.rigid"), ("E-GLOB", "depth.flexible")]
    assert "Fore arm <1>/Gripper <1>/Finger <1>" in log.problems[0].hint
    assert "'leg'" in log.problems[0].message


def test_a_star_fits_even_where_there_is_no_sub_assembly(kit: Kit) -> None:
    kit.place("Base", fixed=True)
    assert told(found(kit, rigid=["*"])[1]) == []
    assert told(found(kit, rigid=["a*"])[1]) == [("E-GLOB", "depth.rigid")]


def motor(kit: Kit):
    """A motor whose two parts move against each other."""
    made = kit.document.assembly("Motor")
    case, horn = kit.place("Case", made), kit.place("Horn", made)
    made.revolute("Spin", (horn, TOP), (case, SIDE))
    return made, case, horn


def test_a_rigid_sub_assembly_can_be_held_as_a_whole(kit: Kit) -> None:
    made, _, _ = motor(kit)
    base, servo = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.revolute("Joint", (servo, TOP), (base, SIDE))
    _, log = found(kit)
    (problem,) = log.problems
    assert (problem.code, problem.where) == ("E-MATE-SUBASSEMBLY", "Joint")
    assert "(Case <1>; Horn <1>)" in problem.message
    assert 'depth.rigid: ["Motor <1>"]' in problem.hint
    bodies, log = found(kit, rigid=["Motor <1>"])
    assert moving(bodies) == {"Joint"}
    assert told(log) == [("I-RIGID", "Motor <1>")]


def test_a_part_that_is_fixed_inside_carries_its_sub_assemblys_frame(kit: Kit) -> None:
    made, case, _ = motor(kit)
    base, servo = kit.place("Base"), kit.root.add(made)
    kit.root.fix(servo / case)
    kit.root.revolute("Joint", (base, SIDE), (servo, TOP))
    bodies, log = found(kit)
    assert told(log) == []
    assert moving(bodies) == {"Joint", "Motor <1>/Spin"}
    assert bodies.members[bodies.world] == ((servo / case).path,)
    assert bodies.of[servo.path] == bodies.world


def test_a_sub_assembly_is_held_by_its_frame_where_its_parts_are_mated_to_its_origin(kit: Kit) -> None:
    """As parts are to the root's: the frame stands for no part of its own, but for what it is fastened to."""
    made = kit.document.assembly("Carousel")
    arms = [kit.place(name, made) for name in ("One", "Two")]
    made.ground(arms[0], TOP)
    for number, arm in enumerate(arms):
        made.revolute(f"Turn {number}", (arm, TOP), (ORIGIN, np.eye(4)), closing=not number)
    base, wheel = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.fasten("Mount", (wheel, np.eye(4)), (base, TOP))
    bodies, log = found(kit)
    assert told(log) == []
    assert moving(bodies) == {"Carousel <1>/Turn 0", "Carousel <1>/Turn 1"}
    assert bodies.of[wheel.path] == bodies.of[base.path] == bodies.world
    assert len(bodies.members) == 3


@pytest.mark.parametrize("kind", ["revolute", "slider", "planar", "ball"])
def test_a_mate_to_the_origin_makes_it_a_body_of_its_own(kit: Kit, kind: str) -> None:
    base, arm = kit.place("Base"), kit.place("Arm")
    getattr(kit.root, kind)("Ground", (base, TOP), (ORIGIN, np.eye(4)))
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    bodies, log = found(kit)
    assert told(log) == []
    assert bodies.members == [(), *sorted([(base.path,), (arm.path,)])]
    assert bodies.members[bodies.world] == ()
    assert bodies.of[()] == bodies.world
    assert bodies.fixed_by == ""
    assert moving(bodies) == {"Ground", "Elbow"}


def test_a_mate_to_the_origin_holds_the_fixed_part_where_there_is_one(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Ground", (arm, TOP), (ORIGIN, np.eye(4)))
    bodies, _ = found(kit)
    assert bodies.members == sorted([(base.path,), (arm.path,)])
    assert bodies.of[()] == bodies.of[base.path] == bodies.world
    assert bodies.fixed_by == "Base <1> is fixed"
    assert moving(bodies) == {"Ground"}


def test_without_a_mate_to_it_the_origin_is_no_body(kit: Kit) -> None:
    base, arm = kit.place("Base"), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    bodies, _ = found(kit)
    assert bodies.world is None
    assert () not in bodies.of
    assert len(bodies.members) == 2


def test_welds_from_outside_join_bodies_and_their_mates_are_not_reported_again(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))
    kit.root.revolute("Other", (arm, SIDE), (base, TOP), closing=True)
    bodies, log = found(kit, welds=[(arm.path, base.path)])
    assert bodies.members == [tuple(sorted([base.path, arm.path]))]
    assert bodies.moving == []
    assert told(log) == []


def test_a_mate_inside_one_body_is_reported(kit: Kit) -> None:
    base, plate = kit.place("Base", fixed=True), kit.place("Plate")
    kit.root.fasten("Bolt", (plate, TOP), (base, TOP))
    kit.root.revolute("Stuck", (plate, SIDE), (base, SIDE), closing=True)
    bodies, log = found(kit)
    assert told(log) == [("W-MATE-RIGID", "Stuck")]
    assert bodies.moving == []


def test_a_mate_of_an_unknown_type_is_refused_with_its_place(kit: Kit) -> None:
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Elbow", (arm, TOP), (base, SIDE))

    def width(data) -> None:
        data["rootAssembly"]["features"][0]["featureData"]["mateType"] = "WIDTH"

    assembly = read(kit, width)
    (problem,) = assembly.diagnostics
    assert (problem.code, problem.where) == ("E-MATE-TYPE", "Elbow")
    assert "BALL" in problem.hint
    assert assembly.mates == []


def test_a_screw_names_one_mate_and_a_rack_has_a_length(kit: Kit) -> None:
    base, arm, cart = kit.place("Base", fixed=True), kit.place("Arm"), kit.place("Cart")
    thread = kit.root.cylindrical("Thread", (arm, TOP), (base, SIDE))
    rail = kit.root.slider("Rail", (cart, TOP), (base, TOP))
    turn = kit.root.revolute("Pinion", (kit.place("Wheel"), TOP), (base, frame((1, 0, 0))))
    kit.root.screw("Screw", thread, 0.002)
    kit.root.rack("Rack", turn, rail, 0.05)
    relations = {one.title: one for one in read(kit).relations}
    assert (len(relations["Screw"].mates), relations["Screw"].length) == (1, 0.002)
    assert (len(relations["Rack"].mates), relations["Rack"].length) == (2, 0.05)


def hidden(kit: Kit, *names: str) -> tuple[Assembly, Diagnostics]:
    log = Diagnostics()

    def hide(data) -> None:
        ids = {i["id"] for i in data["rootAssembly"]["instances"] if i["name"] in names}
        for occurrence in data["rootAssembly"]["occurrences"]:
            if occurrence["path"][-1] in ids:
                occurrence["hidden"] = True
        relation = {"id": "relation", "featureType": "mateRelation", "featureData": {"relationType": "GEAR"}}
        for sub in data["subAssemblies"]:
            sub["features"].append(relation)

    return without_hidden(read(kit, hide), log), log


def test_hidden_instances_go_with_all_below_and_all_that_names_them(nested: Kit) -> None:
    arm = nested.root.instances[1]
    bolt = nested.place("Bolt")
    nested.root.group("Glue", [(nested.root.add(nested.bar("Plate")), np.eye(4)), (bolt, TOP)])
    assembly, log = hidden(nested, "Fore arm <1>", "Bolt <1>")
    assert all(path[0] not in (arm.id, bolt.path[0]) for path in assembly.occurrences)
    assert {mate.title for mate in assembly.mates} == {t for t in BOTH if t.startswith("Fore arm <2>")} | {
        "Elbow 2"
    }
    assert [len(group.members) for group in assembly.groups] == [1]
    assert {relation.owner[0] for relation in assembly.relations} == {nested.root.instances[2].id}
    (one,) = log.found
    assert one.code == "I-HIDDEN"
    assert "2 hidden instances" in one.message
    assert "4 mates" in one.message
    assert "Bolt <1>" in one.message
    assert "Fore arm <1>" in one.message


def test_a_sub_assembly_whose_parts_are_all_hidden_goes_as_well(kit: Kit) -> None:
    made = kit.document.assembly("Cover")
    kit.place("Lid", made, hidden=True)
    base, cover = kit.place("Base", fixed=True), kit.root.add(made)
    kit.root.revolute("Hinge", (cover, TOP), (base, SIDE))
    log = Diagnostics()
    assembly = without_hidden(read(kit), log)
    assert set(assembly.occurrences) == {base.path}
    assert not assembly.mates
    assert "Cover <1>/Lid <1>" in log.found[0].message


def test_an_assembly_that_is_all_hidden_has_no_parts(kit: Kit) -> None:
    kit.place("Base", fixed=True)
    with pytest.raises(AssemblyError, match="no parts"):
        hidden(kit, "Base <1>")


def test_nothing_is_reported_where_nothing_is_hidden(nested: Kit) -> None:
    assembly, log = hidden(nested)
    assert not told(log)
    assert len(assembly.mates) == 8


def test_hidden_instances_are_reported_by_name_up_to_ten(kit: Kit) -> None:
    kit.place("Base", fixed=True)
    for number in range(14):
        kit.place(f"Bolt {number:02}", hidden=True)
    log = Diagnostics()
    without_hidden(read(kit), log)
    assert log.found[0].message.endswith("4 more")
    assert log.found[0].message.count("Bolt") == 10


@pytest.mark.slow
def test_large_assemblies_are_merged_in_time_linear_in_their_size() -> None:
    """Counted, not timed: looking up the root of an occurrence, the unit of all the work."""
    import networkx as nx

    counts = []
    for size in (200, 400):
        kit = Kit()
        unit = kit.document.assembly("Unit")
        case, horn = kit.place("Case", unit), kit.place("Horn", unit)
        unit.revolute("Spin", (horn, TOP), (case, SIDE))
        part, last = kit.bar("Link"), kit.place("Base", fixed=True)
        for number in range(size):
            one, more = kit.root.add(part), kit.root.add(unit)
            kit.root.revolute(f"Hinge {number}", (one, TOP), (last, SIDE))
            kit.root.fasten(f"Weld {number}", (more / case, TOP), (one, SIDE))
            last = one
        assembly = read(kit)
        calls = 0
        plain = nx.utils.UnionFind.__getitem__

        def counted(self, key, plain=plain):
            nonlocal calls
            calls += 1
            return plain(self, key)

        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(nx.utils.UnionFind, "__getitem__", counted)
            find_bodies(assembly, GraphSections(), Diagnostics())
        counts.append(calls)
    assert counts[1] < 2.1 * counts[0]
