"""The robot of a compiled MJCF."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Loop, Spring
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import link, named
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, joints_of, root_pose, site_pose
from linkwright.stages.validate.model.equalities import carriers, ends, equality_index, sites
from linkwright.stages.validate.model.lumps import Lump, merged
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
    com="inertial pos",
    inertia="inertial fullinertia",
    moments=("inertial diaginertia", "inertial quat"),
    axis="axis",
    place=("pos", "quat"),
    mimic=("polycoef", "polycoef"),
    numbers={"friction": "frictionloss"},
    zero="ref",
)

DEFAULTS = (
    ("margin", "jnt_margin", (0.0,)),
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)
"""Attributes of a joint that only an MJCF source may set, where they are in a model, and MuJoCo's defaults:
limits that are soft or begin early."""

POLYNOMIALS = (("stiffness", "jnt_stiffnesspoly", "jnt"), ("damping", "dof_dampingpoly", "dof"))
"""The terms of higher order, of a joint or of a dof, which older versions of MuJoCo lack."""


def type_name(kind: Any) -> str:
    """What an MJCF calls a type of joint."""
    return str(mujoco.mjtJoint(int(kind)).name).removeprefix("mjJNT_").lower()


class ReadMjcf(ReadCompiled):
    words = WORDS

    def __init__(self, compiled: CompiledModel) -> None:
        super().__init__(compiled)
        self._shares = carriers(self.model, self.robot)
        self._start = starting_point(self.robot)

    def element(self, tag: Tag, name: str) -> str:
        tags = {"link": "body", "frame": "site"}
        return named(tags.get(tag, "joint"), name)

    def placed(self, joint: Joint) -> str:
        return link(joint.child, urdf=False)

    def zero(self, dof: Dof) -> tuple[float, float] | None:
        start = self._start[dof.name]
        found = float(self.model.qpos0[self.model.jnt_qposadr[joint_index(self.model, dof.name)]])
        return None if isinstance(start, tuple) else (found, start)

    def lump(self, link: str) -> Lump:
        """That of its body, together with the carriers that have a share of it."""
        carried = [self.lump_of(body, pose) for body, pose in self._shares.get(link, [])]
        return merged([super().lump(link), *carried])

    def joints(self) -> Iterator[FoundJoint]:
        extras = (self.robot.mjcf or NO_EXTRAS).attributes_of("joint")
        for name, kind, dof in joints_of(self.robot, urdf=False):
            index, element = joint_index(self.model, name), named("joint", name)
            numbers, wanted = self._numbers(index, dof, extras.get(name, {}))
            found, types = type_name(self.model.jnt_type[index]), (type_name(kind),)
            yield FoundJoint(name, element, found, types, dof, numbers, wanted)

    def _numbers(self, index: int, dof: Dof, more: Mapping[str, str]) -> tuple[Numbers, Numbers]:
        """What a joint says, and what it must say. `more`: what an MJCF source says of it; what the user's
        own XML sets is the user's."""
        model, at, said = self.model, int(self.model.jnt_dofadr[index]), _said
        scalar, numbers = dof.kind in ("turn", "slide"), dict[str, float | tuple[float, ...]]()
        wanted: dict[str, float | tuple[float, ...]] = {}
        if scalar or "range" not in more:
            # No format has a ball's cone.
            numbers["range"] = _ends(model.jnt_limited[index], model.jnt_range[index])
            wanted["range"] = dof.limits.interval if scalar else (-math.inf, math.inf)
        if scalar:
            effort = math.inf if dof.dynamics.effort is None else dof.dynamics.effort
            own = said(more, "actuatorfrcrange")
            numbers["actuatorfrcrange"] = _ends(model.jnt_actfrclimited[index], model.jnt_actfrcrange[index])
            wanted["actuatorfrcrange"] = own or (-effort, effort)
            if "actuatorfrclimited" in more:
                wanted["actuatorfrcrange"] = (-math.inf, math.inf)
        if dof.kind != "free":
            numbers["damping"] = float(model.dof_damping[at])
            numbers["friction"] = float(model.dof_frictionloss[at])
            numbers["armature"] = float(model.dof_armature[at])
        spring = dof.spring or Spring(0.0)
        rows: list[tuple[str, str, Any, Any]] = [
            ("stiffness", "stiffness", model.jnt_stiffness[index], spring.stiffness),
            *(
                (name, name, getattr(model, field)[index], said(more, name) or one)
                for name, field, one in DEFAULTS
            ),
        ]
        if dof.spring is not None and scalar:
            rest = model.qpos_spring[model.jnt_qposadr[index]]
            rows.append(("springref", "springref", rest, spring.reference))
        for name, field, of in POLYNOMIALS:
            if hasattr(model, field):
                terms = np.ravel(getattr(model, field)[index if of == "jnt" else at])
                higher = np.zeros(len(terms))
                higher[: len(said(more, name)[1:])] = said(more, name)[1:]
                rows.append((name, f"{name} of higher order", terms, higher))
        for name, quantity, *both in rows:
            if not self.compiled.sets(name):
                numbers[quantity], wanted[quantity] = (tuple(map(float, np.ravel(one))) for one in both)
        return numbers, wanted

    def places(self, loop: Loop, q: Configuration) -> Iterator[FoundPlace]:
        """The sites that its equality holds together, relative to the root; one of them is the carrier's, if
        there is one."""
        model, data, index = self.model, self.posed(q), equality_index(self.model, loop)
        root_from_world = inverse(root_pose(model, data, self.robot))
        found = {int(model.site_bodyid[site]): site for site in (sites(model, index) if index >= 0 else ())}
        for body, expected in _frames(model, loop, link_poses(self.robot, q), chain(loop.dofs, q)):
            site = found.get(body)
            if site is None:
                yield FoundPlace(named("body", model.body(body).name), ("site", "site"), None, expected)
            else:
                pose = root_from_world @ site_pose(model, data, site)
                yield FoundPlace(named("site", model.site(site).name), WORDS.place, pose, expected)

    def mimics(self) -> Iterator[FoundMimic]:
        number = self.model.neq - self.compiled.surplus.equalities
        return coupled(self.model, number, self.compiled.sets("active"))


