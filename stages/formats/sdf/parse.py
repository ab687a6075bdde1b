"""Parses SDF text to an `SdfModel`: the elements that this product writes, and strict about the rest.

Poses are resolved as SDF 1.9 says: `relative_to` names a link, joint or frame; without it a link is in the
model's frame, a joint in that of its child, a frame in the frame that it is attached to. Elements that are
not read but would change a meaning are errors.
"""

from collections.abc import Mapping

import numpy as np

from linkwright.stages.formats.sdf.elements import (
    SdfError,
    bound,
    number,
    numbers,
    pose_of,
    required_element,
    truth,
)
from linkwright.stages.formats.sdf.model import ReadJoint, SdfFrame, SdfLink, SdfMimic, SdfModel
from linkwright.stages.formats.sdf.names import WORLD
from linkwright.stages.formats.sdf.shapes import shapes_of
from linkwright.stages.formats.xml import Element, Malformed, parse
from linkwright.stages.robot.model.poses import inverse
from linkwright.stages.robot.model.robot import Array, Dynamics, Inertial, Limits, frozen

VERSIONS = ("1.7", "1.8", "1.9", "1.10", "1.11", "1.12")
"""The versions of SDF in which names and poses mean the same."""

TYPES = ("fixed", "continuous", "revolute", "prismatic", "ball")
"""The types of joints that are read."""

MODEL = "__model__"
"""The name of the model's own frame."""

_NOT_READ = ("include", "model", "static", "placement_frame")
"""Elements of a model that would change the meaning of the rest."""


def parse_sdf(data: bytes) -> SdfModel:
    """Returns the model of a file.

    Raises SdfError if it is not XML, has no model or several, has a name twice, refers to a missing thing,
    lacks a number, or has elements that would have to be understood.
    """
    try:
        root = parse(data)
    except Malformed as error:
        raise SdfError(str(error)) from None
    models = root.findall("model")
    if root.tag != "sdf" or root.get("version") not in VERSIONS or len(models) != 1:
        raise SdfError(f"not one model of SDF {VERSIONS[0]} to {VERSIONS[-1]}")
    return _Reader(models[0]).model()


