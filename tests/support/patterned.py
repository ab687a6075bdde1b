"""Assemblies with patterns and mirrors, read as the graph stage reads them."""

import numpy as np
import orjson

from linkwright.stages.graph.onshape.bodies import find_bodies
from linkwright.stages.graph.onshape.definition import read_assembly
from linkwright.stages.graph.onshape.mass.part_solids import PartSolids
from linkwright.stages.graph.onshape.mates.joints import dofs_of, right_handed
from linkwright.stages.graph.onshape.patterns.instances import with_copies
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.motion.kinematics import chain
from tests.fake_onshape.definition import definition
from tests.fake_onshape.document import ORIGIN
from tests.fake_onshape.frames import turn
from tests.support.building import bundle_of
from tests.support.kit import SIDE, TOP

PLANE = turn((0, 1, 0), 1.1, (0.3, 0.1, 0))


def drawn(kit, mirror="joints", edit=None, shuffle=None, **keys):
    """The assembly with its copies, and what was told."""
    data = definition(kit.document, shuffle=shuffle)
    if edit:
        edit(data["rootAssembly"])
    log = Diagnostics()
    return copied(data, kit.document, GraphSections(mirror=mirror, **keys), log), log


def copied(data, document, keys, log):
    """The assembly of a definition, with the copies of its patterns; weighed as in the document."""
    assembly = read_assembly(orjson.dumps(data))
    return with_copies(assembly, keys, PartSolids(assembly, bundle_of(document)), log)


def bodies_of(assembly, log, **keys):
    return find_bodies(assembly, GraphSections(**keys), log)


def codes(log):
    return [problem.code for problem in (*log.problems, *log.notes)]


def copies(assembly):
    return [mate for mate in assembly.mates if mate.ref.copy]


def displacement(assembly, mate, *values):
    """How the world (4, 4) of the first entity's body moves from the saved pose, the second held."""
    first, second, mirrored = right_handed(*(assembly.world_from(entity) for entity in mate.entities))
    dofs = dofs_of("q", mate.ref.type, mate.limits or {}, inverse(second) @ first, mirrored)
    return second @ chain(dofs, dict(zip((dof.name for dof in dofs), values, strict=True))) @ inverse(first)


def expected(kit, path, q):
    return kit.document.truth.poses(q)[path] @ inverse(kit.document.truth.poses()[path])


def moves_right(kit, assembly, mate, path, joint, *q):
    """Whether a mate moves its copy as the document's own kinematics move it by this joint."""
    truth = expected(kit, path, {joint: q if len(q) > 1 else q[0]})
    assert np.abs(displacement(assembly, mate, *q) - truth).max() < 1e-12


def copied_joint(kit, count=1, owner=None):
    """The document's own name of the joint that was copied this often (of this sub-assembly)."""
    joints = [joint for joint in kit.document.truth.joints if len(joint.copies) == count]
    (joint,) = (joint for joint in joints if owner is None or joint.owner == owner)
    return str(joint.name)


def draw(kit, kind, value, **more):
    """A base, and an arm on it by one mate."""
    base, arm = kit.place("Base", fixed=True), kit.place("Arm")
    getattr(kit.root, kind)("Joint", (arm, TOP), (base, SIDE), value=value, **more)
    return base, arm


def wheeled(kit):
    """A sub-assembly of a hub fastened to its own origin, with a wheel that turns on it."""
    corner = kit.document.assembly("Corner")
    hub, wheel = kit.place("Hub", corner), kit.place("Wheel", corner)
    corner.ground(hub, SIDE)
    corner.fasten("Ground", (hub, np.eye(4)), (ORIGIN, SIDE), closing=True)
    corner.revolute("Spin", (wheel, TOP), (hub, SIDE), value=0.3)
    return corner, hub, wheel


def mated(path):
    """The first mate once more, with its first side on a copy."""

    def edit(root):
        feature = dict(root["features"][0], id="own mate")
        sides = [dict(side) for side in feature["featureData"]["matedEntities"]]
        sides[0]["matedOccurrence"] = list(path)
        feature["featureData"] = {**feature["featureData"], "name": "Own", "matedEntities": sides}
        root["features"].append(feature)

    return edit
