"""What an MJCF source alone has is in the MJCF and its scene, as MuJoCo compiles both: tendons and what acts
on them, cameras, lights, attributes, and what lies beside the robot."""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.mujoco import elements, fields
from linkwright.stages.mujoco.bodies import CompiledBodies, light_pose, placed, pose_of
from linkwright.stages.mujoco.names import body_index, index_of, name_of
from linkwright.stages.mujoco.sensors import sensor, sensor_attributes
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import Attributes, MjcfAttributes, MjcfElement, MjcfExtras
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import SCENE, CompiledModel
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.coordinates import SAME, of_the_scene

OBJ = mujoco.mjtObj

_ARRAYS: Mapping[str, tuple[Any, Callable[[Any, int], Attributes]]] = {
    "body": (OBJ.mjOBJ_BODY, lambda model, index: fields.attributes(model, fields.BODY, index)),
    "site": (OBJ.mjOBJ_SITE, elements.site_attributes),
    "actuator": (OBJ.mjOBJ_ACTUATOR, elements.actuator_attributes),
    "sensor": (OBJ.mjOBJ_SENSOR, sensor_attributes),
    "joint": (OBJ.mjOBJ_JOINT, fields.joint_attributes),
}
"""By kind of thing: MuJoCo's number of it, and what gives the attributes of the compiled one."""

_STRUCTURE = ("actuatorfrclimited", "actuatorfrcrange", "range")
"""Attributes that other checks look at, or that are no numbers of the compiled thing."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of an MJCF source, but for attributes that the user's own XML sets."""
    extras = compiled.robot.mjcf
    if extras is None or compiled.urdf:
        return
    if compiled.path.name == SCENE:
        expected = [*_elements(extras.scene), *_beside(extras)]
        found = [*_sections(compiled.model), *_world(compiled)]
        findings = _missing(compiled, expected, found)
    else:
        expected = list(_elements(extras.sections))
        findings = _missing(compiled, expected, list(_sections(compiled.model)))
        findings += _attributes(compiled, extras.attributes)
        findings += _geoms(compiled)
        findings += _mounted(compiled, extras)
        expected += [one.element for one in extras.mounted]
    total = len(expected)
    detail = f"{count(total, 'element')} that only an MJCF has"
    if findings:
        detail = f"not as the source has them: {', '.join(dict.fromkeys(one.element for one in findings))}"
    if total or findings:
        yield compiled.within("source elements", float(len(findings)), 0.0, detail, few(findings))


def _elements(sections: Iterable[MjcfElement]) -> Iterator[MjcfElement]:
    for section in sections:
        if section.tag not in ("asset", "worldbody"):
            yield from section.children


def _beside(extras: MjcfExtras) -> Iterator[MjcfElement]:
    """What is on the world of the scene."""
    for section in extras.scene:
        if section.tag == "worldbody":
            yield from section.children


def _sections(model: Any) -> Iterator[MjcfElement]:
    """The elements of a compiled model that are in no body."""
    yield from (elements.pair(model, index) for index in range(model.npair))
    yield from (elements.exclude(model, index) for index in range(model.nexclude))
    yield from (elements.tendon(model, index) for index in range(model.ntendon))
    yield from (one for index in range(model.neq) if (one := elements.equality(model, index)))
    for index in range(len(model.actuator_trntype)):
        yield from _titled(model, OBJ.mjOBJ_ACTUATOR, index, elements.actuator(model, index))
    for index in range(model.nsensor):
        yield from _titled(model, OBJ.mjOBJ_SENSOR, index, sensor(model, index))


def _titled(model: Any, kind: Any, index: int, element: MjcfElement | None) -> Iterator[MjcfElement]:
    if element is not None:
        title = (("name", name_of(model, kind, index)),)
        yield replace(element, attributes=(*title, *element.attributes))


def _world(compiled: CompiledModel) -> list[MjcfElement]:
    beside = of_the_scene(compiled.model, compiled.robot)
    mocap = {body for body in range(compiled.model.nbody) if compiled.model.body_mocapid[body] >= 0}
    return list(CompiledBodies(compiled.model, lambda body: body in beside or body in mocap).world())


def _missing(
    compiled: CompiledModel, expected: Sequence[MjcfElement], found: Sequence[MjcfElement]
) -> list[Finding]:
    """The expected elements that are not found, or are found otherwise."""
    by_name: dict[tuple[str, str], list[MjcfElement]] = {}
    for element in found:
        by_name.setdefault((element.tag, element.name), []).append(element)
    findings = []
    for element in expected:
        candidates = by_name.get((element.tag, element.name), [])
        wrong = [difference(compiled, element, one) for one in candidates]
        if not candidates:
            message = "is missing, or names something else"
            findings.append(Finding(named(element.tag, element.name), "name", message))
        elif all(wrong):
            findings.append(Finding(named(element.tag, element.name), *(wrong[0] or ("", ""))))
    return findings