class _Reader:
    """The reader of a model element, with the named elements in it."""

    def __init__(self, top: Element) -> None:
        self._top = top
        self._kinds = {kind: _named(top, kind) for kind in ("link", "joint", "frame")}
        self._elements: dict[str, Element] = {}
        for nodes in self._kinds.values():
            shared_names = sorted(set(nodes) & set(self._elements))
            if shared_names:
                raise SdfError(f"two things are named {shared_names[0]!r}")
            self._elements |= nodes
        tags = [tag for tag in _NOT_READ if top.find(tag) is not None]
        if tags:
            raise SdfError(f"<{tags[0]}> of a model is not read")
        if not self._kinds["link"]:
            raise SdfError("the model has no link")
        self._places: dict[str, Array] = {MODEL: np.eye(4)}
        """Name → model_from_frame (4, 4), for those computed so far."""

    def model(self) -> SdfModel:
        """Returns the model of the file."""
        links = {name: self._link(name, node) for name, node in self._kinds["link"].items()}
        root = self._top.get("canonical_link") or next(iter(links))
        joints = {name: self._joint(name, node) for name, node in self._kinds["joint"].items()}
        frames = {
            name: SdfFrame(name, self._moves_with(name), self._place(name)) for name in self._kinds["frame"]
        }
        return SdfModel(
            str(self._top.get("name")),
            self._link_named(root),
            links,
            joints,
            frames,
            frozen(pose_of(self._top.find("pose"))),
            truth(self._top, "self_collide", unless=False),
        )

    def _link_named(self, name: str) -> str:
        """Returns the name. Raises SdfError if there is no link of this name."""
        if name not in self._kinds["link"]:
            raise SdfError(f"there is no link {name!r}")
        return name

    def _place(self, name: str) -> Array:
        """Returns model_from_frame (4, 4) of a link, joint or frame. Raises SdfError if the name, or one that
        its pose is relative to, does not exist, or if its pose is relative to itself."""
        # Not recursive: a chain of frames may be longer than Python's stack.
        reference_of: dict[str, str] = {}
        unplaced = name
        while unplaced not in self._places:
            if unplaced in reference_of:
                raise SdfError(f"the pose of {unplaced!r} is relative to itself")
            if unplaced not in self._elements:
                raise SdfError(f"nothing is named {unplaced!r}")
            reference = self._reference(self._elements[unplaced])
            reference_of[unplaced] = reference
            unplaced = reference
        for frame, reference in reversed(reference_of.items()):
            pose = pose_of(self._elements[frame].find("pose"))
            self._places[frame] = self._places[reference] @ pose
        return self._places[name]

    @staticmethod
    def _reference(node: Element) -> str:
        """Returns the name of the frame in which an element has its pose."""
        default = {"joint": node.findtext("child"), "frame": node.get("attached_to")}.get(node.tag) or MODEL
        pose = node.find("pose")
        return str((None if pose is None else pose.get("relative_to")) or default)

    def _moves_with(self, name: str) -> str:
        """Returns the link that a frame moves with. Raises SdfError if it is on no link."""
        path: dict[str, None] = {}
        while name not in self._kinds["link"]:
            if name in path or name == MODEL or name not in self._elements:
                raise SdfError(f"the frame {next(iter(path), name)!r} is on no link")
            path[name] = None
            node = self._elements[name]
            name = str(node.findtext("child") if node.tag == "joint" else node.get("attached_to") or MODEL)
        return name

    def _link(self, name: str, node: Element) -> SdfLink:
        inertial = required_element(node, "inertial")
        link_from_inertial = pose_of(inertial.find("pose"))
        entries = {
            key: number(inertial, f"inertia/{key}") for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        }
        rows = [["ixx", "ixy", "ixz"], ["ixy", "iyy", "iyz"], ["ixz", "iyz", "izz"]]
        tensor = np.array([[entries[key] for key in row] for row in rows])
        rotation = link_from_inertial[:3, :3]
        tensor_in_link = rotation @ tensor @ rotation.T
        com = link_from_inertial[:3, 3]
        model_from_link = self._place(name)

        def link_from(frame: str) -> Array:
            return inverse(model_from_link) @ self._place(frame)

        return SdfLink(
            name,
            frozen(model_from_link),
            Inertial(number(inertial, "mass"), frozen(com), frozen(tensor_in_link)),
            shapes_of(node, "visual", link_from),
            shapes_of(node, "collision", link_from),
            falls=truth(node, "gravity", unless=True),
            forced=not truth(node, "kinematic", unless=False),
            self_collides=truth(node, "self_collide", unless=False),
        )

    def _joint(self, name: str, node: Element) -> ReadJoint:
        kind, parent = str(node.get("type")), str(required_element(node, "parent").text)
        if kind not in TYPES:
            raise SdfError(f"the type {kind} of the joint {name!r} is not read")
        if parent != WORLD:
            self._link_named(parent)
        child = self._link_named(str(required_element(node, "child").text))
        axis = node.find("axis/xyz")
        if axis is not None and axis.get("expressed_in"):
            raise SdfError(f"the joint {name!r} has its axis in the frame of something else")
        limits = Limits(*(bound(node, f"axis/limit/{key}") for key in ("lower", "upper")))
        dynamics = Dynamics(
            damping=bound(node, "axis/dynamics/damping"),
            friction=bound(node, "axis/dynamics/friction"),
            effort=bound(node, "axis/limit/effort"),
            velocity=bound(node, "axis/limit/velocity"),
        )
        pose = frozen(self._place(name))
        direction = None if axis is None else frozen(numbers(axis, 3))
        return ReadJoint(name, kind, parent, child, pose, direction, limits, dynamics, _mimic(node))


def _named(top: Element, tag: str) -> Mapping[str, Element]:
    """Returns the elements of this tag in a model, by name. Raises SdfError if a name is missing or there
    twice."""
    nodes = top.findall(tag)
    if not all(node.get("name") for node in nodes):
        raise SdfError(f"an element <{tag}> has no name")
    nodes_by_name = {str(node.get("name")): node for node in nodes}
    if len(nodes_by_name) != len(nodes):
        raise SdfError(f"two elements <{tag}> have the same name")
    return nodes_by_name


def _mimic(node: Element) -> SdfMimic | None:
    mimic = node.find("axis/mimic")
    if mimic is None:
        return None
    keys = ("multiplier", "offset", "reference")
    return SdfMimic(str(mimic.get("joint")), *(number(mimic, key) for key in keys))
