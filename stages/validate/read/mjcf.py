"""Reads the robot of a compiled MJCF, for the comparisons in `stages.validate.same`."""

import math
from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import mujoco
import numpy as np

from linkwright.stages.mujoco.names import body_index, joint_index
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Loop, Spring
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import link as link_title
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.coordinates import BY_EQUALITY, joints_of, root_pose, site_pose
from linkwright.stages.validate.model.equalities import carriers, ends, equality_index, sites
from linkwright.stages.validate.model.mass_properties import MassProperties, merge
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
    com="inertial pos",
    inertia="inertial fullinertia",
    moments=("inertial diaginertia", "inertial quat"),
    axis="axis",
    place=("pos", "quat"),
    mimic=("polycoef", "polycoef"),
    numbers={"friction": "frictionloss"},
    zero="ref",
)

LIMIT_DEFAULTS = (
    ("margin", "jnt_margin", (0.0,)),
    ("solreflimit", "jnt_solref", (0.02, 1.0)),
    ("solimplimit", "jnt_solimp", (0.9, 0.95, 0.001, 0.5, 2.0)),
)
"""(Attribute of a joint that only an MJCF source may set, its field in a model, MuJoCo's default). These
attributes make limits soft or active early."""

POLYNOMIALS = (("stiffness", "jnt_stiffnesspoly", "jnt"), ("damping", "dof_dampingpoly", "dof"))
"""Attribute, the field of the polynomial's higher terms, and what indexes this field: older MuJoCo versions
lack these fields."""


_MutableNumbers = dict[str, float | tuple[float, ...]]


class _Row(NamedTuple):
    """A number of a joint, or several, with its expected value."""

    attribute: str
    """The attribute of MJCF that sets it."""

    quantity: str
    """The name of the quantity in findings."""

    actual: Any
    """A number or an array, in MJCF's unit of the attribute."""

    expected: Any
    """A number or an array of the same size and unit."""


def joint_type_name(kind: Any) -> str:
    """Returns MJCF's name of a type of joint."""
    return str(mujoco.mjtJoint(int(kind)).name).removeprefix("mjJNT_").lower()