def difference(compiled: CompiledModel, expected: MjcfElement, found: MjcfElement) -> tuple[str, str] | None:
    """(attribute, message) of the first difference of two elements, None where they are the same."""
    if _references(expected) != _references(found):
        return "name", f"names {[n for *_, n in found.names]}, expected {[n for *_, n in expected.names]}"
    for name in dict.fromkeys([*dict(expected.attributes), *dict(found.attributes)]):
        texts = dict(expected.attributes).get(name), dict(found.attributes).get(name)
        if name not in ("name", "mesh", "hfield") and not compiled.sets(name) and not _fits(name, *texts):
            return name, f"is {texts[1] or 'its default'}, expected {texts[0] or 'its default'}"
    if len(expected.children) != len(found.children):
        return "", f"has {len(found.children)} elements in it, expected {len(expected.children)}"
    pairs = zip(expected.children, found.children, strict=True)
    return next((wrong for pair in pairs if (wrong := difference(compiled, *pair))), None)


def _fits(name: str, expected: str | None, found: str | None) -> bool:
    """Whether an attribute says the same; a quaternion and its negative do."""
    if same(expected, found):
        return True
    if name != "quat" or expected is None:
        return False
    return same(" ".join(str(-float(number)) for number in expected.split()), found)


def _references(element: MjcfElement) -> dict[str, str]:
    """What the element names, by attribute."""
    return {attribute: name for attribute, _, name in element.names}


def same(expected: str | None, found: str | None) -> bool:
    """Whether two texts of an attribute have the same words and numbers."""
    if expected is None or found is None:
        return expected == found
    one, other = expected.split(), found.split()
    try:
        numbers = [np.array([float(word) for word in words]) for words in (one, other)]
    except ValueError:
        return one == other
    if len(one) != len(other):
        return False
    scale = max(1.0, float(np.abs(numbers[0]).max(initial=0.0)))
    return bool(np.abs(numbers[0] - numbers[1]).max(initial=0.0) <= SAME * scale)


def _attributes(compiled: CompiledModel, every: Sequence[MjcfAttributes]) -> list[Finding]:
    findings: list[Finding] = []
    for one in every:
        if one.kind not in _ARRAYS:
            continue
        kind, read = _ARRAYS[one.kind]
        index = index_of(compiled.model, kind, one.name)
        if index < 0:
            continue  # other checks look for the robot's own things
        found = read(compiled.model, index)
        findings += _changed(compiled, named(one.kind, one.name), one.attributes, found)
    return findings


def _changed(
    compiled: CompiledModel, element: str, expected: Attributes, found: Attributes
) -> Iterator[Finding]:
    """The expected attributes that are otherwise."""
    texts = dict(found)
    for name, text in expected:
        if name not in _STRUCTURE and not compiled.sets(name) and not same(text, texts.get(name)):
            yield Finding(element, name, f"is {texts.get(name, 'its default')}, expected {text}")


def _geoms(compiled: CompiledModel) -> Iterator[Finding]:
    """The names of geoms, and what no other format has of them."""
    shapes = () if compiled.geometry is None else compiled.geometry.shapes
    for form in dict.fromkeys(shape.form for shape in shapes if shape.form.name):
        element = named("geom", form.name)
        index = index_of(compiled.model, OBJ.mjOBJ_GEOM, form.name)
        if index < 0:
            yield Finding(element, "name", "there is no geom of this name")
        else:
            found = elements.geom_attributes(compiled.model, int(index))
            yield from _changed(compiled, element, form.attributes, found)


def _mounted(compiled: CompiledModel, extras: MjcfExtras) -> list[Finding]:
    """Of what is on the bodies, at its place."""
    model, findings = compiled.model, []
    own = {one.link: one.link_from_body for one in extras.bodies}
    at: dict[str, list[MjcfElement]] = {}
    for one in extras.mounted:
        holder, holder_from_link = compiled.held.get(one.link, (one.link, np.eye(4)))
        pose = holder_from_link @ own.get(one.link, np.eye(4)) @ one.body_from_element
        # The holder's body may be elsewhere than its frame, too.
        pose = np.linalg.inv(own.get(holder, np.eye(4))) @ pose
        at.setdefault(holder, []).append(placed(one.element, pose))
    for holder, expected in at.items():
        findings += _missing(compiled, expected, list(_on(model, body_index(model, holder))))
    return findings


def _on(model: Any, body: int) -> Iterator[MjcfElement]:
    """The cameras, lights, sites and geoms on a body."""
    for index in np.flatnonzero(model.cam_bodyid == body):
        pose = pose_of(model.cam_pos[index], model.cam_quat[index])
        yield placed(elements.camera(model, int(index)), pose)
    for index in np.flatnonzero(model.light_bodyid == body):
        yield placed(elements.light(model, int(index)), light_pose(model, int(index)))
    for index in np.flatnonzero(model.site_bodyid == body):
        pose = pose_of(model.site_pos[index], model.site_quat[index])
        yield placed(elements.site(model, int(index)), pose)
    for index in np.flatnonzero(model.geom_bodyid == body):
        found = elements.geom(model, int(index))
        pose = pose_of(model.geom_pos[index], model.geom_quat[index])
        yield placed(replace(found, attributes=(*found.attributes, ("mass", "0"))), pose)
