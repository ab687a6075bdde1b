"""Mirrors whose copies are instances of mirror-image parts, against mates that a designer draws on these."""

import re
from dataclasses import replace

import numpy as np
import orjson
import pytest
import yaml

from linkwright.stages.graph import build_robot
from linkwright.stages.robot.dynamics.mass_matrix import mass_matrix
from linkwright.stages.robot.errors import Disconnected
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.motion.kinematics import link_poses
from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.mates import MIRROR
from tests.support.building import bundle_of, plan_of, robot_of
from tests.support.kit import OFF, ON, SIDE, TOP
from tests.support.patterned import PLANE, codes, copies, displacement, drawn, expected
from tests.support.reported import only, reports
from tests.unit.graph.onshape.test_patterns import KINDS

STUDIO_PLANE = turn((0.0, 0.6, 0.8), 0.4, (0.01, -0.02, 0.03))
REFLECTION = PLANE @ MIRROR @ inverse(PLANE)
PART_REFLECTION = STUDIO_PLANE @ MIRROR @ inverse(STUDIO_PLANE)


def hook(kit, name, density=1000):
    """A part that no motion takes to its mirror image."""
    solid = solids.box(0.02, 0.03, 0.1) + solids.box(0.01, 0.03, 0.02, at=(0.03, 0.01, 0.05))
    return kit.studio.part(name, solid + solids.box(0.01, 0.01, 0.01, at=(0.0, 0.03, -0.02)), density=density)


def hooked(kit, kind="revolute", value=0.4, density=1000):
    """A fixed base with a hook on it by one mate."""
    base, arm = kit.place("Base", fixed=True), kit.root.add(hook(kit, "Arm", density))
    getattr(kit.root, kind)("Joint", (arm, TOP), (base, SIDE), value=value)
    return base, arm


@pytest.mark.parametrize("kind", KINDS)
def test_an_image_part_moves_as_its_seeds_mirror_image(kit, kind):
    saved, q = KINDS[kind]
    _, arm = hooked(kit, kind, saved)
    (copy,) = kit.root.mirror("Image", [arm], PLANE, STUDIO_PLANE)
    assembly, log = drawn(kit)
    assert np.linalg.det(assembly.occurrences[copy.path].world_from_occurrence) == pytest.approx(1)
    (mate,) = copies(assembly)
    (seed,) = (mate for mate in assembly.mates if not mate.ref.copy)
    image = REFLECTION @ displacement(assembly, seed, *q) @ inverse(REFLECTION)
    assert np.abs(displacement(assembly, mate, *q) - image).max() < 1e-12
    (joint,) = (joint for joint in kit.document.truth.joints if joint.copies)
    truth = expected(kit, copy.path, {joint.name: q if len(q) > 1 else q[0]})
    assert np.abs(image - truth).max() < 1e-12
    assert codes(log) == ["I-MIRROR", "I-PATTERN"]
    assert "Arm mirrored 1 <1>" in log.notes[0].message


@pytest.mark.parametrize("density", [1000, None])
@pytest.mark.parametrize("plane", [PLANE, frame(z=(0, 1, 0))])
def test_the_plane_is_found_with_and_without_material(kit, plane, density):
    _, arm = hooked(kit, density=density)
    kit.root.mirror("Image", [arm], plane, STUDIO_PLANE)
    assembly, log = drawn(kit)
    assert len(copies(assembly)) == 1
    written = yaml.safe_load(re.search("plane ({.*}):", log.notes[0].message)[1])
    assert np.abs(np.cross(written["normal"], plane[:3, 2])).max() < 1e-5
    assert plane[:3, 2] @ (written["xyz"] - plane[:3, 3]) == pytest.approx(0, abs=1e-6)


def symmetric_pair(kit, reflects):
    """An arm that reflects onto itself, and a hook; their mirror images by one mirror at y = 0."""
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    kit.root.revolute("Joint", (arm, turn((0.6, 0, 0.8), 0.4)), (base, turn((0, 0.6, 0.8), 0.4, (0, 0.2, 0))))
    seeds = [arm]
    if reflects:
        seeds.append(kit.root.add(hook(kit, "Hook")))
        kit.root.revolute("Other", (seeds[1], TOP), (base, OFF))
    return kit.root.mirror("Image", seeds, frame(z=(0, 1, 0)))


@pytest.mark.parametrize("reflects", [True, False])
def test_a_symmetric_part_moves_as_its_mirror_image(kit, reflects):
    """Its image is an instance of the same part, moved; so frames on it are others than on the seed."""
    arm, *_ = symmetric_pair(kit, reflects)
    turned = np.diag([1.0, -1.0, 1.0, 1.0])

    def moved(root):
        (place,) = (place for place in root["occurrences"] if tuple(place["path"]) == arm.path)
        place["transform"] = (np.reshape(place["transform"], (4, 4)) @ turned).ravel().tolist()

    assembly, _ = drawn(kit, edit=moved)
    mate = next(mate for mate in copies(assembly) if mate.ref.copy == arm.last.id)
    truth = expected(kit, arm.path, {"Joint [Image 1]": 1.1})
    assert np.abs(displacement(assembly, mate, 1.1) - truth).max() < 1e-12


