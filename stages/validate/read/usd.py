"""Reads the robot of a USD with usd-core. The poses of bodies are computed from the joints."""

from collections.abc import Iterator
from functools import partial
from math import isfinite
from pathlib import Path

import numpy as np

from linkwright.stages.formats.usd.drives import drives_of
from linkwright.stages.formats.usd.names import usd_names
from linkwright.stages.formats.usd.zeros import ball_zeros
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.dynamics.inertia import TINY_INERTIAL
from linkwright.stages.robot.model.poses import at_rest, from_parts, inverse, motion
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Loop, Value
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.start_pose import HOME, home
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import named, shown
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, distance
from linkwright.stages.validate.model.mass_properties import MassProperties
from linkwright.stages.validate.read.run import run_checks
from linkwright.stages.validate.same.read_robot import (
    AttributeNames,
    ElementKind,
    FoundJoint,
    FoundPose,
    Names,
    Poses,
    Precision,
    ReadRobot,
    UnreadableFile,
)
from linkwright.stages.validate.usd.actuators import actuator_findings
from linkwright.stages.validate.usd.driving import driving_findings
from linkwright.stages.validate.usd.model import (
    articulation_findings,
    motion_findings,
    placement_findings,
    shape_findings,
    unit_findings,
)
from linkwright.stages.validate.usd.places import place_findings
from linkwright.stages.validate.usd.reader import ReadUsdJoint, UsdError, read_usd

SINGLE_PRECISION = 1e-5
"""The largest error of single precision, in which UsdPhysics has masses and the frames of joints. It is
relative to the robot's size, or to the value, if these are above 1."""

ARC_COSINE = 3e-8
"""Angle [rad] up to which USD cannot resolve turns: it computes the angle of a quaternion as 2 arccos w, and
the largest w below 1 means 2.98e-8 rad."""

TYPES = {"turn": "Revolute", "slide": "Prismatic", "ball": "Spherical"}

