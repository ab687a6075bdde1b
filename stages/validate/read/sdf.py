"""The robot of an SDF, whose kinematics is worked out from the file alone."""

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
from linkwright.stages.robot.motion.loops import across, closing
from linkwright.stages.robot.motion.start_pose import starting_point
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.findings import differs, named
from linkwright.stages.validate.model.coordinates import distance
from linkwright.stages.validate.model.lumps import Lump
from linkwright.stages.validate.read.run import checks_by
from linkwright.stages.validate.same.found import (
    FormatWords,
    FoundJoint,
    FoundMimic,
    FoundPlace,
    Names,
    Numbers,
    Poses,
    ReadRobot,
    Tag,
    UnreadableFile,
)
from linkwright.stages.validate.sdf.contacts import contacts
from linkwright.stages.validate.sdf.shapes import missing_meshes, of_model, shapes

TYPES = {"turn": ("revolute", "continuous"), "slide": ("prismatic",), "ball": ("ball",)}
"""What a dof is in an SDF."""

WORDS = FormatWords(
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
    """`model`: what was read; `names`: of the robot's things there."""

    words = WORDS

    def __init__(self, path: Path, written: Written) -> None:
        try:
            self.model = parse_sdf(path.read_bytes())
        except SdfError as error:
            raise UnreadableFile(str(error)) from None
        self.file, self.path, self.written, self.robot = path.name, path, written, written.robot
        self.names = sdf_names(self.robot)
        self.standing = self._stands()
        free = {dof.name for dof in self.robot.dofs if dof.kind == "free"}
        self.still = {name: value for name, value in self.standing.items() if name in free}

    def _stands(self) -> Configuration:
        """The value of each dof, also of loops, at which the links stand as in the file: zero or that of a
        fresh simulation, whichever is nearer; of free links the pose, of loops what closes them. Nothing
        where a link is missing."""
        robot, start, links = self.robot, starting_point(self.robot), self.model.links
        if not {*self.names.links.values()} <= links.keys():
            return {}
        placed = {name: links[own].model_from_link for name, own in self.names.links.items()}
        rest: Configuration = {dof.name: at_rest(dof.kind) for dof in robot.dofs}
        stands: dict[str, Value] = {}
        for joint in robot.joints:
            pose = inverse(placed[joint.parent] @ joint.parent_from_joint) @ placed[joint.child]
            if joint.type == "free":
                (dof,) = joint.dofs
                stands[dof.name] = _seven(inverse(dof.origin) @ pose)
                continue
            nearer = min((rest, start), key=lambda q: distance(chain(joint.dofs, q), pose))
            stands |= {dof.name: nearer[dof.name] for dof in joint.dofs}
        for loop in robot.loops:
            stands |= closing(loop, across(loop, placed))
        return stands

    def element(self, tag: Tag, name: str) -> str:
        if tag == "relation":
            name = next(one.follower for one in self.robot.relations if one.name == name)
        names = {"link": self.names.links, "frame": self.names.frames}.get(tag, self.names.joints)
        return named("joint" if tag == "relation" else tag, names.get(name, name))

    def found(self) -> Names:
        model = self.model
        return {"link": {*model.links}, "joint": {*model.joints}, "frame": {*model.frames}}

    def expected(self) -> Names:
        names, base = self.names, {self.names.base} if self.robot.base.fixed else set()
        joints = {names.joints[own] for one in self._chains() for own in _own_names(one)} | base
        links = {*names.links.values(), *(name for added in names.between.values() for name in added)}
        return {"link": links, "joint": joints, "frame": {*names.frames.values()}}

    def _chains(self) -> list[Joint | Loop]:
        """What is joints in an SDF."""
        return [*(joint for joint in self.robot.joints if joint.type != "free"), *self.robot.loops]

    def lump(self, link: str) -> Lump:
        own = self.model.links[self.names.links[link]].inertial
        return own.mass, own.com, own.inertia

    def odd_masses(self) -> Iterator[tuple[str, float, Finding]]:
        """Of the links between the dofs of a joint or loop."""
        for name in (name for added in self.names.between.values() for name in added):
            mass = self.model.links[name].inertial.mass
            yield name, mass, differs(named("link", name), self.words.mass, mass, 0.0, "kg")

    def poses(self, q: Configuration) -> Poses:
        model, names, robot = self.model, self.names, self.robot
        dofs = [dof for dof in robot.dofs if dof.kind != "free"]
        moved = moved_links(model, {names.joints[dof.name]: self._motion(dof, q[dof.name]) for dof in dofs})
        from_model = inverse(moved[names.links[robot.root.name]])
        frames = {}
        for frame in robot.frames:
            own = model.frames[names.frames[frame.name]]
            in_link = inverse(model.links[own.link].model_from_link) @ own.model_from_frame
            frames[frame.name] = from_model @ moved[own.link] @ in_link
        return Poses({name: from_model @ moved[own] for name, own in names.links.items()}, frames)

    def _motion(self, dof: Dof, value: Value, *, backwards: bool = False) -> Array:
        """How the joint of a dof moves its frame (4, 4); `backwards`: where it runs from the first link of a
        loop to the second."""
        stands, axis = self.standing[dof.name], self.model.joints[self.names.joints[dof.name]].axis
        if isinstance(value, tuple) or isinstance(stands, tuple):
            first, last = (motion(dof.kind, dof.axis, one) for one in (stands, value))
            return first @ inverse(last) if backwards else inverse(first) @ last
        return motion(dof.kind, np.full(3, np.nan) if axis is None else axis, value - stands)

    def parent(self, link: str) -> str:
        names = {own: name for name, own in self.names.links.items()}
        above: dict[str, str] = {}
        for joint in self.model.joints.values():
            above.setdefault(joint.child, joint.parent)
        own = above.get(self.names.links[link], "")
        while own in above and own not in names:
            own = above[own]
        return names.get(own, "")

    def joints(self) -> Iterator[FoundJoint]:
        for one in self._chains():
            for dof, name in zip(one.dofs or (None,), _own_names(one), strict=True):
                own = self.model.joints[self.names.joints[name]]
                types = ("fixed",) if dof is None else TYPES[dof.kind]
                numbers, wanted = self._numbers(own, dof)
                if "lower" in wanted and not np.isinf([wanted["lower"], wanted["upper"]]).all():
                    types = types[:1]  # readers leave out the limits of a continuous one
                yield FoundJoint(name, named("joint", own.name), own.type, types, dof, numbers, wanted)

    def _numbers(self, joint: ReadJoint, dof: Dof | None) -> tuple[Numbers, Numbers]:
        """What a joint says, and its limits from where it stands. SDF has nothing of a ball."""
        if dof is None or dof.kind == "ball":
            return {}, {}
        zero, own, (low, high) = self.standing[dof.name], joint.dynamics, dof.limits.interval
        assert not isinstance(zero, tuple)
        lower, upper = joint.limits.interval
        numbers = {
            "lower": lower,
            "upper": upper,
            "effort": np.inf if own.effort is None else own.effort,
            "velocity": np.inf if own.velocity is None else own.velocity,
            "damping": own.damping or 0.0,
            "friction": own.friction or 0.0,
        }
        return numbers, {"lower": low - zero, "upper": high - zero}

    def mimics(self) -> Iterator[FoundMimic]:
        names = {own: name for name, own in self.names.joints.items()}
        for joint in self.model.joints.values():
            mimic = joint.mimic
            if mimic is None:
                continue
            follower, driver = (names.get(one, one) for one in (joint.name, mimic.joint))
            zeros = [self.standing.get(one, 0.0) for one in (follower, driver)]
            first, second = (0.0 if isinstance(one, tuple) else one for one in zeros)
            offset = mimic.offset - mimic.multiplier * (mimic.reference + second) + first
            yield FoundMimic(follower, driver, mimic.multiplier, offset)

    def places(self, loop: Loop, q: Configuration) -> Iterator[FoundPlace]:
        """The link at the end of a loop's joints, from where the robot's chain implies it."""
        poses, turned = link_poses(self.robot, q), chain(loop.dofs, q)
        first, second = (self.names.links[name] for name in (loop.link_a, loop.link_b))
        joints = [self.model.joints[self.names.joints[name]] for name in _own_names(loop)]
        element, backwards = named("joint", joints[0].name), joints[-1].parent == first
        if backwards:
            joints, ends, pose = joints[::-1], (first, second), poses[loop.link_a]
            implied = pose @ loop.a_from_frame @ inverse(turned) @ inverse(loop.b_from_frame)
        else:
            ends, pose = (second, first), poses[loop.link_b]
            implied = pose @ loop.b_from_frame @ turned @ inverse(loop.a_from_frame)
        found: Array | None = None
        if [*(one.parent for one in joints), ends[1]] == [ends[0], *(one.child for one in joints)]:
            found, dofs = pose, loop.dofs[::-1] if backwards else loop.dofs
            for joint, dof in zip_longest(joints, dofs):
                moved = None if dof is None else self._motion(dof, q[dof.name], backwards=backwards)
                found = child_pose(self.model, joint, found, moved)
        yield FoundPlace(element, ("pose, axis", "pose, axis"), found, implied)

    def first_checks(self) -> Iterator[Check]:
        yield missing_meshes(self.path)

    def own_checks(self) -> Iterator[Check]:
        """How the model stands, its shapes, and what collides."""
        model, links, geometry = self.model, self.names.links, self.written.geometry
        found = of_model(model, self.robot, links[self.robot.root.name], self.written.scene)
        yield self.found_none("model", "name, place and gravity of the model", found)
        if geometry is None:
            return
        total = f"{count(len(geometry.shapes), 'shape')} of the robot"
        detail = f"{total}, with their files, sizes, places and colours"
        looks = self.found_none("shapes", detail, shapes(model, links, geometry))
        yield looks
        # Masks are those of the robot's colliders only where there are as many.
        if looks.passed:
            detail = f"what collides of {total}"
            yield self.found_none("contacts", detail, contacts(model, links, geometry))


check_file = partial(checks_by, ReadSdf)


def _own_names(one: Joint | Loop) -> list[str]:
    """Of the dofs of a joint or loop, or its own where it has none."""
    return [dof.name for dof in one.dofs] or [one.name]


def _seven(pose: Array) -> tuple[float, ...]:
    return (*map(float, pose[:3, 3]), *map(float, quat_from_rotation(pose[:3, :3])))
