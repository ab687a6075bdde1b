"""Reads the robot of an SDF, whose kinematics is computed from the file alone."""

from collections.abc import Iterator
from functools import partial
from itertools import zip_longest
from pathlib import Path

import numpy as np

from linkwright.stages.formats.sdf.elements import SdfError
from linkwright.stages.formats.sdf.kinematics import child_pose, moved_links
from linkwright.stages.formats.sdf.model import ReadJoint
from linkwright.stages.formats.sdf.names import sdf_names
from linkwright.stages.formats.sdf.parse import parse_sdf
from linkwright.stages.formats.written import Written
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.poses import at_rest, inverse, motion, quat_from_rotation
from linkwright.stages.robot.model.robot import Array, Configuration, Dof, Joint, Loop, Value
from linkwright.stages.robot.motion.kinematics import chain, link_poses
from linkwright.stages.robot.motion.loops import closing_values, relative_pose
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.model.coordinates import distance
from linkwright.stages.validate.model.mass_properties import MassProperties
from linkwright.stages.validate.read.run import run_checks
from linkwright.stages.validate.same.read_robot import (
    AttributeNames,
    ElementKind,
    FoundJoint,
    FoundMimic,
    FoundPose,
    Names,
    Numbers,
    Poses,
    ReadRobot,
    UnreadableFile,
)
from linkwright.stages.validate.sdf.contacts import contact_findings
from linkwright.stages.validate.sdf.shapes import mesh_file_check, model_findings, shape_findings

TYPES = {"turn": ("revolute", "continuous"), "slide": ("prismatic",), "ball": ("ball",)}
"""SDF's types of joint for each kind of dof."""

ATTRIBUTE_NAMES = AttributeNames(
    mass="inertial mass",
    com="inertial pose",
    inertia="inertial inertia i",
    axis="axis",
    place=("pose", "pose"),
    mimic=("mimic multiplier", "mimic offset"),
    numbers={
        "lower": "limit lower",
        "upper": "limit upper",
        "effort": "limit effort",
        "velocity": "limit velocity",
        "damping": "dynamics damping",
        "friction": "dynamics friction",
    },
)


