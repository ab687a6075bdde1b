"""What holds the copies of a pattern: the body that holds their seed, at whatever level."""

import numpy as np
import pytest

from linkwright.stages.graph.section import DepthSection
from tests.fake_onshape.frames import frame
from tests.support.kit import SIDE, TOP, Kit
from tests.support.patterned import PLANE, bodies_of, copies, displacement, draw, drawn, mated, wheeled


def _capped(cap: tuple[str, ...], arm: tuple[str, ...], kind: str):
    """A mate or a group more, of a cap on the seed."""

    def edit(root: dict) -> None:
        if kind == "group":
            members = [{"occurrence": list(path)} for path in (cap, arm)]
            group = {"id": "cap", "featureType": "mateGroup", "featureData": {"name": "Cap"}}
            group["featureData"]["occurrences"] = members
            root["features"].append(group)
            return
        mated(cap)(root)
        own = root["features"][-1]["featureData"]
        own["mateType"] = kind
        own["matedEntities"][1]["matedOccurrence"] = list(arm)

    return edit


@pytest.mark.parametrize("kind", ["FASTENED", "SLIDER", "group"])
@pytest.mark.parametrize("mirror", ["joints", "weld"])
def test_a_copy_does_not_hold_what_hangs_on_its_seed(kit: Kit, kind: str, mirror: str) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    cap = kit.place("Cap")
    ((second,),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, log = drawn(kit, mirror, edit=_capped(cap.path, arm.path, kind))
    bodies = bodies_of(assembly, log)
    (copy,) = copies(assembly)
    assert {entity.path for entity in copy.entities} == {base.path, second.path}
    assert (bodies.of[cap.path] == bodies.of[arm.path]) == (kind != "SLIDER")
    assert bodies.of[cap.path] != bodies.of[second.path]


@pytest.mark.parametrize(("more", "held"), [(0, 2), (1, 1)])
def test_where_nothing_is_fixed_the_piece_with_the_most_parts_holds_a_seed(
    kit: Kit, more: int, held: int
) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    base.last.fixed = False
    cap = kit.place("Cap")
    for number in range(more):
        kit.root.fasten(f"Bolt {number}", (kit.place(f"Bolt {number}"), TOP), (base, SIDE))
    kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    assembly, _ = drawn(kit, edit=_capped(cap.path, arm.path, "SLIDER"))
    # Of two pieces of one size either may hold it: the copy hangs on both.
    assert len(copies(assembly)) == held


def test_a_copy_of_a_fixed_seed_is_held_by_its_mates_alone(kit: Kit) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [base], [frame((0.2, 0, 0))])
    assembly, _ = drawn(kit)
    (copy,) = copies(assembly)
    assert {entity.path for entity in copy.entities} == {arm.path, second.path}


def module(kit: Kit, inside: str = ""):
    """A sub-assembly in which a foot is patterned: held inside as said, and placed on a base by the root."""
    sub = kit.document.assembly("Module")
    frame_part, foot = kit.place("Frame", sub), kit.place("Foot", sub)
    if inside:
        getattr(sub, inside)("Inside", (foot, TOP), (frame_part, SIDE))
    ((second,),) = sub.pattern("Feet", [foot], [frame((0.2, 0, 0))])
    return sub, frame_part, foot, second


@pytest.mark.parametrize("kind", ["revolute", "fasten"])
@pytest.mark.parametrize("mirror", ["joints", "weld"])
def test_what_places_a_seed_from_above_places_its_copies_in_each_use(kit: Kit, kind, mirror) -> None:
    sub, frame_part, foot, second = module(kit)
    base = kit.place("Base", fixed=True)
    for number in (1, 2):
        one = kit.root.add(sub)
        kit.root.slider(f"Rail {number}", (one / frame_part, TOP), (base, frame((0, number, 0))))
        getattr(kit.root, kind)(f"Step {number}", (one / foot, TOP), (base, frame((0.1, number, 0))))
    (image,) = kit.root.mirror("Image", [one], PLANE)
    assembly, log = drawn(kit, mirror)
    bodies = bodies_of(assembly, log)
    feet = [path for path in assembly.occurrences if path[-1] == second.last.id]
    assert len(feet) == 3
    joint = kind == "revolute" and mirror == "joints"
    for path in feet:
        assert (bodies.of[path] == bodies.of[base.path]) == (not joint)
        moving = [mate for mate in bodies.moving if path in {entity.path for entity in mate.entities}]
        assert len(moving) == joint
        for mate in moving:
            assert np.abs(displacement(assembly, mate, 0.0) - np.eye(4)).max() < 1e-12
    assert not log.problems
    if joint:
        assert {mate.ref.copy for mate in copies(assembly) if mate.title.startswith("Step 2")} == {
            f"{one.last.id}/{second.last.id}", image.last.id, f"{image.last.id}/{second.last.id}",
        }  # fmt: skip


