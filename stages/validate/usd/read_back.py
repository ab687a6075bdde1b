"""The run of the checks of a USD: no engine is needed, since its joints say where their frames are."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from stages.formats.usd.drives import drives_of
from stages.formats.usd.names import UsdNames, usd_names
from stages.formats.usd.zeros import ball_zeros
from stages.formats.written import Written
from stages.robot.check import Check, Finding
from stages.robot.inertia import SPECK
from stages.robot.kinematics import chain, link_poses
from stages.robot.model import Array, Configuration, Dof, Limits, Robot, Value
from stages.robot.plural import count
from stages.robot.poses import at_rest, from_parts, inverse, motion
from stages.robot.start_pose import HOME, home
from stages.validate.coordinates import SAME, distance, spread
from stages.validate.findings import few, named, shown, worst_first
from stages.validate.usd.driving import driving
from stages.validate.usd.model import moving, placed, rooted, shapes, units
from stages.validate.usd.places import places
from stages.validate.usd.reader import FreeRanges, ReadUsdJoint, UsdError, UsdRobot, read_usd

CODE = "C-USD"

SINGLE = 1e-5
"""UsdPhysics has masses and the frames of joints in single precision: the largest error, relative to the
robot's size or to the value where these are above 1."""

ARC_COSINE = 3e-8
"""Smaller turns [rad] USD may take for none: it finds the angle of a quaternion as 2 arccos w, and below 1
the nearest w stands for 2.98e-8 rad."""

TYPES = {"turn": "Revolute", "slide": "Prismatic", "ball": "Spherical"}


@dataclass(frozen=True, slots=True, eq=False)
class _Given:
    """`file`: its name; `usd`: what was read; `robot`: what it must be, with its `names` there. `zeros`: of
    balls whose joints turn on from there."""

    file: str
    usd: UsdRobot
    robot: Robot
    names: UsdNames
    home: Configuration
    zeros: Configuration

    def within(
        self, name: str, value: float, limit: float, detail: str, findings: Iterable[Finding] = ()
    ) -> Check:
        """The result of a check that passes where `value` is at most `limit`."""
        passed = value <= limit
        found = () if passed else few(findings)
        return Check(f"{self.file}: {name}", passed, detail, value, limit, findings=found)

    def poses(self, q: Configuration) -> dict[str, Array]:
        """world_from_link (4, 4) by the joints; what no joint holds stands where it does."""
        values = {self.names.joints[dof.name]: (dof, q[dof.name]) for dof in self.robot.dofs}
        above = {
            one.second: (name, one) for name, one in self.usd.joints.items() if one.first and not one.closes
        }
        found: dict[str, Array] = {}
        for body in self.usd.bodies:
            way = [body]
            # Joints that go round in a circle end where it closes.
            while way[-1] in above and way[-1] not in found and len(way) <= len(above):
                way.append(above[way[-1]][1].first)
            for one in reversed(way):
                if one in found:
                    continue
                if one not in above:
                    found[one] = self.usd.bodies[one].world_from_body
                    continue
                name, joint = above[one]
                moved = self.moved(joint, *values[name]) if name in values else np.eye(4)
                parent = found.get(joint.first, np.full((4, 4), np.nan))
                found[one] = parent @ joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
        return {name: found[body] for name, body in self.names.links.items()}

    def moved(self, joint: ReadUsdJoint, dof: Dof, value: Value) -> Array:
        """What a joint moves its frame by."""
        if dof.kind != "ball":
            return motion(dof.kind, joint.axis, value)
        zero = motion("ball", dof.axis, self.zeros.get(dof.name, at_rest("ball")))
        turned = joint.second_from_joint[:3, :3]
        relative = (inverse(zero) @ motion("ball", dof.axis, value))[:3, :3]
        return from_parts(turned.T @ relative @ turned, np.zeros(3))