class ReadSdf(ReadRobot):
    """Reads the robot of an SDF. `model`: the content of the file; `names`: the names of the robot's elements
    in it."""

    attribute_names = ATTRIBUTE_NAMES

    def __init__(self, path: Path, written: Written) -> None:
        try:
            self.model = parse_sdf(path.read_bytes())
        except SdfError as error:
            raise UnreadableFile(str(error)) from None
        self.file, self.path, self.written, self.robot = path.name, path, written, written.robot
        self.names = sdf_names(self.robot)
        self.file_configuration = self._file_configuration()
        free = {dof.name for dof in self.robot.dofs if dof.kind == "free"}
        self.fixed_dofs = {name: value for name, value in self.file_configuration.items() if name in free}

    def _file_configuration(self) -> Configuration:
        """Returns the value of each dof, also of loops, in the file's placement of the links; nothing if a
        link is missing.

        The value is zero or that at the start of a simulation, whichever is nearer. For free links it is the
        pose, and for loops the values that close them.
        """
        robot, start, links = self.robot, starting_point(self.robot), self.model.links
        if not {*self.names.links.values()} <= links.keys():
            return {}
        placed = {name: links[title].model_from_link for name, title in self.names.links.items()}
        rest_values: Configuration = {dof.name: at_rest(dof.kind) for dof in robot.dofs}
        values: dict[str, Value] = {}
        for joint in robot.joints:
            pose = inverse(placed[joint.parent] @ joint.parent_from_joint) @ placed[joint.child]
            if joint.type == "free":
                (dof,) = joint.dofs
                values[dof.name] = _free_value(inverse(dof.origin) @ pose)
                continue
            nearest = min((rest_values, start), key=lambda q: distance(chain(joint.dofs, q), pose))
            values |= {dof.name: nearest[dof.name] for dof in joint.dofs}
        for loop in robot.loops:
            values |= closing_values(loop, relative_pose(loop, placed))
        return values

    def element(self, kind: ElementKind, name: str) -> str:
        if kind == "relation":
            name = next(relation.follower for relation in self.robot.relations if relation.name == name)
        names = {"link": self.names.links, "frame": self.names.frames}.get(kind, self.names.joints)
        return named("joint" if kind == "relation" else kind, names.get(name, name))

    def names_found(self) -> Names:
        model = self.model
        return {"link": {*model.links}, "joint": {*model.joints}, "frame": {*model.frames}}

    def names_expected(self) -> Names:
        names, base = self.names, {self.names.base_joint} if self.robot.base.fixed else set()
        joints = {names.joints[dof] for group in self._chains() for dof in _dof_names(group)} | base
        links = {*names.links.values(), *(name for added in names.links_between.values() for name in added)}
        return {"link": links, "joint": joints, "frame": {*names.frames.values()}}

    def _chains(self) -> list[Joint | Loop]:
        """Returns the joints and loops that are joints in an SDF."""
        return [*(joint for joint in self.robot.joints if joint.type != "free"), *self.robot.loops]

    def mass_properties(self, link: str) -> MassProperties:
        inertial = self.model.links[self.names.links[link]].inertial
        return MassProperties(inertial.mass, inertial.com, inertial.inertia)

    def unexpected_masses(self) -> Iterator[tuple[str, float, Finding]]:
        """Yields the links between the dofs of a joint or loop."""
        for name in (name for added in self.names.links_between.values() for name in added):
            mass = self.model.links[name].inertial.mass
            yield name, mass, differs(named("link", name), self.attribute_names.mass, mass, 0.0, "kg")

    def poses(self, q: Configuration) -> Poses:
        model, names, robot = self.model, self.names, self.robot
        dofs = [dof for dof in robot.dofs if dof.kind != "free"]
        moved = moved_links(model, {names.joints[dof.name]: self._motion(dof, q[dof.name]) for dof in dofs})
        from_model = inverse(moved[names.links[robot.root.name]])
        frames = {}
        for frame in robot.frames:
            in_model = model.frames[names.frames[frame.name]]
            in_link = inverse(model.links[in_model.link].model_from_link) @ in_model.model_from_frame
            frames[frame.name] = from_model @ moved[in_model.link] @ in_link
        return Poses({name: from_model @ moved[title] for name, title in names.links.items()}, frames)

    def _motion(self, dof: Dof, value: Value, *, backwards: bool = False) -> Array:
        """Returns the motion (4, 4) of the frame of a dof's joint. `backwards`: whether the joint goes from
        the first link of a loop to the second."""
        file_value, axis = (
            self.file_configuration[dof.name],
            self.model.joints[self.names.joints[dof.name]].axis,
        )
        if isinstance(value, tuple) or isinstance(file_value, tuple):
            first, last = (motion(dof.kind, dof.axis, angle) for angle in (file_value, value))
            return first @ inverse(last) if backwards else inverse(first) @ last
        return motion(dof.kind, np.full(3, np.nan) if axis is None else axis, value - file_value)

    def parent(self, link: str) -> str:
        names = {title: name for name, title in self.names.links.items()}
        above: dict[str, str] = {}
        for joint in self.model.joints.values():
            above.setdefault(joint.child, joint.parent)
        title = above.get(self.names.links[link], "")
        while title in above and title not in names:
            title = above[title]
        return names.get(title, "")

    def joints(self) -> Iterator[FoundJoint]:
        for group in self._chains():
            for dof, name in zip(group.dofs or (None,), _dof_names(group), strict=True):
                read = self.model.joints[self.names.joints[name]]
                types = ("fixed",) if dof is None else TYPES[dof.kind]
                numbers, expected = self._numbers(read, dof)
                if "lower" in expected and not np.isinf([expected["lower"], expected["upper"]]).all():
                    # Readers ignore the limits of a continuous joint, so that it must be a revolute one.
                    types = types[:1]
                yield FoundJoint(name, named("joint", read.name), read.type, types, dof, numbers, expected)

    def _numbers(self, joint: ReadJoint, dof: Dof | None) -> tuple[Numbers, Numbers]:
        """Returns the numbers of a joint, and the expected limits, which are relative to the file's
        placement. SDF has no numbers for balls."""
        if dof is None or dof.kind == "ball":
            return {}, {}
        zero, dynamics, (low, high) = self.file_configuration[dof.name], joint.dynamics, dof.limits.interval
        assert not isinstance(zero, tuple)
        lower, upper = joint.limits.interval
        numbers = {
            "lower": lower,
            "upper": upper,
            "effort": np.inf if dynamics.effort is None else dynamics.effort,
            "velocity": np.inf if dynamics.velocity is None else dynamics.velocity,
            "damping": dynamics.damping or 0.0,
            "friction": dynamics.friction or 0.0,
        }
        return numbers, {"lower": low - zero, "upper": high - zero}

    def mimics(self) -> Iterator[FoundMimic]:
        names = {title: name for name, title in self.names.joints.items()}
        for joint in self.model.joints.values():
            mimic = joint.mimic
            if mimic is None:
                continue
            follower, driver = (names.get(title, title) for title in (joint.name, mimic.joint))
            zeros = [self.file_configuration.get(name, 0.0) for name in (follower, driver)]
            first, second = (0.0 if isinstance(zero, tuple) else zero for zero in zeros)
            offset = mimic.offset - mimic.multiplier * (mimic.reference + second) + first
            yield FoundMimic(follower, driver, mimic.multiplier, offset)

    def loop_poses(self, loop: Loop, q: Configuration) -> Iterator[FoundPose]:
        """Yields the link at the end of a loop's joints, with the pose that the robot's chain implies."""
        poses, turned = link_poses(self.robot, q), chain(loop.dofs, q)
        first, second = (self.names.links[name] for name in (loop.link_a, loop.link_b))
        joints = [self.model.joints[self.names.joints[name]] for name in _dof_names(loop)]
        element, backwards = named("joint", joints[0].name), joints[-1].parent == first
        if backwards:
            joints, ends, pose = joints[::-1], (first, second), poses[loop.link_a]
            expected_pose = pose @ loop.a_from_frame @ inverse(turned) @ inverse(loop.b_from_frame)
        else:
            ends, pose = (second, first), poses[loop.link_b]
            expected_pose = pose @ loop.b_from_frame @ turned @ inverse(loop.a_from_frame)
        end_pose: Array | None = None
        if [*(joint.parent for joint in joints), ends[1]] == [ends[0], *(joint.child for joint in joints)]:
            end_pose, dofs = pose, loop.dofs[::-1] if backwards else loop.dofs
            for joint, dof in zip_longest(joints, dofs):
                moved = None if dof is None else self._motion(dof, q[dof.name], backwards=backwards)
                end_pose = child_pose(self.model, joint, end_pose, moved)
        yield FoundPose(element, ("pose, axis", "pose, axis"), end_pose, expected_pose)

    def first_checks(self) -> Iterator[Check]:
        yield mesh_file_check(self.path)

    def own_checks(self) -> Iterator[Check]:
        """Checks the model's placement, its shapes, and their contact."""
        model, links, geometry = self.model, self.names.links, self.written.geometry
        findings = model_findings(model, self.robot, links[self.robot.root.name], self.written.scene)
        yield self.result_of("model", "name, place and gravity of the model", findings)
        if geometry is None:
            return
        total = f"{count(len(geometry.shapes), 'shape')} of the robot"
        detail = f"{total}, with their files, sizes, places and colours"
        shape_check = self.result_of("shapes", detail, shape_findings(model, links, geometry))
        yield shape_check
        # Masks can be compared only if the file has as many shapes as the robot.
        if shape_check.passed:
            detail = f"what collides of {total}"
            yield self.result_of("contacts", detail, contact_findings(model, links, geometry))


check_file = partial(run_checks, ReadSdf)


def _dof_names(chain: Joint | Loop) -> list[str]:
    """Returns the names of the dofs of a joint or loop; without dofs, its own name."""
    return [dof.name for dof in chain.dofs] or [chain.name]


def _free_value(pose: Array) -> tuple[float, ...]:
    """Returns a pose as the value of a free dof: position, then quaternion (w, x, y, z)."""
    return (*map(float, pose[:3, 3]), *map(float, quat_from_rotation(pose[:3, :3])))