def is_moved(kit, assembly, path, mate, amount, owner=()):
    """Whether a copied mate moves its copy as the document's own copied joint does."""
    joints = [joint for joint in kit.document.truth.joints if joint.copies and joint.owner == owner]
    truth = expected(kit, path, {joints[0].name: amount})
    assert len(joints) == 1
    assert np.abs(displacement(assembly, mate, amount) - truth).max() < 1e-12


def test_an_image_that_matter_does_not_show_is_named(kit):
    _, arm = hooked(kit)
    (image,) = kit.root.mirror("Image", [arm], frame((0, 0.2, 0), z=(0, 1, 0)), STUDIO_PLANE)
    image.last.source.solid += solids.box(0.02, 0.02, 0.02, at=(0, 0.05, 0.1))
    kit.document.changed()
    assembly, log = drawn(kit)
    assert (copies(assembly), reports(log)) == ([], [("W-PATTERN", "Image")])
    with pytest.raises(Disconnected) as raised:
        robot_of(kit.document)
    assert [problem.code for problem in raised.value.problems] == ["W-PATTERN", "E-LOOSE"]
    line = yaml.safe_load(re.search("mirrors: .*", only(log).hint)[0])
    assembly, log = drawn(kit, **line)
    assert len(copies(assembly)) == 1
    assert codes(log) == ["W-MIRROR-PLANE", "I-MIRROR", "I-PATTERN"]
    assembly, log = drawn(kit, mirrors={"Image": {"normal": [0, 2, 0], "xyz": [1, 0.2, 3]}})
    is_moved(kit, assembly, image.path, copies(assembly)[0], 1.2)


def test_planes_without_a_mirror_and_other_patterns_are_reported(kit):
    _, arm = hooked(kit)
    kit.root.mirror("Image", [arm], PLANE, STUDIO_PLANE)
    _, log = drawn(kit, mirrors={"Imag": {"normal": [0, 1, 0]}})
    assert reports(log)[0] == ("E-GLOB", "mirrors")

    def circular(root):
        root["parametricInstances"][0]["type"] = "Circular pattern"

    assembly, log = drawn(kit, edit=circular)
    assert (copies(assembly), codes(log)) == ([], ["W-PATTERN"])
    assert "mirrors" not in log.notes[0].hint


def test_a_mirror_in_a_sub_assembly_has_its_plane_there(kit):
    cart = kit.document.assembly("Cart")
    axle, arm = kit.place("Axle", cart), cart.add(hook(kit, "Arm"))
    cart.revolute("Spin", (arm, TOP), (axle, SIDE), value=0.3)
    (image,) = cart.mirror("Image", [arm], PLANE, STUDIO_PLANE)
    base = kit.place("Base", fixed=True)
    for number in range(2):
        cart_path = kit.root.add(cart)
        kit.root.slider(f"Rail {number}", (cart_path / axle, ON), (base, OFF), value=0.1 * number)
    plane = {"normal": list(PLANE[:3, 2]), "xyz": list(PLANE[:3, 3])}
    for mirrors in ({}, {"Cart <*>/Image": plane}):
        assembly, log = drawn(kit, mirrors=mirrors)
        assert (len(copies(assembly)), log.problems) == (2, [])
        for mate in copies(assembly):
            is_moved(kit, assembly, (*mate.ref.owner, image.last.id), mate, 1.2, mate.ref.owner)


def leg(kit, name, image):
    """A sub-assembly of four hooks, two of them fastened, with a turn and a slide; its first part.

    `image`: of the mirror-image parts, with the mates that a designer draws on these.
    """
    sub = kit.document.assembly(name)
    parts = [kit.document.part(f"Leg {number}") for number in range(4)]
    hip, plate, shin, foot = (
        sub.add(kit.studio.image(part, PART_REFLECTION) if image else part) for part in parts
    )

    def on(at):
        return PART_REFLECTION @ at @ MIRROR if image else at

    sub.fasten("Bolts", (plate, on(TOP)), (hip, on(OFF)))
    sub.revolute("Knee", (shin, on(ON)), (hip, on(SIDE)), 0.3, (-1.0, 2.0))
    slide, limits = (-0.02, (-0.05, 0.01)) if image else (0.02, (-0.01, 0.05))
    sub.slider("Ankle", (foot, on(TOP)), (shin, on(OFF)), slide, limits)
    return sub, hip


