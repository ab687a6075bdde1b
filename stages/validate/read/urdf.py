"""Reads the robot of a URDF that MuJoCo compiled."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Configuration, Dof, Loop
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.dynamics import mujoco_features
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import joints_of, link_pose, pose_of
from linkwright.stages.validate.read.mjcf import joint_mimics, joint_type_name
from linkwright.stages.validate.read.mujoco import ReadCompiled
from linkwright.stages.validate.same.read_robot import (
    AttributeNames,
    ElementKind,
    FoundJoint,
    FoundMimic,
    FoundPose,
    Numbers,
)

ATTRIBUTE_NAMES = AttributeNames(
    mass="inertial mass",
    com="inertial origin",
    inertia="inertial inertia i",
    axis="axis xyz",
    place=("origin xyz", "origin rpy"),
    mimic=("mimic multiplier", "mimic offset"),
    numbers={
        "lower": "limit lower",
        "upper": "limit upper",
        "range": "limit",
        "effort": "limit effort",
        "velocity": "limit velocity",
        "damping": "dynamics damping",
        "friction": "dynamics friction",
    },
)
"""The names that findings give to attributes of a URDF."""


class ReadUrdf(ReadCompiled):
    """Reads the robot of a URDF. Attributes that MuJoCo drops are read from the file's text."""

    attribute_names = ATTRIBUTE_NAMES
    required_numbers = frozenset({"lower", "upper", "effort", "velocity"})

    def __init__(self, compiled: CompiledModel) -> None:
        super().__init__(compiled)
        self._text = compiled.path.read_bytes()
        self._names = compiled.written.urdf_names

    def data_at(self, q: Configuration) -> Any:
        """Returns MuJoCo's data at the values `q`. For `file_configuration` no value is set: the value of a
        floating joint would replace the joint's origin, and hide an error in it."""
        if q is not self.file_configuration:
            return super().data_at(q)
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        return data

    def frame_name(self, frame: str) -> str:
        return self._names.frames.get(frame, frame)

    def element(self, kind: ElementKind, name: str) -> str:
        if kind == "frame":
            return named("joint", self._names.holders[self._names.frames[name]])
        if kind == "relation":
            (follower,) = (relation.follower for relation in self.robot.relations if relation.name == name)
            return named("joint", follower)
        # In a URDF, a ball joint is three joints in a row; findings name the first.
        turns = self._names.turns.get(name) if kind == "joint" else None
        return named(kind, turns[0] if turns else name)

    def unexpected_masses(self) -> Iterator[tuple[str, float, Finding]]:
        """Yields links that have mass but no <inertial>: MuJoCo derives an inertial from their shapes."""
        links = parse(self._text).iterfind("link")
        without_inertial = {node.get("name") for node in links if node.find("inertial") is None}
        for link in self.robot.links:
            if link.inertial.mass > 0 and link.name in without_inertial:
                message = "has no <inertial> although the link has mass, so each reader derives its own"
                yield link.name, math.inf, Finding(named("link", link.name), "inertial", message)

    def axes_error(self, size: float) -> float:
        return mujoco_features.principal_axes_error(size)

    def joints(self) -> Iterator[FoundJoint]:
        """Yields the joints of the model. Their limits of velocity, which MuJoCo drops, are read from the
        text."""
        limits = parse(self._text).iterfind("joint/limit")
        velocities = {limit.getparent().get("name", ""): limit.get("velocity", "") for limit in limits}
        model = self.model
        for name, kind, dof in joints_of(self.robot, urdf=True):
            joint_id = joint_index(model, name)
            numbers, expected = self._joint_numbers(joint_id, dof)
            if dof.kind != "free":
                numbers["velocity"] = _parsed_number(velocities.get(name))
            actual_type = joint_type_name(model.jnt_type[joint_id])
            accepted_types = (joint_type_name(kind),)
            yield FoundJoint(name, named("joint", name), actual_type, accepted_types, dof, numbers, expected)

    def _joint_numbers(self, joint_id: int, dof: Dof) -> tuple[dict[str, float | tuple[float, ...]], Numbers]:
        """Returns the numbers of a joint in the model, and the expected numbers where the robot does not give
        them."""
        model = self.model
        numbers: dict[str, float | tuple[float, ...]] = {}
        expected: Numbers = {}
        if dof.kind in ("turn", "slide"):
            numbers["effort"] = float(model.jnt_actfrcrange[joint_id][1])
        if dof.kind == "slide" or (dof.kind == "turn" and not np.isinf(dof.limits.interval).all()):
            numbers["lower"], numbers["upper"] = map(float, model.jnt_range[joint_id])
        elif model.jnt_limited[joint_id]:
            # A turn without limits is continuous. It may not have limits, nor may a floating joint, nor the
            # three turns of a ball.
            numbers["range"] = tuple(map(float, model.jnt_range[joint_id]))
            expected = {"range": (-math.inf, math.inf)}
        if dof.kind != "free":
            numbers["damping"] = float(model.dof_damping[model.jnt_dofadr[joint_id]])
            numbers["friction"] = float(model.dof_frictionloss[model.jnt_dofadr[joint_id]])
        return numbers, expected

    def loop_poses(self, loop: Loop, q: Configuration) -> Iterator[FoundPose]:
        """Yields the poses of a loop's two frames. A URDF cannot close a loop, so each frame is a link of its
        own."""
        model, data, robot = self.model, self.data_at(q), self.robot
        frames = (loop.link_a, loop.a_from_frame), (loop.link_b, loop.b_from_frame)
        for name, (link, expected) in zip(self._names.ends[loop.name], frames, strict=True):
            body_id, element = body_index(model, name), named("joint", self._names.holders[name])
            pose = inverse(link_pose(model, data, robot, link)) @ pose_of(data, body_id)
            yield FoundPose(element, ATTRIBUTE_NAMES.place, pose if body_id >= 0 else None, expected)

    def mimics(self) -> Iterator[FoundMimic]:
        """Yields the mimics: from the model's equalities, or from the text if this MuJoCo ignores <mimic>."""
        model = self.model
        if mujoco_features.reads_mimic():
            # Equalities that the user added follow the robot's.
            equality_count = model.neq - self.compiled.surplus.equalities
            yield from joint_mimics(model, equality_count, all_active=False)
            return
        for pair, coefficients in mujoco_features.mimics(model, self._text).items():
            # A <mimic> may name a joint that the model lacks.
            follower, driver = (model.joint(joint).name if joint >= 0 else "" for joint in pair)
            offset, multiplier, *_ = map(float, coefficients)
            yield FoundMimic(follower, driver, multiplier, offset)


def _parsed_number(text: str | None) -> float:
    """Returns the number in a text; infinity if the text is missing or empty, NaN if it is not a number."""
    try:
        return float(text) if text else math.inf
    except ValueError:
        return math.nan
