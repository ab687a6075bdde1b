"""What holds the copies of a pattern: the body that holds their seed, at whatever level."""

import numpy as np
import pytest

from linkwright.stages.graph.section import DepthSection
from tests.fake_onshape.frames import frame
from tests.support.kit import SIDE, TOP
from tests.support.patterned import PLANE, bodies_of, copies, displacement, draw, drawn, mated, wheeled
from tests.support.reported import notes, only


def paths(*mates):
    return {entity.path for mate in mates for entity in mate.entities}


def _capped(cap, arm, kind):
    """A mate or a group more, of a cap on the seed."""

    def edit(root):
        if kind == "group":
            data = {"name": "Cap", "occurrences": [{"occurrence": list(path)} for path in (cap, arm)]}
            root["features"].append({"id": "cap", "featureType": "mateGroup", "featureData": data})
            return
        mated(cap)(root)
        data = root["features"][-1]["featureData"]
        data["mateType"] = kind
        data["matedEntities"][1]["matedOccurrence"] = list(arm)

    return edit


def row(kit):
    """A base, an arm on it, and the copy of the arm."""
    base, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    return base, arm, second


@pytest.mark.parametrize("kind", ["FASTENED", "SLIDER", "group"])
@pytest.mark.parametrize("mirror", ["joints", "weld"])
def test_a_copy_does_not_hold_what_hangs_on_its_seed(kit, kind, mirror):
    base, arm, second = row(kit)
    cap = kit.place("Cap")
    assembly, log = drawn(kit, mirror, edit=_capped(cap.path, arm.path, kind))
    bodies = bodies_of(assembly, log)
    assert paths(*copies(assembly)) == {base.path, second.path}
    assert (bodies.of[cap.path] == bodies.of[arm.path]) == (kind != "SLIDER")
    assert bodies.of[cap.path] != bodies.of[second.path]


@pytest.mark.parametrize(("more", "held"), [(0, 2), (1, 1)])
def test_the_largest_piece_holds_a_seed_if_no_part_is_fixed(kit, more, held):
    base, arm, _ = row(kit)
    base.last.fixed = False
    cap = kit.place("Cap")
    for number in range(more):
        kit.root.fasten(f"Bolt {number}", (kit.place(f"Bolt {number}"), TOP), (base, SIDE))
    assembly, _ = drawn(kit, edit=_capped(cap.path, arm.path, "SLIDER"))
    # Of two pieces of one size either may hold it: the copy hangs on both.
    assert len(copies(assembly)) == held


def test_a_copy_of_a_fixed_seed_is_held_by_its_mates_alone(kit):
    base, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [base], [frame((0.2, 0, 0))])
    assert paths(*copies(drawn(kit)[0])) == {arm.path, second.path}


def module(kit, inside=""):
    """A sub-assembly in which a foot is patterned: held inside as said, and placed on a base by the root."""
    sub = kit.document.assembly("Module")
    frame_part, foot = kit.place("Frame", sub), kit.place("Foot", sub)
    if inside:
        getattr(sub, inside)("Inside", (foot, TOP), (frame_part, SIDE))
    ((second,),) = sub.pattern("Feet", [foot], [frame((0.2, 0, 0))])
    return sub, frame_part, foot, second


@pytest.mark.parametrize("kind", ["revolute", "fasten"])
@pytest.mark.parametrize("mirror", ["joints", "weld"])
def test_mates_from_above_place_copies_in_each_use(kit, kind, mirror):
    sub, frame_part, foot, second = module(kit)
    base = kit.place("Base", fixed=True)
    for number in (1, 2):
        sub_path = kit.root.add(sub)
        kit.root.slider(f"Rail {number}", (sub_path / frame_part, TOP), (base, frame((0, number, 0))))
        getattr(kit.root, kind)(f"Step {number}", (sub_path / foot, TOP), (base, frame((0.1, number, 0))))
    (image,) = kit.root.mirror("Image", [sub_path], PLANE)
    assembly, log = drawn(kit, mirror)
    bodies = bodies_of(assembly, log)
    feet = [path for path in assembly.occurrences if path[-1] == second.last.id]
    assert len(feet) == 3
    joint = kind == "revolute" and mirror == "joints"
    for path in feet:
        assert (bodies.of[path] == bodies.of[base.path]) == (not joint)
        moving = [mate for mate in bodies.moving if path in paths(mate)]
        assert len(moving) == joint
        for mate in moving:
            assert np.abs(displacement(assembly, mate, 0.0) - np.eye(4)).max() < 1e-12
    assert not log.problems
    names = (f"{sub_path.last.id}/{second.last.id}", image.last.id, f"{image.last.id}/{second.last.id}")
    steps = {mate.ref.copy for mate in copies(assembly) if mate.title.startswith("Step 2")}
    assert not joint or steps == set(names)


