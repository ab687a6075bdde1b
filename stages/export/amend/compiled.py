"""Compiles an amended MJCF, counts what it adds to the robot, and completes the keyframes for it."""

import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import mujoco

from linkwright.stages.export.amend.documents import Documents, Refused
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.xml import Element, to_bytes
from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.mujoco.includes import replace_include
from linkwright.stages.mujoco.names import actuator_count, controls_of
from linkwright.stages.robot.model.amendments import Amendment, Surplus
from linkwright.stages.robot.text.globs import did_you_mean

_QPOS_SIZES = {0: 7, 1: 4, 2: 1, 3: 1}
"""MuJoCo's joint type (free, ball, slide, hinge) → the number of its values in qpos."""

_QVEL_SIZES = {0: 6, 1: 3, 2: 1, 3: 1}
"""MuJoCo's joint type → the number of its values in qvel."""


_UNKNOWN_ATTRIBUTE = re.compile(r"unrecognized attribute: '([^']+)' Element '([^']+)'")
"""MuJoCo's message for an attribute that it does not know: the attribute and the tag."""


def compiled(documents: Documents, role: str, meshes: Mapping[str, bytes]) -> Any:
    """Returns the model of the file with a role, without its keyframes. Raises NotCompiled if MuJoCo refuses
    it. `meshes`: path → content."""
    root = _whole_root(documents, role)
    for keyframe in root.findall("keyframe"):
        root.remove(keyframe)
    return compiled_text(to_bytes(root), meshes)


def _whole_root(documents: Documents, role: str) -> Element:
    """Returns a copy of the root of the file with a role; in the scene, the robot's file takes the place of
    its include."""
    roots = {document.role: document.root for document in documents.files}
    root = deepcopy(roots[role])
    include = root.find("include")
    if role == "scene" and include is not None:
        replace_include(include, list(deepcopy(roots["robot"])))
    return root


def fit_keyframes(
    documents: Documents, before: Documents, changes: Sequence[Amendment], meshes: Mapping[str, bytes]
) -> list[Surplus]:
    """Completes the keyframes with values for the joints and actuators that were added, and returns what is
    not the robot's own in each file that changed, and in the scene. `before`: the files without the
    amendments; `meshes`: path → content.

    The keyframes are in the robot's file, or in the scene if an MJCF source has moving bodies or actuators
    there. Raises NotCompiled if MuJoCo refuses a file, and Refused if the keyframes cannot have the values:
    the scene adds joints or actuators to keyframes of the robot's file, or joints have no names.
    """
    robot, scene = documents.files
    old_root, old_scene = before.files[0].root, before.files[1].root
    changed = {change.file for change in changes}
    surpluses = []
    robot_surplus = Surplus(robot.path)
    if robot.path in changed:
        model = compiled(documents, "robot", meshes)
        if model.njnt != len(_joints(robot.root)):
            text = (
                "joints that <replicate>, <composite> and the like make have no place in robot.json's `order`"
            )
            raise Refused(text, "elements", "write these bodies out, or leave out their joints")
        robot_surplus = _surplus(robot.path, model, old_root)
        _complete_keyframes(robot.root, old_root, model)
        surpluses.append(robot_surplus)
    scene_surplus = Surplus(scene.path, robot_surplus.dofs, robot_surplus.actuators, robot_surplus.equalities)
    # Surroundings of an MJCF source, which count as surplus, too.
    has_mechanism = any(old_scene.find(tag) is not None for tag in ("keyframe", "equality", "actuator"))
    if scene.path in changed or (changed and has_mechanism):
        model = compiled(documents, "scene", meshes)
        scene_surplus = _surplus(scene.path, model, old_root)
        _complete_keyframes(scene.root, _whole_root(before, "scene"), model)
        if robot.root.find("keyframe") is not None:
            _refuse_scene_additions(
                robot_surplus,
                scene_surplus,
                [change.key for change in changes if change.file == scene.path and change.adds],
            )
    return [*surpluses, scene_surplus]