def legs(kit):
    """A base with a leg and a hook, and their mirror images, all by mates: the former and the latter."""
    for number in range(4):
        hook(kit, f"Leg {number}", density=1000 + 300 * number)
    base, arm = kit.place("Base", fixed=True), hook(kit, "Arm")
    (sub, hip), (twin, twin_hip) = leg(kit, "Leg", image=False), leg(kit, "Twin", image=True)
    seeds = [kit.root.add(sub), kit.root.add(arm)]
    images = [kit.root.add(twin), kit.root.add(kit.studio.image(arm, PART_REFLECTION))]
    kit.root.revolute("Hip", (seeds[0] / hip, TOP), (base, OFF), 0.5, (-0.7, 1.2))
    kit.root.revolute("Wrist", (seeds[1], ON), (base, SIDE), -0.2)
    for name, place, at, there, value, limits in (
        ("Hip 2", images[0] / twin_hip, TOP, OFF, 0.5, (-0.7, 1.2)),
        ("Wrist 2", images[1], ON, SIDE, -0.2, (None, None)),
    ):
        ends = (place, PART_REFLECTION @ at @ MIRROR), (base, REFLECTION @ there @ MIRROR)
        kit.root.revolute(name, *ends, value, limits)
    return seeds, images


def as_a_mirror_leaves_it(bundle, seeds, images):
    """The replies as if a mirror had made the images: without their mates, with the mirror's record."""
    definition = orjson.loads(bundle.body(bundle.definition))
    root = definition["rootAssembly"]
    root["features"] = [
        feature for feature in root["features"] if not feature["featureData"]["name"].endswith(" 2")
    ]
    children = [
        {"seedOccurrence": seed.last.id, "instanceIds": [image.last.id]}
        for seed, image in zip(seeds, images, strict=True)
    ]
    mirror = {"id": "mirror", "type": "Mirror", "name": "Mirror 1", "children": children}
    root["parametricInstances"] = [mirror]
    for sub in definition["subAssemblies"]:
        if sub["elementId"] == images[0].last.source.element:
            sub["features"] = []
    blobs = {**bundle.blobs, bundle.definition: orjson.dumps(definition)}
    return replace(bundle, blobs=blobs)


def coordinates(robot):
    """The parts of the child of each joint → the joint."""
    children = {link.name: tuple(sorted("/".join(part.path) for part in link.parts)) for link in robot.links}
    return {children[joint.child]: joint for joint in robot.joints}


def test_mirrored_legs_are_the_robot_that_mates_make(kit):
    """A mirrored sub-assembly of image parts, with joints inside it, and a mirrored part."""
    seeds, images = legs(kit)
    bundle, plan = bundle_of(kit.document), plan_of()
    by_mates = build_robot(bundle, plan)
    by_mirror = build_robot(as_a_mirror_leaves_it(bundle, seeds, images), plan)
    ours, theirs = coordinates(by_mirror), coordinates(by_mates)
    assert ours.keys() == theirs.keys()
    assert len(by_mirror.dofs) == len(by_mates.dofs) == 8
    pairs = [(joint.dofs[0], theirs[child].dofs[0]) for child, joint in ours.items()]
    slide = "/".join(images[0].path)
    turned = [joint.type == "prismatic" and child[0].startswith(slide) for child, joint in ours.items()]
    signs = np.where(turned, -1.0, 1.0)
    random = np.random.default_rng(3)
    rows = [by_mirror.dofs.index(dof) for dof, _ in pairs]
    order = [by_mates.dofs.index(dof) for _, dof in pairs]
    for _ in range(3):
        values = random.uniform(-0.5, 0.5, len(ours))
        q = {dof.name: value for (dof, _), value in zip(pairs, values, strict=True)}
        true_q = {dof.name: value for (_, dof), value in zip(pairs, signs * values, strict=True)}
        poses, true_poses = part_poses(by_mirror, q), part_poses(by_mates, true_q)
        assert poses.keys() == true_poses.keys()
        for path, pose in poses.items():
            assert np.abs(pose - true_poses[path]).max() < 1e-9
        mass = mass_matrix(by_mirror, q)[np.ix_(rows, rows)]
        truth = mass_matrix(by_mates, true_q)[np.ix_(order, order)] * np.outer(signs, signs)
        assert np.abs(mass - truth).max() < 1e-9
    for (dof, true), reversed_ in zip(pairs, turned, strict=True):
        low, high = true.limits.lower, true.limits.upper
        assert (dof.limits.lower, dof.limits.upper) == ((-high, -low) if reversed_ else (low, high))


def part_poses(robot, q):
    poses = link_poses(robot, q)
    return {
        part.path: robot.world_from_root @ poses[link.name] @ part.link_from_part
        for link in robot.links
        for part in link.parts
    }