def _frames(
    model: Any, loop: Loop, poses: Mapping[str, Array], second_from_first: Array
) -> Iterator[tuple[int, Array]]:
    """(body, root_from_frame) of the two frames of a loop."""
    first = poses[loop.link_a] @ loop.a_from_frame
    second = poses[loop.link_b] @ loop.b_from_frame
    a, b = body_index(model, loop.link_a), body_index(model, loop.link_b)
    if loop.type in BY_EQUALITY:
        yield from ((a, first), (b, second))
        return
    carrier, carried = ends(model, loop)
    if carried == a:
        yield from ((a, first), (carrier, second @ second_from_first))
    else:
        yield from ((b, second), (carrier, first @ inverse(second_from_first)))


def coupled(model: Any, number: int, active: bool) -> Iterator[FoundMimic]:
    """The equalities of two joints among the first ones; one of higher order has no multiplier. `active`:
    whether all count as active."""
    for row in np.flatnonzero(model.eq_type[:number] == mujoco.mjtEq.mjEQ_JOINT):
        both = int(model.eq_obj1id[row]), int(model.eq_obj2id[row])
        data = model.eq_data[row][:5]
        zeros = [float(model.qpos0[model.jnt_qposadr[joint]]) if joint >= 0 else 0.0 for joint in both]
        follower, driver = (model.joint(joint).name if joint >= 0 else "" for joint in both)
        factor = float(data[1]) if not data[2:].any() else math.nan
        offset = float(data[0]) + zeros[0] - float(data[1]) * zeros[1]
        yield FoundMimic(follower, driver, factor, offset, bool(model.eq_active0[row]) or active)


def _ends(limited: Any, ends: Any) -> tuple[float, ...]:
    return tuple(map(float, ends)) if limited else (-math.inf, math.inf)


def _said(extras: Mapping[str, str], attribute: str) -> tuple[float, ...]:
    """The numbers of an attribute of an MJCF source, () where it says nothing."""
    return tuple(float(number) for number in extras.get(attribute, "").split())
