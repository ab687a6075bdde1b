"""The robot of a URDF that MuJoCo compiled."""

import math
from collections.abc import Iterator
from typing import Any

import mujoco

from linkwright.stages.formats.xml import parse
from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Configuration, Loop
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.dynamics.mujoco_abilities import axes_error, mimics, reads_mimic
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import joints_of, link_pose, pose_of
from linkwright.stages.validate.read.mjcf import coupled, type_name
from linkwright.stages.validate.read.mujoco import ReadCompiled
from linkwright.stages.validate.same.found import (
    FormatWords,
    FoundJoint,
    FoundMimic,
    FoundPlace,
    Numbers,
    Tag,
)

WORDS = FormatWords(
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


class ReadUrdf(ReadCompiled):
    """What MuJoCo leaves out is read in the text."""

    words = WORDS
    demands = frozenset({"lower", "upper", "effort", "velocity"})

    def __init__(self, compiled: CompiledModel) -> None:
        super().__init__(compiled)
        self._text, self._names = compiled.path.read_bytes(), compiled.written.urdf_names

    def posed(self, q: Configuration) -> Any:
        """The values of a floating joint replace its origin, and would hide a wrong one: where the file
        stands it is left alone."""
        if q is not self.standing:
            return super().posed(q)
        data = mujoco.MjData(self.model)
        mujoco.mj_kinematics(self.model, data)
        return data

    def frame_name(self, frame: str) -> str:
        return self._names.frames.get(frame, frame)

    def element(self, tag: Tag, name: str) -> str:
        if tag == "frame":
            return named("joint", self._names.holders[self._names.frames[name]])
        if tag == "relation":
            return named("joint", next(one.follower for one in self.robot.relations if one.name == name))
        turns = self._names.turns.get(name) if tag == "joint" else None
        return named(tag, turns[0] if turns else name)

    def odd_masses(self) -> Iterator[tuple[str, float, Finding]]:
        """Links that have mass, and no <inertial>: MuJoCo works one out from their shapes."""
        links = parse(self._text).iterfind("link")
        bare = {one.get("name") for one in links if one.find("inertial") is None}
        for link in self.robot.links:
            if link.inertial.mass > 0 and link.name in bare:
                message = "has no inertial, so that each reader makes one up"
                yield link.name, math.inf, Finding(named("link", link.name), "inertial", message)

    def axes_error(self, size: float) -> float:
        return axes_error(size)

    def joints(self) -> Iterator[FoundJoint]:
        limits = parse(self._text).iterfind("joint/limit")
        velocities = {one.getparent().get("name", ""): one.get("velocity", "") for one in limits}
        model = self.model
        for name, kind, dof in joints_of(self.robot, urdf=True):
            index = joint_index(model, name)
            numbers: dict[str, float | tuple[float, ...]] = {}
            wanted: Numbers = {}
            if dof.kind in ("turn", "slide"):
                numbers["lower"], numbers["upper"] = map(float, model.jnt_range[index])
                numbers["effort"] = float(model.jnt_actfrcrange[index][1])
            elif model.jnt_limited[index]:
                # Neither a floating joint nor the three turns of a ball may have limits.
                numbers["range"], wanted = (
                    tuple(map(float, model.jnt_range[index])),
                    {"range": (-math.inf, math.inf)},
                )
            if dof.kind != "free":
                numbers["damping"] = float(model.dof_damping[model.jnt_dofadr[index]])
                numbers["friction"] = float(model.dof_frictionloss[model.jnt_dofadr[index]])
                numbers["velocity"] = _number(velocities.get(name))
            found, types = type_name(model.jnt_type[index]), (type_name(kind),)
            yield FoundJoint(name, named("joint", name), found, types, dof, numbers, wanted)

    def places(self, loop: Loop, q: Configuration) -> Iterator[FoundPlace]:
        """A URDF cannot close a loop: it has a link for each of the two frames that must meet."""
        model, data, robot = self.model, self.posed(q), self.robot
        both = (loop.link_a, loop.a_from_frame), (loop.link_b, loop.b_from_frame)
        for name, (link, expected) in zip(self._names.ends[loop.name], both, strict=True):
            index, element = body_index(model, name), named("joint", self._names.holders[name])
            pose = inverse(link_pose(model, data, robot, link)) @ pose_of(data, index)
            yield FoundPlace(element, WORDS.place, pose if index >= 0 else None, expected)

    def mimics(self) -> Iterator[FoundMimic]:
        model = self.model
        if reads_mimic():
            yield from coupled(model, model.neq - self.compiled.surplus.equalities, False)
            return
        for both, data in mimics(model, self._text).items():
            follower, driver = (model.joint(joint).name if joint >= 0 else "" for joint in both)
            yield FoundMimic(follower, driver, float(data[1]), float(data[0]))


def _number(text: str | None) -> float:
    """Infinite where nothing is said."""
    try:
        return float(text) if text else math.inf
    except ValueError:
        return math.nan