def check_file(path: Path, written: Written, *, quick: bool) -> Iterator[Check]:
    """The results. `quick`: only whether it can be read. Where a
    body or joint is missing, the checks that look for each by its name are left out."""
    try:
        usd = read_usd(path)
    except UsdError as error:
        yield Check(f"{path.name}: reads", False, str(error))
        return
    yield Check(f"{path.name}: reads", True, "no errors")
    if quick:
        return
    robot = written.robot
    at_home = home(robot)
    names = usd_names(robot)
    given = _Given(path.name, usd, robot, names, at_home, ball_zeros(robot, at_home))
    complete = _bodies_and_joints(given)
    yield complete
    found = units(usd)
    yield given.within("units", float(len(found)), 0.0, "metres, kilograms, and z upwards", found)
    if complete.passed:
        for check in CHECKS:
            yield check(given)
        known = written.scene if robot.root.name != "world" else None
        place = dict(known.keyframes).get(HOME) if known is not None else None
        found = [
            *usd.flaws,
            *rooted(usd, robot, names),
            *placed(usd, robot, names, place),
            *moving(usd, robot, names, written.geometry),
        ]
        detail = "articulation, place, self-collision and pairs of bodies that do not collide"
        yield given.within("model", float(len(found)), 0.0, detail, found)
        drives = drives_of(robot, written.actuation, at_home)
        found = list(driving(usd, robot, names, drives, at_home))
        detail = "resistance, largest speed, state, drive and relations of each joint"
        yield given.within("drives", float(len(found)), 0.0, detail, found)
        found = list(places(usd, robot, names, written.sensing))
        yield given.within("frames", float(len(found)), 0.0, "frames and cameras on their bodies", found)
        if written.geometry is not None:
            found = list(shapes(usd, names, written.geometry, path.parent))
            total = count(len(written.geometry.shapes), "shape")
            detail = f"{total} of the robot, with their sizes and places, and what collides"
            yield given.within("shapes", float(len(found)), 0.0, detail, found)


def _bodies_and_joints(given: _Given) -> Check:
    """Every link and joint is there by name; of the others only bodies between joints and their joints."""
    names, usd = given.names, given.usd
    joints = {names.joints[dof.name] for dof in given.robot.dofs if dof.kind != "free"}
    joints |= {names.joints[one.name] for one in given.robot.joints if not one.dofs}
    joints |= {names.base} if given.robot.base.fixed else set()
    missing = sorted(({*names.links.values()} - usd.bodies.keys()) | (joints - usd.joints.keys()))
    added = {name for every in names.between.values() for name in every}
    extra = sorted(usd.bodies.keys() - {*names.links.values()} - added)
    detail = f"{count(len(usd.bodies), 'body', 'bodies')}, {count(len(usd.joints), 'joint')}"
    if missing:
        detail = f"missing: {', '.join(missing)}"
    elif extra:
        detail = f"not the robot's: {', '.join(extra)}"
    findings = [
        Finding(named("def", name), "name", "there is none of this name" if name in missing else "is no link")
        for name in (*missing, *extra)
    ]
    return given.within("bodies and joints", float(len(missing) + len(extra)), 0.0, detail, findings)


def _masses(given: _Given) -> Check:
    worst, where = 0.0, ""
    findings: list[tuple[float, Finding]] = []
    for link in given.robot.links:
        own = given.usd.bodies[given.names.links[link.name]].inertial
        expected = link.inertial if link.inertial.mass > 0 else SPECK
        size = float(np.abs(expected.inertia).max())
        every = {
            "physics:mass": abs(own.mass / expected.mass - 1),
            "physics:centerOfMass": float(np.abs(own.com - expected.com).max()),
            "physics:diagonalInertia": float(np.abs(own.inertia - expected.inertia).max()) / size,
        }
        off = max(every.values())
        if not off <= SINGLE:
            attribute = max(every, key=every.__getitem__)
            element = named("def", given.names.links[link.name])
            findings.append((off, Finding(element, attribute, f"is off by {shown(off)}")))
        if not off <= worst:
            worst, where = off, link.name
    detail = f"mass and inertia [relative] and centre of mass [m] of each link; worst: {where}"
    return given.within("masses", worst, SINGLE, detail, worst_first(findings))


def _stance(given: _Given) -> Check:
    expected = link_poses(given.robot, given.home)
    found = {name: given.usd.bodies[own].world_from_body for name, own in given.names.links.items()}
    detail = "bodies where they stand, against `home`"
    return _compared(given, "home", found, expected, SAME, detail, unresolved=ARC_COSINE)


def _motion(given: _Given) -> Check:
    still = {dof.name: given.home[dof.name] for dof in given.robot.dofs if dof.kind == "free"}
    checks = []
    for q in (given.home, *(spread(given.robot, turn) | still for turn in range(2))):
        detail = "links by their joints, at three configurations, against the robot's own kinematics"
        expected = link_poses(given.robot, q)
        checks.append(_compared(given, "motion", given.poses(q), expected, SINGLE, detail))
    return max(checks, key=lambda one: math.inf if one.value is None else one.value)


