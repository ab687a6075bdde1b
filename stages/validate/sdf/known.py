"""An SDF that was read, and the robot that it must be: what is called what, and where zero is."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from stages.formats.sdf.kinematics import moved_links
from stages.formats.sdf.model import ReadJoint, SdfModel
from stages.formats.sdf.names import SdfNames
from stages.robot.check import Check, Finding
from stages.robot.kinematics import chain
from stages.robot.loops import across, closing
from stages.robot.model import Array, Configuration, Dof, Joint, Loop, Robot, Value
from stages.robot.poses import at_rest, inverse, motion, quat_from_rotation
from stages.robot.start_pose import starting_point
from stages.validate.coordinates import distance
from stages.validate.findings import few


@dataclass(frozen=True, slots=True, eq=False)
class ReadSdf:
    """`file`: its name; `model`: what was read; `robot`: what it must be, with its `names` there."""

    file: str
    model: SdfModel
    robot: Robot
    names: SdfNames
    stands: dict[str, Value] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "stands", _stands(self) if self._complete else {})

    @property
    def _complete(self) -> bool:
        return all(name in self.model.links for name in self.names.links.values())

    def result(self, name: str, passed: bool, detail: str) -> Check:
        return Check(f"{self.file}: {name}", passed, detail)

    def within(
        self, name: str, value: float, limit: float, detail: str, findings: Iterable[Finding] = ()
    ) -> Check:
        """The result of a check that passes where `value` is at most `limit`."""
        passed = value <= limit
        found = () if passed else few(findings)
        return Check(f"{self.file}: {name}", passed, detail, value, limit, findings=found)

    def joint_of(self, dof: Dof) -> ReadJoint:
        """The SDF's joint of a dof."""
        return self.model.joints[self.names.joints[dof.name]]

    def joints_of(self, one: Joint | Loop) -> list[ReadJoint]:
        """Those of a joint or loop, from its parent or second link."""
        names = [dof.name for dof in one.dofs] or [one.name]
        return [self.model.joints[self.names.joints[name]] for name in names]

    def moved(
        self, q: Configuration, *, backwards: bool = False, loop: Loop | None = None
    ) -> dict[str, Array]:
        """How the SDF's joints move their frames (4, 4) at values of the robot's dofs, or of those of a loop;
        `backwards`: of a loop whose joints run from its first link to its second."""
        dofs = loop.dofs if loop is not None else [dof for dof in self.robot.dofs if dof.kind != "free"]
        return {self.names.joints[dof.name]: self._motion(dof, q[dof.name], backwards) for dof in dofs}

    def _motion(self, dof: Dof, value: Value, backwards: bool) -> Array:
        stands, axis = self.stands[dof.name], self.joint_of(dof).axis
        if isinstance(value, tuple) or isinstance(stands, tuple):
            first, last = (motion(dof.kind, dof.axis, one) for one in (stands, value))
            return first @ inverse(last) if backwards else inverse(first) @ last
        return motion(dof.kind, np.full(3, np.nan) if axis is None else axis, value - stands)

    def poses(self, q: Configuration) -> dict[str, Array]:
        """root_from_link (4, 4) of the robot's links in the SDF."""
        moved = moved_links(self.model, self.moved(q))
        from_model = inverse(moved[self.names.links[self.robot.root.name]])
        return {name: from_model @ moved[own] for name, own in self.names.links.items()}


def _stands(read: ReadSdf) -> dict[str, Value]:
    """The value of each dof, also of loops, at which the links stand as in the file: zero or that of a fresh
    simulation, whichever is nearer; of free links the pose, of loops what closes them."""
    robot, start = read.robot, starting_point(read.robot)
    placed = {name: read.model.links[own].model_from_link for name, own in read.names.links.items()}
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


def _seven(pose: Array) -> tuple[float, ...]:
    return (*map(float, pose[:3, 3]), *map(float, quat_from_rotation(pose[:3, :3])))