def suggestion_for(message: str) -> str:
    """Returns a suggestion for an attribute that MuJoCo does not know, from its error message."""
    match = _UNKNOWN_ATTRIBUTE.search(message)
    if match is not None:
        attribute, tag = match.groups()
        if suggestion := did_you_mean(attribute, sorted(_attributes(tag)), 3):
            return suggestion
    return "MuJoCo's XML reference says what is allowed there"


def _attributes(tag: str) -> set[str]:
    """Returns the attributes that the installed MuJoCo knows for elements with this tag."""
    attributes: set[str] = set()
    inside = False
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = re.match(r" *(\S+) \(.\) *(.*)", line)
        if match is not None:
            inside = match[1].removeprefix("(world)") == tag
        if inside:
            attributes |= set((match[2] if match is not None else line).split())
    return attributes


def _surplus(path: str, model: Any, old: Element) -> Surplus:
    """Returns what the model of a file has beyond the robot. `old`: the root of the robot's file before the
    amendments."""
    old_joints = set(_joints(old))
    added = [index for index in range(model.njnt) if model.joint(index).name not in old_joints]
    return Surplus(
        path,
        dofs=sum(_QVEL_SIZES[int(model.jnt_type[index])] for index in added),
        actuators=actuator_count(model) - len(_actuators(old)),
        equalities=int(model.neq) - sum(len(section) for section in old.findall("equality")),
    )


def _refuse_scene_additions(robot: Surplus, scene: Surplus, keys: Sequence[str]) -> None:
    """Raises Refused if the scene adds joints or actuators. `keys`: the entries that add to the scene."""
    for kind, robot_count, scene_count in (
        ("joints", robot.dofs, scene.dofs),
        ("actuators", robot.actuators, scene.actuators),
    ):
        if scene_count != robot_count and keys:
            text = f"it adds {kind} to {scene.file}, for which the robot's keyframes have no values"
            raise Refused(
                text, keys[-1], f"leave out `file: scene`: in {robot.file} the keyframes get values"
            )


def _joints(root: Element) -> list[str]:
    """Returns the names of the joints, in the order of qpos."""
    return [
        joint.get("name", "")
        for world in root.findall("worldbody")
        for joint in world.iter("joint", "freejoint")
    ]


def _actuators(root: Element) -> list[str]:
    return [actuator.get("name", "") for section in root.findall("actuator") for actuator in section]


def _complete_keyframes(root: Element, old: Element, model: Any) -> None:
    """Completes the keyframes of `root`. `old`: the file before the amendments, which the keyframes fit."""
    keys = {key.get("name") for key in old.iterfind("keyframe/key")}
    for key in root.iterfind("keyframe/key"):
        if key.get("name") in keys:
            _complete_keyframe(key, old, model)


def _complete_keyframe(key: Element, old: Element, model: Any) -> None:
    """Completes `qpos` and `ctrl` of a keyframe: what was added has its value at qpos0, and the control 0."""
    values = key.get("qpos", "").split()
    if len(values) != model.nq:
        texts = [number(float(value)) for value in model.qpos0]
        start = 0
        names = _joints(old)
        if "" in names:
            text = "a joint has no name, so its values in the keyframes are unknown after this change"
            raise Refused(text, "elements", "name it in the source, or leave out the elements with joints")
        for name in names:
            joint = model.joint(name)
            size, address = _QPOS_SIZES[int(joint.type[0])], int(joint.qposadr[0])
            texts[address : address + size] = values[start : start + size]
            start += size
        if start == len(values):
            key.set("qpos", " ".join(texts))
    values = key.get("ctrl", "").split()
    names = _actuators(old)
    if values and len(values) == len(names) != model.nu:
        texts = ["0"] * model.nu
        for name, text in zip(names, values, strict=True):
            texts[controls_of(model, model.actuator(name).id).start] = text
        key.set("ctrl", " ".join(texts))