def _compared(
    given: _Given,
    name: str,
    found: Mapping[str, Array],
    expected: Mapping[str, Array],
    limit: float,
    detail: str,
    unresolved: float = 0.0,
) -> Check:
    """Poses relative to the root's. `unresolved`: turns [rad] that cannot be told from none."""
    root = given.robot.root.name
    from_root, worst, where = inverse(found[root]), 0.0, ""
    size = max(1.0, *(float(np.abs(pose[:3, 3]).max()) for pose in expected.values()))
    for link, pose in expected.items():
        value = distance(from_root @ found[link], pose, unresolved=unresolved) / size
        if not value <= worst:
            worst, where = (math.inf if math.isnan(value) else value), link
    attribute = "xformOp:transform" if name == "home" else "physics:localPos0, physics:localRot0"
    message = f"is {shown(worst)} m or rad from where the robot has it"
    finding = Finding(named("def", given.names.links.get(where, where)), attribute, message)
    return given.within(name, worst, limit, f"{detail} [m, rad]; worst: {where}", [finding])


def _joints(given: _Given) -> Check:
    wrong = []
    for one in given.robot.joints:
        for dof in one.dofs:
            if dof.kind != "free" and not _fits(given.usd.joints[given.names.joints[dof.name]], dof):
                wrong.append(dof.name)
        if not one.dofs and given.usd.joints[given.names.joints[one.name]].type != "Fixed":
            wrong.append(one.name)
    detail = f"differ: {', '.join(wrong)}" if wrong else "type and limits of each joint"
    message = "has another type or other limits than the robot's"
    attributes = "physics:lowerLimit, physics:upperLimit"
    findings = [Finding(named("def", given.names.joints[name]), attributes, message) for name in wrong]
    return given.within("joints", float(len(wrong)), 0.0, detail, findings)


def _fits(joint: ReadUsdJoint, dof: Dof) -> bool:
    low, high = dof.limits.interval if dof.kind != "ball" else Limits(None, dof.limits.upper).interval
    return joint.type == TYPES[dof.kind] and all(
        _alike(found, wanted) for found, wanted in zip(joint.ends, (low, high), strict=True)
    )


def _loops(given: _Given) -> Check:
    """Each loop is one joint outside the articulation, and along it the links are where the robot's mate puts
    them."""
    worst, where = 0.0, ""
    for loop in given.robot.loops:
        joint = given.usd.joints.get(given.names.joints.get(loop.name, ""))
        if joint is None or not joint.closes:
            # Its last joint, at the end of links between.
            joint = given.usd.joints.get(given.names.joints[loop.dofs[-1].name]) if loop.dofs else None
            value = 0.0 if joint is not None and joint.closes else math.inf
        else:
            q = {dof.name: _some(dof, number) for number, dof in enumerate(loop.dofs)}
            moved = np.eye(4)
            for dof in loop.dofs:
                axis = joint.axis if joint.type else dof.axis
                moved = moved @ motion(dof.kind, axis, q[dof.name])
            found = joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
            wanted = loop.b_from_frame @ chain(loop.dofs, q) @ inverse(loop.a_from_frame)
            value = distance(found, wanted)
            freed = {_freed(dof): _ends(dof) for dof in loop.dofs}
            if not joint.type and not _ranges_fit(joint.free, freed):
                value = math.inf
        if not value <= worst:
            worst, where = value, loop.name
    detail = f"joints of {count(len(given.robot.loops), 'loop')} [m, rad]; worst: {where}"
    message = f"is {shown(worst)} m or rad from the robot's loop, or is not one joint that closes it"
    finding = Finding(named("def", given.names.joints.get(where, where)), "physics:localPos0", message)
    return given.within("loops", worst, SINGLE, detail, [finding])


def _some(dof: Dof, number: int) -> Value:
    """Of a ball the one where it turns nothing: its joint holds the same whatever its axes."""
    return at_rest("ball") if dof.kind == "ball" else 0.3 + 0.1 * number


def _ends(dof: Dof) -> tuple[float, float]:
    """The range [m or rad] along the axis of the frame, to which the dof's own may be opposite."""
    low, high = dof.limits.interval
    return (low, high) if dof.axis.sum() > 0 else (-high, -low)


def _ranges_fit(found: FreeRanges, wanted: FreeRanges) -> bool:
    return found.keys() == wanted.keys() and all(
        _alike(one, other) for key in wanted for one, other in zip(found[key], wanted[key], strict=True)
    )


def _alike(found: float, wanted: float) -> bool:
    return found == wanted or abs(found - wanted) <= SINGLE * max(1.0, abs(wanted))


def _freed(dof: Dof) -> tuple[str, str]:
    """What a general joint leaves free for it."""
    return "rot" if dof.kind == "turn" else "trans", "XYZ"[int(np.abs(dof.axis).argmax())]


CHECKS: tuple[Callable[[_Given], Check], ...] = (_masses, _stance, _motion, _joints, _loops)
"""In the order of the report."""
