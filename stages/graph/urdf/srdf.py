"""Reads an SRDF for the robot in a URDF, by the names in the files, and lists the parts left out."""

from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import TypeVar

from linkwright.stages.formats.srdf.parse import (
    Srdf,
    SrdfEndEffector,
    SrdfGroup,
    SrdfState,
    SrdfVirtualJoint,
    parse_srdf,
)
from linkwright.stages.formats.urdf.model import Urdf
from linkwright.stages.graph.mechanism import WORLD_LINK, Mechanism
from linkwright.stages.graph.urdf.dummy_links import UrdfFrame
from linkwright.stages.graph.urdf.naming import UrdfFileNames
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.model.robot import Keyframe
from linkwright.stages.robot.model.semantics import (
    DisabledPair,
    EndEffector,
    JointGroup,
    RobotSemantics,
    VirtualJoint,
)
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count

REQUEST_NAME, NAME_OPTION = "robot.srdf", "srdf"
"""The request of a bundle for an SRDF's text, and the option that has its name."""

ONE_VALUE_TYPES = ("revolute", "continuous", "prismatic")
"""Types of joints with a single value."""

MAX_GROUP_DEPTH, MAX_CHAIN_JOINTS, MAX_DISABLED_PAIRS = 64, 10_000_000, 1_000_000
"""Limits for untrusted files: the depth of groups in groups, the number of joints of all chains together,
and the number of pairs of links whose collisions the default of a link disables."""

Item = TypeVar("Item", SrdfGroup, SrdfEndEffector, SrdfVirtualJoint)

DEFAULT_REASON = "User"
"""The reason of collisions that the default of a link disables."""

BASE_TYPES = ("fixed", "floating")
"""Types of a virtual joint that are possible for a robot's base."""


def with_srdf(
    mechanism: Mechanism,
    bundle: FileBundle,
    file: tuple[Urdf, Sequence[UrdfFrame], UrdfFileNames],
    log: Diagnostics,
) -> Mechanism:
    """Returns the mechanism of a URDF with the content of the SRDF in its bundle, if any. `file`: the URDF as
    its file has it, its links that are frames of other links, and the robot's names.

    I-SRDF lists what the SRDF gave; W-SRDF lists the parts left out.
    """
    digest = bundle.requests.get(REQUEST_NAME)
    if digest is None:
        return mechanism
    urdf, frames, names = file
    assert mechanism.root is not None
    root = mechanism.bodies[mechanism.root]
    reader = SrdfReader(parse_srdf(bundle.body(digest)), urdf, frames, root.path[0])
    semantics, base = reader.semantics()
    keyframes = reader.keyframes(names)
    reader.report(bundle.options.get(NAME_OPTION, "the SRDF"), semantics, keyframes, base, log)
    if base == "fixed" and not root.fixed_reason:
        root = replace(root, fixed_reason="the SRDF's virtual joint fixes it to the world")
    bodies = tuple(root if number == mechanism.root else body for number, body in enumerate(mechanism.bodies))
    unstated = None if base else mechanism.unstated_base
    return replace(mechanism, bodies=bodies, unstated_base=unstated, keyframes=keyframes, semantics=semantics)