class ReadMjcf(ReadCompiled):
    """Reads the robot of an MJCF."""

    attribute_names = ATTRIBUTE_NAMES

    def __init__(self, compiled: CompiledModel) -> None:
        super().__init__(compiled)
        self._carriers = carriers(self.model, self.robot)
        self._start = starting_point(self.robot)

    def element(self, kind: ElementKind, name: str) -> str:
        tags = {"link": "body", "frame": "site"}
        return named(tags.get(kind, "joint"), name)

    def placing_element(self, joint: Joint) -> str:
        return link_title(joint.child, urdf=False)

    def zero(self, dof: Dof) -> tuple[float, float] | None:
        start = self._start[dof.name]
        position = float(self.model.qpos0[self.model.jnt_qposadr[joint_index(self.model, dof.name)]])
        return None if isinstance(start, tuple) else (position, start)

    def mass_properties(self, link: str) -> MassProperties:
        """Returns the mass properties of the link's body and of the carriers that hold part of its mass."""
        carried = [self.body_mass_properties(body, pose) for body, pose in self._carriers.get(link, [])]
        return merge([super().mass_properties(link), *carried])

    def joints(self) -> Iterator[FoundJoint]:
        extras = (self.robot.mjcf or NO_EXTRAS).attributes_of("joint")
        for name, kind, dof in joints_of(self.robot, urdf=False):
            index, element = joint_index(self.model, name), named("joint", name)
            numbers, expected = self._numbers(index, dof, extras.get(name, {}))
            type_found, types = joint_type_name(self.model.jnt_type[index]), (joint_type_name(kind),)
            yield FoundJoint(name, element, type_found, types, dof, numbers, expected)

    def _numbers(self, index: int, dof: Dof, source_attributes: Mapping[str, str]) -> tuple[Numbers, Numbers]:
        """Returns the numbers of a joint, and their expected values. `source_attributes`: the joint's
        attributes in an MJCF source. Springs, solver parameters and polynomials that the user's own XML sets
        are not compared."""
        numbers, expected = self._ranges(index, dof, source_attributes)
        if dof.kind != "free":
            dof_index = int(self.model.jnt_dofadr[index])
            numbers["damping"] = float(self.model.dof_damping[dof_index])
            numbers["friction"] = float(self.model.dof_frictionloss[dof_index])
            numbers["armature"] = float(self.model.dof_armature[dof_index])
        rows = (*self._spring_rows(index, dof), *self._source_rows(index, source_attributes))
        for attribute, quantity, actual_value, expected_value in rows:
            if not self.compiled.sets(attribute):
                numbers[quantity] = tuple(map(float, np.ravel(actual_value)))
                expected[quantity] = tuple(map(float, np.ravel(expected_value)))
        return numbers, expected

    def _ranges(
        self, index: int, dof: Dof, source_attributes: Mapping[str, str]
    ) -> tuple[_MutableNumbers, _MutableNumbers]:
        """Returns the range of a joint and of the force on it, and their expected values."""
        model, numbers, expected = self.model, _MutableNumbers(), _MutableNumbers()
        is_scalar = dof.kind in ("turn", "slide")
        if is_scalar or "range" not in source_attributes:
            # The cone that limits a ball is never written (W-BALL-CONE), so its range must be open.
            numbers["range"] = _interval(model.jnt_limited[index], model.jnt_range[index])
            expected["range"] = dof.limits.interval if is_scalar else (-math.inf, math.inf)
        if is_scalar:
            force_range = _interval(model.jnt_actfrclimited[index], model.jnt_actfrcrange[index])
            numbers["actuatorfrcrange"] = force_range
            effort = math.inf if dof.dynamics.effort is None else dof.dynamics.effort
            source_range = _source_numbers(source_attributes, "actuatorfrcrange")
            # The attribute is only kept as "false".
            is_open = "actuatorfrclimited" in source_attributes
            expected["actuatorfrcrange"] = (
                (-math.inf, math.inf) if is_open else source_range or (-effort, effort)
            )
        return numbers, expected

    def _spring_rows(self, index: int, dof: Dof) -> Iterator[_Row]:
        """Yields the stiffness of a joint and, for a hinge or slide with a spring, where the spring is at
        rest."""
        spring = dof.spring or Spring(0.0)
        yield _Row("stiffness", "stiffness", self.model.jnt_stiffness[index], spring.stiffness)
        if dof.spring is not None and dof.kind in ("turn", "slide"):
            rest_position = self.model.qpos_spring[self.model.jnt_qposadr[index]]
            yield _Row("springref", "springref", rest_position, spring.reference)

    def _source_rows(self, index: int, source_attributes: Mapping[str, str]) -> Iterator[_Row]:
        """Yields the attributes that only an MJCF source can set."""
        for name, field, default in LIMIT_DEFAULTS:
            source_values = _source_numbers(source_attributes, name)
            yield _Row(name, name, getattr(self.model, field)[index], source_values or default)
        for name, field, per in POLYNOMIALS:
            if hasattr(self.model, field):
                row = index if per == "jnt" else int(self.model.jnt_dofadr[index])
                terms = np.ravel(getattr(self.model, field)[row])
                # The first number of the source is the linear term, which the dof has.
                higher_terms = _source_numbers(source_attributes, name)[1:]
                expected_terms = np.zeros(len(terms))
                expected_terms[: len(higher_terms)] = higher_terms
                yield _Row(name, f"{name} of higher order", terms, expected_terms)

    def loop_poses(self, loop: Loop, q: Configuration) -> Iterator[FoundPose]:
        """Yields the poses, relative to the root, of the sites that the loop's equality holds together. If
        the loop has a carrier body, one of the sites is on it."""
        model, data, index = self.model, self.data_at(q), equality_index(self.model, loop)
        root_from_world = inverse(root_pose(model, data, self.robot))
        site_of_body = {
            int(model.site_bodyid[site]): site for site in (sites(model, index) if index >= 0 else ())
        }
        for body, expected in _frames(model, loop, link_poses(self.robot, q), chain(loop.dofs, q)):
            site = site_of_body.get(body)
            if site is None:
                yield FoundPose(named("body", model.body(body).name), ("site", "site"), None, expected)
            else:
                pose = root_from_world @ site_pose(model, data, site)
                yield FoundPose(named("site", model.site(site).name), ATTRIBUTE_NAMES.place, pose, expected)

    def mimics(self) -> Iterator[FoundMimic]:
        equality_count = self.model.neq - self.compiled.surplus.equalities
        return joint_mimics(self.model, equality_count, all_active=self.compiled.sets("active"))


def _frames(
    model: Any, loop: Loop, poses: Mapping[str, Array], second_from_first: Array
) -> Iterator[tuple[int, Array]]:
    """Yields the body and the pose (root_from_frame) of each of the two frames of a loop.
    `second_from_first` (4, 4): the motion of the loop's dofs."""
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


def joint_mimics(model: Any, equality_count: int, *, all_active: bool) -> Iterator[FoundMimic]:
    """Yields the equalities of two joints among the first `equality_count` equalities. The multiplier of an
    equality of higher order is NaN, and a missing second joint has the name "". `all_active`: whether
    inactive equalities count as active."""
    for equality in np.flatnonzero(model.eq_type[:equality_count] == mujoco.mjtEq.mjEQ_JOINT):
        joints = int(model.eq_obj1id[equality]), int(model.eq_obj2id[equality])
        data = model.eq_data[equality][:5]
        zeros = [float(model.qpos0[model.jnt_qposadr[joint]]) if joint >= 0 else 0.0 for joint in joints]
        follower, driver = (model.joint(joint).name if joint >= 0 else "" for joint in joints)
        factor = float(data[1]) if not data[2:].any() else math.nan
        offset = float(data[0]) + zeros[0] - float(data[1]) * zeros[1]
        yield FoundMimic(follower, driver, factor, offset, all_active or bool(model.eq_active0[equality]))


def _interval(limited: Any, ends: Any) -> tuple[float, ...]:
    return tuple(map(float, ends)) if limited else (-math.inf, math.inf)


def _source_numbers(extras: Mapping[str, str], attribute: str) -> tuple[float, ...]:
    """Returns the numbers of an attribute of an MJCF source, () if the attribute is missing."""
    return tuple(float(number) for number in extras.get(attribute, "").split())
