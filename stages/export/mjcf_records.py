"""What robot.json says of what only an MJCF has, where the source was one."""

from typing import Any

import numpy as np

from stages.export.json_values import as_floats, as_pose
from stages.robot.mjcf_extras import MjcfBodyFrame, MjcfElement, MjcfExtras, MjcfKeyframe
from stages.robot.scene import Setting


def mjcf_records(extras: MjcfExtras | None) -> dict[str, Any]:
    """The table `mjcf`; nothing for a robot of another source."""
    if extras is None:
        return {}
    return {
        "mjcf": {
            "bodies": [_body(body) for body in extras.bodies],
            "attributes": [
                {"kind": one.kind, "name": one.name, "attributes": dict(one.attributes)}
                for one in extras.attributes
            ],
            "mounted": [
                {"link": one.link, "pose": as_pose(one.body_from_element), "element": _element(one.element)}
                for one in extras.mounted
            ],
            "sections": [_element(section) for section in extras.sections],
            "order": {section: list(names) for section, names in extras.order},
            "scene": [_element(section) for section in extras.scene],
            "scene_qpos": list(extras.scene_qpos),
            "keyframes": [_keyframe(keyframe) for keyframe in extras.keyframes],
            "has_ground": extras.has_ground,
            "option": {name: _setting(value) for name, value in extras.option},
            "flag": dict(extras.flag),
        }
    }


def _body(body: MjcfBodyFrame) -> dict[str, Any]:
    axes = body.body_from_inertial
    # The writer asks whether the axes are principal to 1e-9, so each keeps its digits.
    rotation = None if axes is None else np.asarray(axes, dtype=float).tolist()
    return {"link": body.link, "pose": as_pose(body.link_from_body), "inertial_axes": rotation}


def _element(element: MjcfElement) -> dict[str, Any]:
    return {
        "tag": element.tag,
        "attributes": dict(element.attributes),
        "names": {attribute: [kind, name] for attribute, kind, name in element.names},
        "children": [_element(child) for child in element.children],
    }


def _keyframe(keyframe: MjcfKeyframe) -> dict[str, Any]:
    return {
        "name": keyframe.name,
        "root": list(keyframe.world_from_root),
        "scene": list(keyframe.scene),
    }


def _setting(value: Setting) -> Any:
    return as_floats(value) if isinstance(value, tuple) else value
