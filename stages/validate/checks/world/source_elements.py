"""Checks that the MJCF and its scene have the elements that only an MJCF source has, as MuJoCo compiles both.

Such elements are tendons and what acts on them, cameras, lights, attributes, and objects besides the robot.
"""

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
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE, bodies_of_scene

OBJ = mujoco.mjtObj

_ATTRIBUTE_READERS: Mapping[str, tuple[Any, Callable[[Any, int], Attributes]]] = {
    "body": (OBJ.mjOBJ_BODY, lambda model, index: fields.attributes(model, fields.BODY, index)),
    "site": (OBJ.mjOBJ_SITE, elements.site_attributes),
    "actuator": (OBJ.mjOBJ_ACTUATOR, elements.actuator_attributes),
    "sensor": (OBJ.mjOBJ_SENSOR, sensor_attributes),
    "joint": (OBJ.mjOBJ_JOINT, fields.joint_attributes),
}
"""Kind of thing → MuJoCo's number, and the function that returns the attributes of a compiled thing."""

_SEPARATELY_COMPARED = ("actuatorfrclimited", "actuatorfrcrange", "range")
"""Attributes that other checks compare, or that the compiled thing does not have."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks robots from an MJCF source, except for attributes that the user's own XML sets."""
    extras = compiled.robot.mjcf
    if extras is None or compiled.urdf:
        return
    if compiled.path.name == SCENE:
        expected = [*_section_elements(extras.scene), *_scene_elements(extras)]
        actual = [*_elements_outside_bodies(compiled.model), *_world_elements(compiled)]
        findings = _element_findings(compiled, expected, actual)
    else:
        expected = list(_section_elements(extras.sections))
        findings = _element_findings(compiled, expected, list(_elements_outside_bodies(compiled.model)))
        findings += _attribute_findings(compiled, extras.attributes)
        findings += _geom_findings(compiled)
        findings += _body_element_findings(compiled, extras)
        expected += [mount.element for mount in extras.mounted]
    total = len(expected)
    detail = f"{count(total, 'element')} that only an MJCF has"
    if findings:
        names = ", ".join(dict.fromkeys(finding.element for finding in findings))
        detail = f"not as the source has them: {names}"
    if total or findings:
        yield compiled.within("source elements", float(len(findings)), 0.0, detail, few(findings))


def _section_elements(sections: Iterable[MjcfElement]) -> Iterator[MjcfElement]:
    """Yields the elements in these sections of an MJCF that are in no body, without assets."""
    for section in sections:
        if section.tag not in ("asset", "worldbody"):
            yield from section.children


def _scene_elements(extras: MjcfExtras) -> Iterator[MjcfElement]:
    """Yields the elements that the scene adds to the world."""
    for section in extras.scene:
        if section.tag == "worldbody":
            yield from section.children


def _elements_outside_bodies(model: Any) -> Iterator[MjcfElement]:
    """Yields the elements of a compiled model that are in no body."""
    yield from (elements.pair(model, index) for index in range(model.npair))
    yield from (elements.exclude(model, index) for index in range(model.nexclude))
    yield from (elements.tendon(model, index) for index in range(model.ntendon))
    yield from filter(None, (elements.equality(model, index) for index in range(model.neq)))
    for index in range(len(model.actuator_trntype)):
        yield from _with_title(model, OBJ.mjOBJ_ACTUATOR, index, elements.actuator(model, index))
    for index in range(model.nsensor):
        yield from _with_title(model, OBJ.mjOBJ_SENSOR, index, sensor(model, index))


def _with_title(model: Any, kind: Any, index: int, element: MjcfElement | None) -> Iterator[MjcfElement]:
    """Yields an element with its name as the first attribute; nothing for None."""
    if element is not None:
        title = (("name", name_of(model, kind, index)),)
        yield replace(element, attributes=(*title, *element.attributes))


def _world_elements(compiled: CompiledModel) -> list[MjcfElement]:
    """Returns the elements of a compiled scene that are in the world: its own bodies, and what is in none."""
    scene_bodies = bodies_of_scene(compiled.model, compiled.robot)
    mocap = {body for body in range(compiled.model.nbody) if compiled.model.body_mocapid[body] >= 0}
    return list(CompiledBodies(compiled.model, lambda body: body in scene_bodies or body in mocap).world())


def _element_findings(
    compiled: CompiledModel, expected: Sequence[MjcfElement], actual: Sequence[MjcfElement]
) -> list[Finding]:
    """Returns findings on the expected elements that are missing or differ. Of several elements with one tag
    and name, one must fit."""
    by_name: dict[tuple[str, str], list[MjcfElement]] = {}
    for element in actual:
        by_name.setdefault((element.tag, element.name), []).append(element)
    findings = []
    for element in expected:
        candidates = by_name.get((element.tag, element.name), [])
        differences = [difference(compiled, element, candidate) for candidate in candidates]
        if not candidates:
            message = "is missing, or names something else"
            findings.append(Finding(named(element.tag, element.name), "name", message))
        elif all(differences):
            findings.append(Finding(named(element.tag, element.name), *(differences[0] or ("", ""))))
    return findings


