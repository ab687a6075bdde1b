"""The robot of a USD, read by usd-core: its joints say where their frames are."""

from collections.abc import Iterator
from functools import partial
from pathlib import Path

import numpy as np

from linkwright.stages.formats.usd.drives import drives_of
from linkwright.stages.formats.usd.names import usd_names
from linkwright.stages.formats.usd.zeros import ball_zeros
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.inertia import SPECK
from linkwright.stages.robot.model.poses import at_rest, from_parts, inverse, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Loop, Value
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.start_pose import HOME, home
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named, shown
from linkwright.stages.validate.model.coordinates import SAME, distance
from linkwright.stages.validate.model.lumps import Lump
from linkwright.stages.validate.read.run import checks_by
from linkwright.stages.validate.same.found import (
    FormatWords,
    FoundJoint,
    FoundPlace,
    Names,
    Poses,
    Precision,
    ReadRobot,
    Tag,
    UnreadableFile,
)
from linkwright.stages.validate.usd.driving import driving
from linkwright.stages.validate.usd.model import moving, placed, rooted, shapes, units
from linkwright.stages.validate.usd.places import places
from linkwright.stages.validate.usd.reader import ReadUsdJoint, UsdError, read_usd

SINGLE = 1e-5
"""UsdPhysics has masses and the frames of joints in single precision: the largest error, relative to the
robot's size or to the value where these are above 1."""

ARC_COSINE = 3e-8
"""Smaller turns [rad] USD may take for none: it finds the angle of a quaternion as 2 arccos w, and below 1
the nearest w stands for 2.98e-8 rad."""

TYPES = {"turn": "Revolute", "slide": "Prismatic", "ball": "Spherical"}

WORDS = FormatWords(
    mass="physics:mass",
    com="physics:centerOfMass",
    inertia="",
    moments=("physics:diagonalInertia", "physics:principalAxes"),
    axis="physics:axis",
    place=("physics:localPos0", "physics:localRot0"),
    mimic=("", ""),
    numbers={
        "lower": "physics:lowerLimit",
        "upper": "physics:upperLimit",
        "cone": "physics:coneAngle0Limit",
    },
    tags=dict.fromkeys(("link", "joint", "frame"), "def"),
)