class SrdfReader:
    """Reads an SRDF's content for a robot. `urdf`: as its file has it; `frames`: its links that are frames of
    other links; `root`: its root link."""

    def __init__(self, srdf: Srdf, urdf: Urdf, frames: Sequence[UrdfFrame], root: str) -> None:
        self.srdf, self.root = srdf, root
        self.links = {link.name: link for link in urdf.links}
        self.joints = {joint.name: joint for joint in urdf.joints}
        self.above = {joint.child: joint for joint in urdf.joints}
        self.carrier = {name: name for name in self.links} | {frame.name: frame.link for frame in frames}
        self.virtual = {joint.name for joint in srdf.virtual_joints}
        self.steps = 0
        self.unknown: dict[str, str] = {}
        self.left_out = list(srdf.left_out)
        self.groups: dict[str, SrdfGroup] = self._first_of_name(srdf.groups, "group")

    def semantics(self) -> tuple[RobotSemantics, str]:
        """Returns everything except the poses, with joints, links and frames by their names in the URDF; and
        the type of the base, "" if the SRDF does not state it."""
        base, kind = self._base()
        groups = tuple(self._groups())
        passive = dict.fromkeys(self._known_names(self.joints, "joint", self.srdf.passive, "a passive joint"))
        semantics = RobotSemantics(
            groups,
            tuple(self._end_effectors({group.name for group in groups})),
            tuple(passive),
            tuple(self._disabled()),
            base,
        )
        return semantics, kind

    def keyframes(self, names: UrdfFileNames) -> tuple[Keyframe, ...]:
        """Returns the poses, by the robot's dofs; poses of the same name for several groups are merged."""
        poses: dict[str, dict[str, float]] = {}
        for state in self.srdf.states:
            pose = poses.setdefault(state.name, {})
            for joint, value in self._values(state):
                for dof in names.dofs.get(joint, ()):
                    if pose.setdefault(dof, value) != value:
                        self.left_out.append(f"a second value of {joint} in the state {state.name}")
        self.left_out += [
            f"the state {name or 'without a name'}" for name in poses if not (name and poses[name])
        ]
        return tuple(Keyframe(name, tuple(pose.items())) for name, pose in poses.items() if name and pose)

    def report(
        self, name: str, semantics: RobotSemantics, keyframes: Sequence[Keyframe], base: str, log: Diagnostics
    ) -> None:
        """Reports I-SRDF with what the file `name` gave, and W-SRDF with the parts left out."""
        touching = sum(pair.touches for pair in semantics.disabled)
        never = len(semantics.disabled) - touching
        poses = f" ({name_list(keyframe.name for keyframe in keyframes)})" if keyframes else ""
        numbers = {
            count(len(semantics.groups), "group"): len(semantics.groups),
            count(len(keyframes), "pose") + poses: len(keyframes),
            f"{count(touching, 'pair')} of links that do not collide": touching,
            f"{count(never, 'pair')} that never touch, whose contacts stay": never,
            count(len(semantics.end_effectors), "end effector"): len(semantics.end_effectors),
            count(len(semantics.passive), "passive joint"): len(semantics.passive),
            f"a {base} base": len(base),
        }
        contents = ", ".join(text for text, number in numbers.items() if number) or "nothing"
        log.report("I-SRDF", f"the robot's SRDF is read: {contents}", name, "source.srdf=none leaves it out")
        if self.unknown:
            names = (f"{name} ({where})" for name, where in self.unknown.items())
            text = f"it names elements that the URDF does not have: {name_list(names)}"
            log.report("W-SRDF", text, name, "correct the names, or build without it: source.srdf=none")
        if self.left_out:
            text = f"parts of the SRDF are left out: {name_list(self.left_out)}"
            hint = "if the robot needs them, set contact.exclude, keyframes, actuators or root"
            log.report("W-SRDF", text, name, hint)

    def _first_of_name(self, items: Iterable[Item], kind: str) -> dict[str, Item]:
        """Returns the items by name; of two with the same name the first."""
        first: dict[str, Item] = {}
        for item in items:
            if not item.name:
                self.left_out.append(f"the {kind} without a name")
            elif item.name in first:
                self.left_out.append(f"the second {kind} {item.name}")
            else:
                first[item.name] = item
        return first

    def _base(self) -> tuple[VirtualJoint | None, str]:
        base: tuple[VirtualJoint | None, str] = (None, "")
        for name, joint in self._first_of_name(self.srdf.virtual_joints, "virtual joint").items():
            if joint.child_link != self.root:
                self.left_out.append(f"the virtual joint {name}, which does not hold the root {self.root}")
            elif joint.type not in BASE_TYPES:
                self.left_out.append(
                    f"the virtual joint {name}: the base cannot be {joint.type or 'without a type'}"
                )
            elif base[0] is not None:
                self.left_out.append(f"the virtual joint {name}: the base has another")
            else:
                frame = joint.parent_frame
                world = frame if frame and frame not in self.links else WORLD_LINK
                base = VirtualJoint(name, world), joint.type
        return base

    def _groups(self) -> Iterator[JointGroup]:
        resolved: dict[str, list[str]] = {}
        for name, group in self.groups.items():
            joints = self._joints_of(name, resolved, set())
            if not joints:
                self.left_out.append(f"the group {name}, which moves nothing")
                continue
            is_chain = len(group.chains) == 1 and joints == self._chain(*group.chains[0])
            base, tip = group.chains[0] if is_chain else ("", "")
            yield JointGroup(name, tuple(joints), base, tip)

    def _joints_of(self, name: str, resolved: dict[str, list[str]], ancestors: set[str]) -> list[str]:
        """Returns the joints of a group that move: its own, those above its links, of its chains and its
        groups."""
        if name in resolved:
            return resolved[name]
        if name in ancestors or len(ancestors) > MAX_GROUP_DEPTH:
            nesting = "within itself" if name in ancestors else f"within more than {MAX_GROUP_DEPTH} others"
            self.left_out.append(f"the group {name} {nesting}")
            return []
        group, where = self.groups[name], f"the group {name}"
        self.left_out += [f"{joint} in {where}" for joint in group.joints if joint in self.virtual]
        group_joints = [joint for joint in group.joints if joint not in self.virtual]
        joints = list(self._known_names(self.joints, "joint", group_joints, where))
        for link in self._known_names(self.links, "link", group.links, where):
            joints += [self.above[link].name] if link in self.above else []
        for base, tip in group.chains:
            if len(list(self._known_names(self.links, "link", (base, tip), where))) == 2:
                joints += self._chain(base, tip)
        for inner in self._known_names(self.groups, "group", group.groups, where):
            joints += self._joints_of(inner, resolved, {*ancestors, name})
        resolved[name] = [joint for joint in dict.fromkeys(joints) if self.joints[joint].type != "fixed"]
        return resolved[name]

    def _chain(self, base: str, tip: str) -> list[str]:
        """Returns the moving joints from the link `base` to the link `tip`; empty if `tip` is not below
        `base`."""
        names: list[str] = []
        while tip != base:
            joint = self.above.get(tip)
            self.steps += 1
            if joint is None or self.steps > MAX_CHAIN_JOINTS:
                return []
            names += [joint.name] if joint.type != "fixed" else []
            tip = joint.parent
        return names[::-1]

    def _end_effectors(self, groups: Collection[str]) -> Iterator[EndEffector]:
        for name, effector in self._first_of_name(self.srdf.end_effectors, "end effector").items():
            where, arm = f"the end effector {name}", effector.parent_group
            if not list(self._known_names(self.links, "link", [effector.parent_link], where)):
                continue
            if effector.group not in groups:
                self.left_out.append(f"{where}: nothing moves in its group {effector.group}")
                continue
            if arm and arm not in groups:
                self.left_out.append(f"the parent group {arm} of {where}")
            yield EndEffector(name, effector.group, effector.parent_link, arm if arm in groups else "")

    def _values(self, state: SrdfState) -> Iterator[tuple[str, float]]:
        values, where = dict(state.values), f"the state {state.name}"
        # Pinocchio's files have the place of a free base as a joint that no URDF has.
        base_joints = {name for name in values if name in self.virtual or len(values[name]) > 1}
        base_joints -= self.joints.keys()
        self.left_out += [
            f"the place of the base ({name}) in {where}" for name in values if name in base_joints
        ]
        names = [name for name in values if name not in base_joints]
        for name in self._known_names(self.joints, "joint", names, where):
            numbers, type_ = values[name], self.joints[name].type
            if type_ in ONE_VALUE_TYPES and len(numbers) == 1:
                yield name, numbers[0]
            elif type_ != "fixed":
                self.left_out.append(f"{count(len(numbers), 'value')} of {name} in {where}")

    def _disabled(self) -> Iterator[DisabledPair]:
        """Yields the pairs of links that have bodies. A body has the shapes of the links that are frames of
        it, so collisions with each of these must be disabled."""
        links_of_body: dict[str, list[str]] = {}
        for name, link in self.links.items():
            if link.collisions or link.visuals:
                links_of_body.setdefault(self.carrier[name], []).append(name)
        reasons = self._reasons([name for names in links_of_body.values() for name in names])
        bodies = dict.fromkeys(tuple(sorted({self.carrier[name] for name in pair})) for pair in reasons)
        for a, b in (pair for pair in bodies if len(pair) == 2):
            shapes = links_of_body.get(a, []), links_of_body.get(b, [])
            is_comparable = len(shapes[0]) * len(shapes[1]) <= len(reasons)
            pairs = [frozenset(pair) for pair in product(*shapes)] if is_comparable else []
            disabled = [DisabledPair(a, b, reasons[pair]) for pair in pairs if pair in reasons]
            touching = [pair for pair in disabled if pair.touches]
            if disabled and len(disabled) == len(pairs):
                yield (touching or disabled)[0]
            elif touching or not is_comparable:
                self.left_out.append(f"disabled collisions of only a part of {a} with {b}")

    def _reasons(self, links_with_bodies: Sequence[str]) -> dict[frozenset[str], str]:
        """Returns the reasons of disabled collisions by pair of links. `links_with_bodies`: the links that
        have bodies, with which the default of a link disables its collisions, unless they are enabled."""
        reasons: dict[frozenset[str], str] = {}
        for first, second, reason in self.srdf.disabled:
            if len(list(self._known_names(self.links, "link", (first, second), "disabled collisions"))) == 2:
                reasons.setdefault(frozenset((first, second)), reason)
        default_links = dict.fromkeys(self.srdf.disabled_links)
        links = list(self._known_names(self.links, "link", default_links, "disabled default collisions"))
        if len(links) * len(links_with_bodies) > MAX_DISABLED_PAIRS:
            self.left_out.append(
                f"disabled default collisions, which are more than {MAX_DISABLED_PAIRS} pairs"
            )
            return reasons
        pairs = dict.fromkeys(frozenset((link, partner)) for link in links for partner in links_with_bodies)
        enabled = {frozenset(pair) for pair in self.srdf.enabled}
        return dict.fromkeys((pair for pair in pairs if pair not in enabled), DEFAULT_REASON) | reasons

    def _known_names(
        self, names_known: Collection[str], kind: str, names: Iterable[str], where: str
    ) -> Iterator[str]:
        """Yields the names that are known; others are reported."""
        for name in names:
            if name in names_known:
                yield name
            else:
                self.unknown.setdefault(f"the {kind} {name or 'without a name'}", where)
