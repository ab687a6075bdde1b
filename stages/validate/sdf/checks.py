"""The checks of an SDF that was read back. What an engine would know is worked out from the file alone."""

import math
from collections.abc import Callable, Iterator

from stages.formats.sdf.kinematics import child_pose
from stages.formats.sdf.model import ReadJoint
from stages.robot.check import Check, Finding
from stages.robot.kinematics import chain, link_poses
from stages.robot.model import Configuration, Dof, Joint, Loop, Robot, Value
from stages.robot.plural import count
from stages.robot.poses import inverse
from stages.validate.coordinates import CAD_ERROR, SAME, distance, every_saved, spread
from stages.validate.findings import differs, named, shown, worst_first
from stages.validate.lumps import EXACT, UNITS, differences, expected_lump
from stages.validate.sdf.known import ReadSdf

TYPES = {"turn": ("revolute", "continuous"), "slide": ("prismatic",), "ball": ("ball",)}
"""What a dof is in an SDF."""


def links_and_joints(read: ReadSdf) -> Check:
    """Every link, joint and frame is there by name, and nothing else."""
    names, model = read.names, read.model
    joints = {names.joints[name] for one in _chains(read.robot) for name in _dofs(one)}
    links = {*names.links.values(), *(name for added in names.between.values() for name in added)}
    expected = links | joints | set(names.frames.values())
    expected |= {names.base} if read.robot.base.fixed else set()
    found = {*model.links, *model.joints, *model.frames}
    detail = f"{count(len(model.links), 'link')}, {count(len(model.joints), 'joint')}"
    if expected - found:
        detail = f"missing: {', '.join(sorted(expected - found))}"
    elif found - expected:
        detail = f"not the robot's: {', '.join(sorted(found - expected))}"
    return read.within("links and joints", float(len(expected ^ found)), 0.0, detail, _strays(read, expected))


def _strays(read: ReadSdf, expected: set[str]) -> Iterator[Finding]:
    """The names that are missing, then those that are not the robot's."""
    model, links = read.model, {*read.names.links.values()}
    for name in sorted(expected - {*model.links, *model.joints, *model.frames}):
        tag = "link" if name in links else "frame" if name in read.names.frames.values() else "joint"
        yield Finding(named(tag, name), "name", "there is none of this name")
    for tag, names in (("link", model.links), ("joint", model.joints), ("frame", model.frames)):
        for name in sorted(names.keys() - expected):
            yield Finding(named(tag, name), "name", "is not one of the robot's")


def masses(read: ReadSdf) -> Iterator[Check]:
    """As `stages.validate.checks.masses`, of what is read."""
    worst, where = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    findings: dict[str, list[tuple[float, Finding]]] = {key: [] for key in UNITS}
    for link in read.robot.links:
        own = read.model.links[read.names.links[link.name]].inertial
        found, expected = (own.mass, own.com, own.inertia), expected_lump(link)
        for place, (key, value) in enumerate(differences(found, expected).items()):
            if not value < worst[key]:
                worst[key], where[key] = value, link.name
            if not value <= EXACT:
                element = named("link", read.names.links[link.name])
                finding = differs(element, f"inertial {MASSES[key]}", found[place], expected[place])
                findings[key].append((value, finding))
    for name in (name for added in read.names.between.values() for name in added):
        mass = read.model.links[name].inertial.mass
        if not mass < worst["mass"]:
            worst["mass"], where["mass"] = mass, name
    for key, unit in UNITS.items():
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {where[key]}"
        yield read.within(key, worst[key], EXACT, detail, worst_first(findings[key]))


MASSES = {"mass": "mass", "centre of mass": "pose", "inertia": "inertia"}
"""What an inertial's elements are called that have these."""


def poses(read: ReadSdf) -> Iterator[Check]:
    """In the saved configuration every part is where CAD's occurrence has it."""
    robot = read.robot
    # What a free joint moves stands in an SDF where a fresh simulation has it.
    q = every_saved(robot) | _free(read)
    found, root_from_cad, worst, where = read.poses(q), inverse(robot.world_from_root), 0.0, ""
    held = _held(read)
    for link in robot.links:
        for part in link.parts if link.name in held else ():
            value = distance(found[link.name] @ part.link_from_part, root_from_cad @ part.world_from_part)
            if not value < worst:
                worst, where = value, part.name
    detail = f"parts against CAD's occurrences at the saved pose [m, rad]; worst: {where}"
    yield read.within("poses", worst, CAD_ERROR, detail, _placed(read, q))