def test_copies_in_a_rigid_sub_assembly_need_nothing_from_above(kit: Kit) -> None:
    sub, frame_part, foot, second = module(kit)
    base = kit.place("Base", fixed=True)
    one = kit.root.add(sub)
    kit.root.revolute("Step", (one / foot, TOP), (base, TOP))
    assembly, log = drawn(kit, depth=DepthSection(rigid=("Module",)))
    assert not copies(assembly)
    bodies = bodies_of(assembly, log, depth=DepthSection(rigid=("Module",)))
    assert len({bodies.of[(one / part).path] for part in (frame_part, foot, second)}) == 1
    assert [mate.title for mate in bodies.moving] == ["Step"]


@pytest.mark.parametrize(("inside", "asked"), [("fasten", False), ("revolute", True)])
def test_what_holds_a_seed_inside_its_sub_assembly_goes_before_what_does_from_above(
    kit: Kit, inside: str, asked: bool
) -> None:
    sub, frame_part, foot, second = module(kit, inside)
    base = kit.place("Base", fixed=True)
    one = kit.root.add(sub)
    kit.root.revolute("Step", (one / foot, TOP), (base, TOP))
    assembly, log = drawn(kit)
    (copy,) = copies(assembly)
    assert {entity.path for entity in copy.entities} == {(one / frame_part).path, (one / second).path}
    told = [found for found in log.found if found.code == "W-PATTERN-LEVEL"]
    assert len(told) == asked
    for found in told:
        assert "Module <1>/Inside" in found.message
        assert "Step" in found.message
        assert "depth.rigid" in found.hint


@pytest.mark.parametrize("how", ["mate", "group", "through another seed"])
def test_a_fastened_seed_that_carries_a_joint_of_a_loop_leaves_the_loop_moving(kit: Kit, how: str) -> None:
    """A four-bar whose rocker turns on a bracket that is fastened to the base: the pattern repeats the
    bracket, not the rocker's hinge, which would freeze the four-bar."""
    base, bracket = kit.place("Base", fixed=True), kit.place("Bracket")
    crank, rocker, coupler = (kit.place(name) for name in ("Crank", "Rocker", "Coupler"))
    far, seeds = frame((0.1, 0, 0)), [bracket]
    carrier = bracket
    if how == "group":
        kit.root.group("Bolted", [(base, np.eye(4)), (bracket, far)])
    else:
        kit.root.fasten("Bolted", (bracket, np.eye(4)), (base, far))
    if how == "through another seed":
        carrier = kit.place("Bush")
        kit.root.fasten("Pressed", (carrier, np.eye(4)), (bracket, np.eye(4)))
        seeds.append(carrier)
    kit.root.revolute("Drive", (crank, np.eye(4)), (base, np.eye(4)), value=0.5)
    kit.root.revolute("Pin", (coupler, np.eye(4)), (crank, far), value=-0.5)
    kit.root.revolute("Swing", (rocker, np.eye(4)), (carrier, np.eye(4)), value=0.5)
    kit.root.revolute("Close", (coupler, far), (rocker, far), closing=True)
    copied = kit.root.pattern("Row", seeds, [frame((0, 0.3, 0))])
    assembly, log = drawn(kit)
    bodies = bodies_of(assembly, log)
    assert {bodies.of[copy.path] for (copy,) in copied} == {bodies.of[base.path]}
    assert sorted(mate.title for mate in bodies.moving) == ["Close", "Drive", "Pin", "Swing"]
    (told,) = (found for found in log.found if found.code == "I-PATTERN-CARRIED")
    assert (told.where, "Swing" in told.message) == ("Row", True)


def test_a_seed_whose_other_body_carries_the_joint_still_has_it_copied(kit: Kit) -> None:
    """The seed is a sub-assembly: its hub is fastened, its wheel turns on the hub and holds a rod."""
    corner, hub, wheel = wheeled(kit)
    base, rod = kit.place("Base", fixed=True), kit.place("Rod")
    one = kit.root.add(corner)
    kit.root.fasten("Bolted", (one / hub, SIDE), (base, TOP))
    kit.root.ball("Hook", (rod, TOP), (one / wheel, TOP), closing=True)
    kit.root.revolute("Far", (rod, SIDE), (base, frame((1, 0, 0))))
    kit.root.pattern("Row", [one], [frame((0, 0.3, 0))])
    assembly, _ = drawn(kit)
    assert sorted(mate.ref.name for mate in copies(assembly)) == ["Bolted <2>", "Hook <2>"]


def test_a_copy_that_only_carries_something_is_still_held_as_its_seed(kit: Kit) -> None:
    base, arm = draw(kit, "revolute", 0.4)
    ((second,),) = kit.root.pattern("Row", [arm], [frame((0.2, 0, 0))])
    cap = kit.place("Cap")
    assembly, log = drawn(kit, edit=_capped(cap.path, second.path, "SLIDER"))
    (copy,) = copies(assembly)
    assert {entity.path for entity in copy.entities} == {base.path, second.path}
    assert len(bodies_of(assembly, log).moving) == 3
