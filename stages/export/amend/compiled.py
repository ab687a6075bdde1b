"""MuJoCo's view of an amended MJCF: whether it compiles, what it has more than the robot, and keyframes with
values for that."""

import re
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any

import mujoco

from linkwright.stages.export.amend.documents import Documents, Refused
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.xml import Element, to_bytes
from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.mujoco.includes import put_in_place
from linkwright.stages.robot.model.amendments import Amendment, Surplus
from linkwright.stages.robot.text.globs import did_you_mean

_QPOS = {0: 7, 1: 4, 2: 1, 3: 1}
"""Numbers in qpos by the type of a joint: free, ball, slide, hinge."""

_QVEL = {0: 6, 1: 3, 2: 1, 3: 1}


def compiled(documents: Documents, role: str, meshes: Mapping[str, bytes]) -> Any:
    """The model of one of the files without its keyframes; NotCompiled where MuJoCo refuses it. `meshes`:
    by path."""
    roots = {one.role: one.root for one in documents.every}
    root = deepcopy(roots[role])
    include = root.find("include")
    if role == "scene" and include is not None:
        put_in_place(include, list(deepcopy(roots["robot"])))
    for one in root.findall("keyframe"):
        root.remove(one)
    return compiled_text(to_bytes(root), meshes)


def fit(
    documents: Documents, before: Documents, changes: Sequence[Amendment], meshes: Mapping[str, bytes]
) -> list[Surplus]:
    """Gives the robot's keyframes values for the joints and actuators that were added to its file, and says
    what each file has more than it had. NotCompiled where MuJoCo refuses a file; Refused where the scene
    has joints or actuators for which the keyframes, which are in the robot's file, have no values."""
    robot, scene = documents.every
    old = before.every[0].root
    changed = {one.file for one in changes}
    found = []
    more = Surplus(robot.path)
    if robot.path in changed:
        model = compiled(documents, "robot", meshes)
        if model.njnt != len(_joints(robot.root)):
            text = (
                "joints that <replicate>, <composite> and the like make have no place in robot.json's `order`"
            )
            raise Refused(text, "elements", "write these bodies out, or leave out their joints")
        more = _surplus(robot.path, model, old)
        _fit_keyframes(robot.root, old, model)
        found.append(more)
    above = Surplus(scene.path, more.dofs, more.actuators, more.equalities)
    if scene.path in changed:
        above = _surplus(scene.path, compiled(documents, "scene", meshes), old)
        if robot.root.find("keyframe") is not None:
            _require_no_more(more, above, [one.key for one in changes if one.file == scene.path and one.adds])
    return [*found, above]


def likely(message: str) -> str:
    """What a user may have meant, by MuJoCo's message about an attribute that it does not know."""
    found = _UNKNOWN.search(message)
    if found is not None:
        wrong, tag = found.groups()
        if near := did_you_mean(wrong, sorted(_attributes(tag)), 3):
            return near
    return "MuJoCo's XML reference says what is allowed there"


_UNKNOWN = re.compile(r"unrecognized attribute: '([^']+)' Element '([^']+)'")


def _attributes(tag: str) -> set[str]:
    """The attributes that the installed MuJoCo knows, of all elements with this tag."""
    found: set[str] = set()
    inside = False
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = re.match(r" *(\S+) \(.\) *(.*)", line)
        if match is not None:
            inside = match[1].removeprefix("(world)") == tag
        if inside:
            found |= set((match[2] if match is not None else line).split())
    return found


def _surplus(path: str, model: Any, before: Element) -> Surplus:
    known = set(_joints(before))
    added = [index for index in range(model.njnt) if model.joint(index).name not in known]
    return Surplus(
        path,
        dofs=sum(_QVEL[int(model.jnt_type[index])] for index in added),
        actuators=int(model.nu) - len(_actuators(before)),
        equalities=int(model.neq) - sum(len(one) for one in before.findall("equality")),
    )


def _require_no_more(robot: Surplus, scene: Surplus, keys: Sequence[str]) -> None:
    for what, here, there in (
        ("joints", robot.dofs, scene.dofs),
        ("actuators", robot.actuators, scene.actuators),
    ):
        if there != here and keys:
            text = f"it adds {what} to {scene.file}, for which the robot's keyframes have no values"
            raise Refused(text, keys[-1], f"leave out `file: scene`: in {robot.file} they get them")


def _joints(root: Element) -> list[str]:
    """The names of the joints, in the order of qpos."""
    return [
        one.get("name", "") for world in root.findall("worldbody") for one in world.iter("joint", "freejoint")
    ]


def _actuators(root: Element) -> list[str]:
    return [one.get("name", "") for section in root.findall("actuator") for one in section]


def _fit_keyframes(root: Element, before: Element, model: Any) -> None:
    """`before`: as the file was, with which the keyframes agree."""
    keys = {one.get("name") for one in before.iterfind("keyframe/key")}
    for key in root.iterfind("keyframe/key"):
        if key.get("name") in keys:
            _fit_key(key, before, model)


def _fit_key(key: Element, before: Element, model: Any) -> None:
    given = key.get("qpos", "").split()
    if len(given) != model.nq:
        texts = [number(float(value)) for value in model.qpos0]
        at = 0
        for name in _joints(before):
            joint = model.joint(name)
            width, place = _QPOS[int(joint.type[0])], int(joint.qposadr[0])
            texts[place : place + width] = given[at : at + width]
            at += width
        if at == len(given):
            key.set("qpos", " ".join(texts))
    given = key.get("ctrl", "").split()
    known = _actuators(before)
    if given and len(given) == len(known) != model.nu:
        texts = ["0"] * model.nu
        for name, text in zip(known, given, strict=True):
            texts[model.actuator(name).id] = text
        key.set("ctrl", " ".join(texts))