def motion(read: ReadSdf) -> Iterator[Check]:
    """Links and frames, as the file has them and at values spread over those of the dofs."""
    worst, where = 0.0, ""
    for q in (read.stands, *(spread(read.robot, turn) | _free(read) for turn in range(3))):
        found, expected = read.poses(q), link_poses(read.robot, q)
        pairs = [(name, found[name], pose) for name, pose in expected.items()]
        for frame in read.robot.frames:
            own = read.model.frames[read.names.frames[frame.name]]
            in_link = inverse(read.model.links[own.link].model_from_link) @ own.model_from_frame
            link = next(name for name, one in read.names.links.items() if one == own.link)
            pairs.append((frame.name, found[link] @ in_link, expected[frame.link] @ frame.link_from_frame))
        for name, pose, wanted in pairs:
            value = distance(pose, wanted)
            value = math.inf if math.isnan(value) else value
            if value > worst:
                worst, where = value, name
    detail = "links and frames at four configurations against the robot's own kinematics [m, rad]; worst: "
    yield read.within("motion", worst, SAME, detail + where, _moved(read, where))


def _moved(read: ReadSdf, where: str) -> Iterator[Finding]:
    """`where`: the link or frame that is the furthest off."""
    found = list(_placed(read, *(spread(read.robot, turn) | _free(read) for turn in range(3))))
    yield from found or [_frame_finding(read, where)]


def _frame_finding(read: ReadSdf, where: str) -> Finding:
    tag = "frame" if where in read.names.frames else "link"
    name = read.names.frames.get(where) or read.names.links.get(where, where)
    return Finding(named(tag, name), "pose", "is not where the robot has it")


def _placed(read: ReadSdf, *values: Configuration) -> Iterator[Finding]:
    """The joints whose children are not on their parents as in the robot, parents first."""
    wrong: dict[str, Finding] = {}
    for q in values:
        found, expected = read.poses(q), link_poses(read.robot, q)
        for joint in read.robot.joints:
            own, wanted = (inverse(one[joint.parent]) @ one[joint.child] for one in (found, expected))
            if joint.type == "free" or distance(own, wanted) <= SAME:
                continue
            name = read.names.joints[(joint.dofs[0] if joint.dofs else joint).name]
            finding = Finding(
                named("joint", name), "pose, axis", "moves its child otherwise than the robot's"
            )
            wrong.setdefault(name, finding)
    yield from wrong.values()


def joints(read: ReadSdf) -> Iterator[Check]:
    """Type, limits, effort, velocity, damping and friction of each joint, of loops too."""
    wrong: dict[str, list[Finding]] = {}
    for one in _chains(read.robot):
        own = read.model.joints[read.names.joints[one.name]] if not one.dofs else None
        if own is not None and own.type != "fixed":
            wrong[one.name] = [differs(named("joint", own.name), "type", own.type, "fixed")]
        for dof in one.dofs:
            found = list(_differences(read, read.joint_of(dof), dof))
            wrong |= {dof.name: found} if found else {}
    detail = f"differ: {', '.join(wrong)}" if wrong else "type, limits, effort and dynamics of each joint"
    findings = [finding for every in wrong.values() for finding in every]
    yield read.within("joints", float(len(wrong)), 0.0, detail, findings)


def relations(read: ReadSdf) -> Iterator[Check]:
    """Each relation is the mimic of its follower, and there is no other."""
    mimics = {name: one.mimic for name, one in read.model.joints.items() if one.mimic is not None}
    names, wrong = read.names.joints, []
    for relation in read.robot.relations:
        mimic = mimics.pop(names[relation.follower], None)
        if mimic is None or mimic.joint != names[relation.driver]:
            wrong.append(relation.name)
            continue
        follower, driver = read.stands[relation.follower], read.stands[relation.driver]
        assert not isinstance(follower, tuple)
        assert not isinstance(driver, tuple)
        offset = mimic.offset - mimic.multiplier * mimic.reference
        expected = relation.offset + relation.multiplier * driver - follower
        scale = max(1.0, abs(relation.multiplier), abs(expected))
        off = max(abs(mimic.multiplier - relation.multiplier), abs(offset - expected))
        if off > SAME * scale:
            wrong.append(relation.name)
    wrong += sorted(mimics)
    detail = f"differ: {', '.join(wrong)}" if wrong else count(len(read.robot.relations), "relation")
    followers = {relation.name: names[relation.follower] for relation in read.robot.relations}
    message = "follows otherwise than the robot's, or not at all"
    findings = [Finding(named("joint", followers.get(name, name)), "mimic", message) for name in wrong]
    yield read.within("relations", float(len(wrong)), 0.0, detail, findings)