ATTRIBUTE_NAMES = AttributeNames(
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
    """Reads the robot of a USD. `usd`: the content of the file; `names`: the names of the robot's elements in
    it. Relations and all other properties of joints are compared by their attributes."""

    attribute_names = ATTRIBUTE_NAMES
    precision = Precision(
        SINGLE_PRECISION,
        SINGLE_PRECISION,
        SINGLE_PRECISION,
        scales_with_size=True,
        massless_inertial=TINY_INERTIAL,
    )

    def __init__(self, path: Path, written: Written) -> None:
        try:
            self.usd = read_usd(path)
        except UsdError as error:
            raise UnreadableFile(str(error)) from None
        self.file, self.path, self.written, self.robot = path.name, path, written, written.robot
        self.names, self.file_configuration = usd_names(self.robot), home(self.robot)
        self.fixed_dofs = {
            dof.name: self.file_configuration[dof.name] for dof in self.robot.dofs if dof.kind == "free"
        }
        self._zeros = ball_zeros(self.robot, self.file_configuration)

    def element(self, kind: ElementKind, name: str) -> str:
        names = self.names.links if kind == "link" else self.names.joints
        return named("def", names.get(name, name))

    def names_found(self) -> Names:
        """Returns the links, and the joints that the robot must have. Which further joints there may be
        depends on the loops."""
        joints = self.names_expected()["joint"] & self.usd.joints.keys()
        between = {name for added in self.names.links_between.values() for name in added}
        return {"link": self.usd.bodies.keys() - between, "joint": joints}

    def names_expected(self) -> Names:
        titles = self.names.joints
        joints = {titles[dof.name] for dof in self.robot.dofs if dof.kind != "free"}
        joints |= {titles[joint.name] for joint in self.robot.joints if not joint.dofs}
        joints |= {self.names.base_joint} if self.robot.base.fixed else set()
        return {"link": {*self.names.links.values()}, "joint": joints}

    def mass_properties(self, link: str) -> MassProperties:
        inertial = self.usd.bodies[self.names.links[link]].inertial
        return MassProperties(inertial.mass, inertial.com, inertial.inertia)

    def poses(self, q: Configuration) -> Poses:
        """Computes the poses from the joints; bodies without a joint are where the file puts them. Frames
        have their own check."""
        values = {self.names.joints[dof.name]: (dof, q[dof.name]) for dof in self.robot.dofs}
        tree_joints = self._tree_joints()
        world_poses: dict[str, Array] = {}
        for body in self.usd.bodies:
            path = [body]
            # A cycle of joints must end somewhere.
            while path[-1] in tree_joints and path[-1] not in world_poses and len(path) <= len(tree_joints):
                path.append(tree_joints[path[-1]][1].first)
            for member in reversed(path):
                if member in world_poses:
                    continue
                if member not in tree_joints:
                    world_poses[member] = self.usd.bodies[member].world_from_body
                    continue
                name, joint = tree_joints[member]
                moved = self._joint_motion(joint, *values[name]) if name in values else np.eye(4)
                parent = world_poses.get(joint.first, np.full((4, 4), np.nan))
                world_poses[member] = (
                    parent @ joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
                )
        root_from_world = inverse(world_poses[self.names.links[self.robot.root.name]])
        return Poses(
            {name: root_from_world @ world_poses[body] for name, body in self.names.links.items()}, {}
        )

    def _tree_joints(self) -> dict[str, tuple[str, ReadUsdJoint]]:
        """Maps each body to the joint of the tree that holds it, with its name."""
        joints = self.usd.joints.items()
        return {joint.second: (name, joint) for name, joint in joints if joint.first and not joint.closes}

    def _joint_motion(self, joint: ReadUsdJoint, dof: Dof, value: Value) -> Array:
        """Returns the motion (4, 4) of a joint's frame. A ball turns on from its zero."""
        if dof.kind != "ball":
            return motion(dof.kind, joint.axis, value)
        zero = motion("ball", dof.axis, self._zeros.get(dof.name, at_rest("ball")))
        turned = joint.second_from_joint[:3, :3]
        relative = (inverse(zero) @ motion("ball", dof.axis, value))[:3, :3]
        return from_parts(turned.T @ relative @ turned, np.zeros(3))

    def parent(self, link: str) -> str:
        names, tree_joints = {title: name for name, title in self.names.links.items()}, self._tree_joints()
        title, steps = self.names.links[link], 0
        while title in tree_joints and (title not in names or not steps) and steps <= len(tree_joints):
            title, steps = tree_joints[title][1].first, steps + 1
        return names.get(title, "") if steps else ""

    def joints(self) -> Iterator[FoundJoint]:
        """Yields the joints of the tree."""
        for joint in self.robot.joints:
            for dof in () if joint.type == "free" else joint.dofs or (None,):
                name = joint.name if dof is None else dof.name
                read, element = self.usd.joints[self.names.joints[name]], self.element("joint", name)
                type_ = "Fixed" if dof is None else TYPES[dof.kind]
                ends = ("cone",) if type_ == "Spherical" else ("lower", "upper")
                numbers = {} if dof is None else dict(zip(ends, read.ends[-len(ends) :], strict=True))
                yield FoundJoint(name, element, read.type, (type_,), dof, numbers)

    def loop_poses(self, loop: Loop, q: Configuration) -> Iterator[FoundPose]:
        """Yields the frames of the joint that closes the loop, which is outside the articulation, or the last
        joint of the links between. A ball is compared at its rest value, since its joint is the same whatever
        its axes are."""
        attributes = ("physics:localPos0", "physics:localRot0")
        title = self.names.joints.get(loop.name, "")
        joint, actual, expected = self.usd.joints.get(title), None, np.eye(4)
        if joint is None or not joint.closes:
            title = self.names.joints[loop.dofs[-1].name] if loop.dofs else title
            joint = self.usd.joints.get(title) if loop.dofs else None
            actual = np.eye(4) if joint is not None and joint.closes else None
        elif joint.type or self._frees(joint, loop):
            q = {**q, **{dof.name: at_rest("ball") for dof in loop.dofs if dof.kind == "ball"}}
            moved = np.eye(4)
            for dof in loop.dofs:
                moved = moved @ motion(dof.kind, joint.axis if joint.type else dof.axis, q[dof.name])
            actual = joint.first_from_joint @ moved @ inverse(joint.second_from_joint)
            expected = loop.b_from_frame @ chain(loop.dofs, q) @ inverse(loop.a_from_frame)
        yield FoundPose(named("def", title or loop.name), attributes, actual, expected)

    def _frees(self, joint: ReadUsdJoint, loop: Loop) -> bool:
        """Tells whether a general joint frees the same motions as the loop, within its limits."""
        expected = {_free_motion(dof): _range_along_frame(dof) for dof in loop.dofs}
        return joint.free_ranges.keys() == expected.keys() and all(
            # The tolerance of an infinite limit would be infinite.
            end == limit or (isfinite(limit) and abs(end - limit) <= SINGLE_PRECISION * max(1.0, abs(limit)))
            for key in expected
            for end, limit in zip(joint.free_ranges[key], expected[key], strict=True)
        )

    def first_checks(self) -> Iterator[Check]:
        yield self.result_of("units", "metres, kilograms, and z upwards", unit_findings(self.usd))

    def own_checks(self) -> Iterator[Check]:
        """Checks what only a USD has."""
        usd, robot, names, written = self.usd, self.robot, self.names, self.written
        yield self._placement()
        scene = written.scene if robot.root.name != "world" else None
        place = dict(scene.keyframes).get(HOME) if scene is not None else None
        model_findings = (
            *usd.flaws,
            *articulation_findings(usd, robot, names),
            *placement_findings(usd, robot, names, place),
            *motion_findings(usd, robot, names, written.geometry),
        )
        detail = "articulation, place, self-collision and pairs of bodies that do not collide"
        yield self.result_of("model", detail, model_findings)
        drives = drives_of(robot, written.actuation, self.file_configuration)
        detail = "resistance, largest speed, state, drive and relations of each joint, and MuJoCo's actuators"
        drive_findings = (
            *driving_findings(usd, robot, names, drives, self.file_configuration),
            *actuator_findings(usd.actuators, robot, names, written.actuation.actuators),
        )
        yield self.result_of("drives", detail, drive_findings)
        detail = "frames and cameras on their bodies"
        yield self.result_of("frames", detail, place_findings(usd, robot, names, written.sensing))
        if written.geometry is not None:
            total = count(len(written.geometry.shapes), "shape")
            detail = f"{total} of the robot, with their sizes and places, and what collides"
            yield self.result_of(
                "shapes", detail, shape_findings(usd, names, written.geometry, self.path.parent)
            )

    def _placement(self) -> Check:
        """Checks that bodies are where the robot is at `home`, without regard to their joints."""
        expected = link_poses(self.robot, self.file_configuration)
        placed_bodies = {
            name: self.usd.bodies[title].world_from_body for name, title in self.names.links.items()
        }
        root_from_world, worst, worst_link = inverse(placed_bodies[self.robot.root.name]), 0.0, ""
        size = max(1.0, *(float(np.abs(pose[:3, 3]).max()) for pose in expected.values()))
        for link, pose in expected.items():
            value = distance(root_from_world @ placed_bodies[link], pose, unresolved=ARC_COSINE) / size
            if value > worst:
                worst, worst_link = value, link
        # `worst` is relative to the size.
        message = f"is {shown(worst * size)} m or rad from where the robot has it"
        finding = Finding(self.element("link", worst_link), "xformOp:transform", message)
        detail = f"bodies where they stand, against `home` [m, rad]; worst: {worst_link}"
        return self.within("home", worst, ENGINE_TOLERANCE, detail, [finding])


check_file = partial(run_checks, ReadUsd)


def _range_along_frame(dof: Dof) -> tuple[float, float]:
    """Returns the range [m or rad] along the axis of the frame, which may be opposite to the dof's axis."""
    return dof.limits.mapped(1 if dof.axis.sum() > 0 else -1).interval


def _free_motion(dof: Dof) -> tuple[str, str]:
    """Returns the motion that a general joint frees for the dof."""
    return "rot" if dof.kind == "turn" else "trans", "XYZ"[int(np.abs(dof.axis).argmax())]