def difference(compiled: CompiledModel, expected: MjcfElement, actual: MjcfElement) -> tuple[str, str] | None:
    """Returns (attribute, message) of the first difference of two elements; None if they are the same."""
    if _references(expected) != _references(actual):
        names, expected_names = (
            ", ".join(name for *_, name in element.names) or "nothing" for element in (actual, expected)
        )
        return "name", f"names {names}, expected {expected_names}"
    for name in dict.fromkeys([*dict(expected.attributes), *dict(actual.attributes)]):
        texts = dict(expected.attributes).get(name), dict(actual.attributes).get(name)
        if (
            name not in ("name", "mesh", "hfield")
            and not compiled.sets(name)
            and not _means_the_same(name, *texts)
        ):
            return name, f"is {texts[1] or 'its default'}, expected {texts[0] or 'its default'}"
    if len(expected.children) != len(actual.children):
        return "", f"has {len(actual.children)} elements in it, expected {len(expected.children)}"
    pairs = zip(expected.children, actual.children, strict=True)
    return next((mismatch for pair in pairs if (mismatch := difference(compiled, *pair))), None)


def _means_the_same(name: str, expected: str | None, actual: str | None) -> bool:
    """Tells whether two values of an attribute mean the same, as a quaternion and its negative do."""
    if is_same_text(expected, actual):
        return True
    if name != "quat" or expected is None:
        return False
    return is_same_text(" ".join(str(-float(number)) for number in expected.split()), actual)


def _references(element: MjcfElement) -> dict[str, str]:
    """Maps the attributes of an element that are references to the names."""
    return {attribute: name for attribute, _, name in element.names}


def is_same_text(expected: str | None, actual: str | None) -> bool:
    """Tells whether two texts of an attribute have the same words and numbers."""
    if expected is None or actual is None:
        return expected == actual
    expected_words, actual_words = expected.split(), actual.split()
    try:
        numbers = [np.array([float(word) for word in words]) for words in (expected_words, actual_words)]
    except ValueError:
        return expected_words == actual_words
    if len(expected_words) != len(actual_words):
        return False
    scale = max(1.0, float(np.abs(numbers[0]).max(initial=0.0)))
    return bool(np.abs(numbers[0] - numbers[1]).max(initial=0.0) <= ENGINE_TOLERANCE * scale)


def _attribute_findings(
    compiled: CompiledModel, source_attributes: Sequence[MjcfAttributes]
) -> list[Finding]:
    findings: list[Finding] = []
    for thing in source_attributes:
        if thing.kind not in _ATTRIBUTE_READERS:
            continue
        kind, read = _ATTRIBUTE_READERS[thing.kind]
        index = index_of(compiled.model, kind, thing.name)
        if index < 0:
            continue  # Other checks report things of the robot that are missing.
        attributes = read(compiled.model, index)
        findings += _attribute_differences(
            compiled, named(thing.kind, thing.name), thing.attributes, attributes
        )
    return findings


def _attribute_differences(
    compiled: CompiledModel, element: str, expected: Attributes, actual: Attributes
) -> Iterator[Finding]:
    """Yields the expected attributes that differ."""
    texts = dict(actual)
    for name, text in expected:
        if (
            name not in _SEPARATELY_COMPARED
            and not compiled.sets(name)
            and not is_same_text(text, texts.get(name))
        ):
            yield Finding(element, name, f"is {texts.get(name, 'its default')}, expected {text}")


def _geom_findings(compiled: CompiledModel) -> Iterator[Finding]:
    """Compares the names of geoms, and their attributes that only MJCF has."""
    shapes = () if compiled.geometry is None else compiled.geometry.shapes
    for form in dict.fromkeys(shape.form for shape in shapes if shape.form.name):
        element = named("geom", form.name)
        index = index_of(compiled.model, OBJ.mjOBJ_GEOM, form.name)
        if index < 0:
            yield Finding(element, "name", "there is no geom of this name")
        else:
            attributes = elements.geom_attributes(compiled.model, int(index))
            yield from _attribute_differences(compiled, element, form.attributes, attributes)


def _body_element_findings(compiled: CompiledModel, extras: MjcfExtras) -> list[Finding]:
    """Compares the elements on the bodies, and their places."""
    model, findings = compiled.model, []
    link_from_body = {body.link: body.link_from_body for body in extras.bodies}
    at: dict[str, list[MjcfElement]] = {}
    for mount in extras.mounted:
        holder, holder_from_link = compiled.held.get(mount.link, (mount.link, np.eye(4)))
        pose = holder_from_link @ link_from_body.get(mount.link, np.eye(4)) @ mount.body_from_element
        # The body of the holder need not be at the holder's frame.
        pose = np.linalg.inv(link_from_body.get(holder, np.eye(4))) @ pose
        at.setdefault(holder, []).append(placed(mount.element, pose))
    for holder, expected in at.items():
        findings += _element_findings(
            compiled, expected, list(_elements_on_body(model, body_index(model, holder)))
        )
    return findings


def _elements_on_body(model: Any, body: int) -> Iterator[MjcfElement]:
    """Yields the cameras, lights, sites and geoms on a body."""
    for index in np.flatnonzero(model.cam_bodyid == body):
        pose = pose_of(model.cam_pos[index], model.cam_quat[index])
        yield placed(elements.camera(model, int(index)), pose)
    for index in np.flatnonzero(model.light_bodyid == body):
        yield placed(elements.light(model, int(index)), light_pose(model, int(index)))
    for index in np.flatnonzero(model.site_bodyid == body):
        pose = pose_of(model.site_pos[index], model.site_quat[index])
        yield placed(elements.site(model, int(index)), pose)
    for index in np.flatnonzero(model.geom_bodyid == body):
        geom = elements.geom(model, int(index))
        pose = pose_of(model.geom_pos[index], model.geom_quat[index])
        yield placed(replace(geom, attributes=(*geom.attributes, ("mass", "0"))), pose)