def loops(read: ReadSdf) -> Iterator[Check]:
    """Along the joints of each loop links are where the robot's chain puts them, wherever the tree is."""
    if not read.robot.loops:
        return
    worst, where = 0.0, ""
    for turn in range(2):
        q = spread(read.robot, turn) | _free(read)
        for loop in read.robot.loops:
            value = _off_along(read, loop, q)
            value = math.inf if math.isnan(value) else value
            if value > worst:
                worst, where = value, loop.name
    detail = f"joints of each loop against the robot's own kinematics [m, rad]; worst: {where}"
    loop = next((one for one in read.robot.loops if one.name == where), read.robot.loops[0])
    own = read.joints_of(loop)[0].name
    finding = Finding(named("joint", own), "pose, axis", f"is {shown(worst)} m or rad from the robot's loop")
    yield read.within("loops", worst, SAME, detail, [finding])


CHECKS: tuple[Callable[[ReadSdf], Iterator[Check]], ...] = (masses, poses, motion, joints, relations, loops)
"""In the order of the report."""


def _off_along(read: ReadSdf, loop: Loop, q: Configuration) -> float:
    """How far the link at the end of a loop's joints is from where the robot's chain implies it; infinite
    where the joints are no chain between its links."""
    poses, across = link_poses(read.robot, q), chain(loop.dofs, q)
    first, second = (read.names.links[name] for name in (loop.link_a, loop.link_b))
    found = read.joints_of(loop)
    backwards = found[-1].parent == first
    if backwards:
        found = found[::-1]
        begin, end = first, second
        implied = poses[loop.link_a] @ loop.a_from_frame @ inverse(across) @ inverse(loop.b_from_frame)
    else:
        begin, end = second, first
        implied = poses[loop.link_b] @ loop.b_from_frame @ across @ inverse(loop.a_from_frame)
    if not _is_chain(found, begin, end):
        return math.inf
    moved = read.moved(q, backwards=backwards, loop=loop)
    pose = poses[loop.link_a if backwards else loop.link_b]
    for joint in found:
        pose = child_pose(read.model, joint, pose, moved.get(joint.name))
    return distance(pose, implied)


def _is_chain(joints: list[ReadJoint], begin: str, end: str) -> bool:
    parents, children = [one.parent for one in joints], [one.child for one in joints]
    return [*parents, end] == [begin, *children]


def _chains(robot: Robot) -> list[Joint | Loop]:
    """What is joints in an SDF."""
    return [*(joint for joint in robot.joints if joint.type != "free"), *robot.loops]


def _dofs(one: Joint | Loop) -> list[str]:
    return [dof.name for dof in one.dofs] or [one.name]


def _differences(read: ReadSdf, joint: ReadJoint, dof: Dof) -> Iterator[Finding]:
    element = named("joint", joint.name)
    if joint.type not in TYPES[dof.kind]:
        yield differs(element, "type", joint.type, " or ".join(TYPES[dof.kind]))
        return
    if dof.kind == "ball":
        return  # SDF has nothing else of a ball
    limited = (dof.limits.lower, dof.limits.upper) != (None, None)
    if joint.type == "continuous" and limited:
        # Readers leave out the limits of such a joint.
        yield differs(element, "type", joint.type, "revolute")
    zero, own, wanted = read.stands[dof.name], joint.dynamics, dof.dynamics
    assert not isinstance(zero, tuple)
    for attribute, found, expected, start in (
        ("limit lower", joint.limits.lower, dof.limits.lower, zero),
        ("limit upper", joint.limits.upper, dof.limits.upper, zero),
        ("limit effort", own.effort, wanted.effort, 0.0),
        ("limit velocity", own.velocity, wanted.velocity, 0.0),
        ("dynamics damping", own.damping or 0.0, wanted.damping or 0.0, 0.0),
        ("dynamics friction", own.friction or 0.0, wanted.friction or 0.0, 0.0),
    ):
        if not _same(found, expected, start):
            yield differs(element, attribute, found, None if expected is None else expected - start)


def _same(found: float | None, wanted: float | None, zero: float) -> bool:
    if found is None or wanted is None:
        return found is wanted
    return abs(found + zero - wanted) <= SAME * max(1.0, abs(wanted))


def _free(read: ReadSdf) -> dict[str, Value]:
    """The values of free joints, which an SDF does not have: those of the file."""
    return {dof.name: read.stands[dof.name] for dof in read.robot.dofs if dof.kind == "free"}


def _held(read: ReadSdf) -> set[str]:
    """The links that no free joint is above of."""
    held = {read.robot.root.name}
    for joint in read.robot.joints:
        if joint.type != "free" and joint.parent in held:
            held.add(joint.child)
    return held