class ReadUsd(ReadRobot):
    """`usd`: what was read; `names`: of the robot's things there. Relations, and all else that a joint says,
    are compared by their attributes."""

    words = WORDS
    precision = Precision(SINGLE, SINGLE, SINGLE, sized=True, least=SPECK)

    def __init__(self, path: Path, written: Written) -> None:
        try:
            self.usd = read_usd(path)
        except UsdError as error:
            raise UnreadableFile(str(error)) from None
        self.file, self.path, self.written, self.robot = path.name, path, written, written.robot
        self.names, self.standing = usd_names(self.robot), home(self.robot)
        self.still = {dof.name: self.standing[dof.name] for dof in self.robot.dofs if dof.kind == "free"}
        self._zeros = ball_zeros(self.robot, self.standing)

    def element(self, tag: Tag, name: str) -> str:
        names = self.names.links if tag == "link" else self.names.joints
        return named("def", names.get(name, name))

    def found(self) -> Names:
        """Of joints those that it must have: which others there may be depends on the loops."""
        joints = self.expected()["joint"] & self.usd.joints.keys()
        between = {name for every in self.names.between.values() for name in every}
        return {"link": self.usd.bodies.keys() - between, "joint": joints}

    def expected(self) -> Names:
        own = self.names.joints
        joints = {own[dof.name] for dof in self.robot.dofs if dof.kind != "free"}
        joints |= {own[one.name] for one in self.robot.joints if not one.dofs}
        joints |= {self.names.base} if self.robot.base.fixed else set()
        return {"link": {*self.names.links.values()}, "joint": joints}

    def lump(self, link: str) -> Lump:
        own = self.usd.bodies[self.names.links[link]].inertial
        return own.mass, own.com, own.inertia

    def poses(self, q: Configuration) -> Poses:
        """By the joints; what no joint holds stands where it does. Frames have a check of their own."""
        values = {self.names.joints[dof.name]: (dof, q[dof.name]) for dof in self.robot.dofs}
        above = self._above()
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
                moved = self._moved(joint, *values[name]) if name in values else np.eye(4)
                parent = found.get(joint.first, np.full((4, 4), np.nan))
                found[one] = parent @ joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
        from_root = inverse(found[self.names.links[self.robot.root.name]])
        return Poses({name: from_root @ found[body] for name, body in self.names.links.items()}, {})

    def _above(self) -> dict[str, tuple[str, ReadUsdJoint]]:
        """By body, the joint of the tree that holds it, with its name."""
        joints = self.usd.joints.items()
        return {one.second: (name, one) for name, one in joints if one.first and not one.closes}

    def _moved(self, joint: ReadUsdJoint, dof: Dof, value: Value) -> Array:
        """What a joint moves its frame by: a ball turns on from its zero."""
        if dof.kind != "ball":
            return motion(dof.kind, joint.axis, value)
        zero = motion("ball", dof.axis, self._zeros.get(dof.name, at_rest("ball")))
        turned = joint.second_from_joint[:3, :3]
        relative = (inverse(zero) @ motion("ball", dof.axis, value))[:3, :3]
        return from_parts(turned.T @ relative @ turned, np.zeros(3))

    def parent(self, link: str) -> str:
        names, above = {own: name for name, own in self.names.links.items()}, self._above()
        own, steps = self.names.links[link], 0
        while own in above and (own not in names or not steps) and steps <= len(above):
            own, steps = above[own][1].first, steps + 1
        return names.get(own, "") if steps else ""

    def joints(self) -> Iterator[FoundJoint]:
        """Those of the tree."""
        for one in self.robot.joints:
            for dof in () if one.type == "free" else one.dofs or (None,):
                name = one.name if dof is None else dof.name
                own, element = self.usd.joints[self.names.joints[name]], self.element("joint", name)
                type_ = "Fixed" if dof is None else TYPES[dof.kind]
                ends = ("cone",) if type_ == "Spherical" else ("lower", "upper")
                numbers = {} if dof is None else dict(zip(ends, own.ends[-len(ends) :], strict=True))
                yield FoundJoint(name, element, own.type, (type_,), dof, numbers)

    def places(self, loop: Loop, q: Configuration) -> Iterator[FoundPlace]:
        """Each loop is one joint outside the articulation, along which the links are where the mate puts
        them; or, at the end of links between, its last one. Of a ball the value is the one where it turns
        nothing: its joint holds the same whatever its axes."""
        attributes = ("physics:localPos0", "physics:localRot0")
        own = self.names.joints.get(loop.name, "")
        joint, found, wanted = self.usd.joints.get(own), None, np.eye(4)
        if joint is None or not joint.closes:
            own = self.names.joints[loop.dofs[-1].name] if loop.dofs else own
            joint = self.usd.joints.get(own) if loop.dofs else None
            found = np.eye(4) if joint is not None and joint.closes else None
        elif joint.type or self._frees(joint, loop):
            q = {**q, **{dof.name: at_rest("ball") for dof in loop.dofs if dof.kind == "ball"}}
            moved = np.eye(4)
            for dof in loop.dofs:
                moved = moved @ motion(dof.kind, joint.axis if joint.type else dof.axis, q[dof.name])
            found = joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
            wanted = loop.b_from_frame @ chain(loop.dofs, q) @ inverse(loop.a_from_frame)
        yield FoundPlace(named("def", own or loop.name), attributes, found, wanted)

    def _frees(self, joint: ReadUsdJoint, loop: Loop) -> bool:
        """Whether a general joint leaves free what the loop does, within its limits."""
        wanted = {_freed(dof): _ends(dof) for dof in loop.dofs}
        return joint.free.keys() == wanted.keys() and all(
            one == other or abs(one - other) <= SINGLE * max(1.0, abs(other))
            for key in wanted
            for one, other in zip(joint.free[key], wanted[key], strict=True)
        )

    def first_checks(self) -> Iterator[Check]:
        yield self.found_none("units", "metres, kilograms, and z upwards", units(self.usd))

    def own_checks(self) -> Iterator[Check]:
        """What only a USD has."""
        usd, robot, names, written = self.usd, self.robot, self.names, self.written
        yield self._stance()
        scene = written.scene if robot.root.name != "world" else None
        place = dict(scene.keyframes).get(HOME) if scene is not None else None
        of_model = (
            *usd.flaws,
            *rooted(usd, robot, names),
            *placed(usd, robot, names, place),
            *moving(usd, robot, names, written.geometry),
        )
        detail = "articulation, place, self-collision and pairs of bodies that do not collide"
        yield self.found_none("model", detail, of_model)
        drives = drives_of(robot, written.actuation, self.standing)
        detail = "resistance, largest speed, state, drive and relations of each joint"
        yield self.found_none("drives", detail, driving(usd, robot, names, drives, self.standing))
        detail = "frames and cameras on their bodies"
        yield self.found_none("frames", detail, places(usd, robot, names, written.sensing))
        if written.geometry is not None:
            total = count(len(written.geometry.shapes), "shape")
            detail = f"{total} of the robot, with their sizes and places, and what collides"
            yield self.found_none("shapes", detail, shapes(usd, names, written.geometry, self.path.parent))

    def _stance(self) -> Check:
        """Bodies as they stand, without their joints, are where the robot is at `home`."""
        expected = link_poses(self.robot, self.standing)
        found = {name: self.usd.bodies[own].world_from_body for name, own in self.names.links.items()}
        from_root, worst, where = inverse(found[self.robot.root.name]), 0.0, ""
        size = max(1.0, *(float(np.abs(pose[:3, 3]).max()) for pose in expected.values()))
        for link, pose in expected.items():
            value = distance(from_root @ found[link], pose, unresolved=ARC_COSINE) / size
            if not value <= worst:
                worst, where = value, link
        message = f"is {shown(worst)} m or rad from where the robot has it"
        finding = Finding(self.element("link", where), "xformOp:transform", message)
        detail = f"bodies where they stand, against `home` [m, rad]; worst: {where}"
        return self.within("home", worst, SAME, detail, [finding])


check_file = partial(checks_by, ReadUsd)


def _ends(dof: Dof) -> tuple[float, float]:
    """The range [m or rad] along the axis of the frame, to which the dof's own may be opposite."""
    return dof.limits.mapped(1 if dof.axis.sum() > 0 else -1).interval


def _freed(dof: Dof) -> tuple[str, str]:
    """What a general joint leaves free for it."""
    return "rot" if dof.kind == "turn" else "trans", "XYZ"[int(np.abs(dof.axis).argmax())]