def test_copies_in_a_rigid_sub_assembly_need_nothing_from_above(kit):
    sub, frame_part, foot, second = module(kit)
    base = kit.place("Base", fixed=True)
    sub_path = kit.root.add(sub)
    kit.root.revolute("Step", (sub_path / foot, TOP), (base, TOP))
    assembly, log = drawn(kit, depth=DepthSection(rigid=("Module",)))
    assert not copies(assembly)
    bodies = bodies_of(assembly, log, depth=DepthSection(rigid=("Module",)))
    assert len({bodies.of[(sub_path / part).path] for part in (frame_part, foot, second)}) == 1
    assert [mate.title for mate in bodies.moving] == ["Step"]


@pytest.mark.parametrize(("inside", "reported"), [("fasten", False), ("revolute", True)])
def test_mates_of_a_seed_inside_go_before_those_from_above(kit, inside, reported):
    sub, frame_part, foot, second = module(kit, inside)
    base = kit.place("Base", fixed=True)
    sub_path = kit.root.add(sub)
    kit.root.revolute("Step", (sub_path / foot, TOP), (base, TOP))
    assembly, log = drawn(kit)
    assert paths(*copies(assembly)) == {(sub_path / frame_part).path, (sub_path / second).path}
    assert len(notes(log, "W-PATTERN-LEVEL")) == reported
    if reported:
        text = str(only(log, "W-PATTERN-LEVEL"))
        assert [word for word in ("Module <1>/Inside", "Step", "depth.rigid") if word not in text] == []


@pytest.mark.parametrize("remedy", ["none", "pattern what it carries", "mate the copy"])
def test_remedies_of_a_seed_that_is_held_on_two_levels(kit, remedy):
    sub = kit.document.assembly("Module")
    carried, foot = kit.place("Carried", sub), kit.place("Foot", sub)
    sub.revolute("Inside", (foot, TOP), (carried, SIDE))
    seeds = [foot, carried] if remedy == "pattern what it carries" else [foot]
    (copies_of_foot, *_) = sub.pattern("Feet", seeds, [frame((0.2, 0, 0))])
    if remedy == "mate the copy":
        sub.revolute("Own", (copies_of_foot[0], TOP), (carried, frame((0.2, 0, 0))), closing=True)
    base = kit.place("Base", fixed=True)
    kit.root.revolute("Step", (kit.root.add(sub) / foot, TOP), (base, TOP))
    _, log = drawn(kit)
    assert len(notes(log, "W-PATTERN-LEVEL")) == (remedy == "none")


@pytest.mark.parametrize("how", ["mate", "group", "through another seed"])
def test_a_fastened_seed_with_a_joint_leaves_loops_moving(kit, how):
    """A four-bar whose rocker turns on a bracket that is fastened to the base: the pattern repeats the
    bracket, not the rocker's hinge, which would freeze the four-bar."""
    base, bracket, crank, rocker, coupler = kit.based("Bracket", "Crank", "Rocker", "Coupler")
    far, seeds, here = frame((0.1, 0, 0)), [bracket], np.eye(4)
    if how == "group":
        kit.root.group("Bolted", [(base, here), (bracket, far)])
    else:
        kit.root.fasten("Bolted", (bracket, here), (base, far))
    if how == "through another seed":
        seeds.append(kit.place("Bush"))
        kit.root.fasten("Pressed", (seeds[-1], here), (bracket, here))
    kit.root.revolute("Drive", (crank, here), (base, here), value=0.5)
    kit.root.revolute("Pin", (coupler, here), (crank, far), value=-0.5)
    kit.root.revolute("Swing", (rocker, here), (seeds[-1], here), value=0.5)
    kit.root.revolute("Close", (coupler, far), (rocker, far), closing=True)
    copied = kit.root.pattern("Row", seeds, [frame((0, 0.3, 0))])
    assembly, log = drawn(kit)
    bodies = bodies_of(assembly, log)
    assert {bodies.of[copy.path] for (copy,) in copied} == {bodies.of[base.path]}
    assert sorted(mate.title for mate in bodies.moving) == ["Close", "Drive", "Pin", "Swing"]
    note = only(log, "I-PATTERN-CARRIED")
    assert (note.where, "Swing" in note.message) == ("Row", True)


def test_a_joint_on_another_body_of_a_seed_is_copied(kit):
    """The seed is a sub-assembly: its hub is fastened, its wheel turns on the hub and holds a rod."""
    corner, hub, wheel = wheeled(kit)
    base, rod = kit.place("Base", fixed=True), kit.place("Rod")
    corner_path = kit.root.add(corner)
    kit.root.fasten("Bolted", (corner_path / hub, SIDE), (base, TOP))
    kit.root.ball("Hook", (rod, TOP), (corner_path / wheel, TOP), closing=True)
    kit.root.revolute("Far", (rod, SIDE), (base, frame((1, 0, 0))))
    kit.root.pattern("Row", [corner_path], [frame((0, 0.3, 0))])
    assembly, _ = drawn(kit)
    assert sorted(mate.ref.name for mate in copies(assembly)) == ["Bolted <2>", "Hook <2>"]


def test_a_copy_that_carries_something_is_held_as_its_seed(kit):
    base, _, second = row(kit)
    cap = kit.place("Cap")
    assembly, log = drawn(kit, edit=_capped(cap.path, second.path, "SLIDER"))
    assert paths(*copies(assembly)) == {base.path, second.path}
    assert len(bodies_of(assembly, log).moving) == 3
