"""Reports by name every element or attribute of an MJCF that our robot model cannot represent."""

from collections.abc import Collection, Iterable, Iterator
from typing import Any

import mujoco

from linkwright.stages.fetch.mjcf.compiled.geoms import GEOMS, can_collide, is_extra, is_visual_only
from linkwright.stages.fetch.mjcf.compiled.keyframes import keyframe_omissions
from linkwright.stages.fetch.mjcf.compiled.textures import Textures
from linkwright.stages.fetch.mjcf.compiled.unsupported_fields import (
    Omission,
    element_omissions,
    file_omissions,
    viewer_omissions,
)
from linkwright.stages.mujoco.bodies import CONVERTED_GEOM_TYPES
from linkwright.stages.mujoco.names import name_of, names_of
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import name_list
from linkwright.stages.robot.text.plural import count

_MAX_NAMES = 5
"""Largest number of names of each kind that are reported."""


def omission_reports(
    model: Any,
    spec: Any,
    robot_bodies: Collection[int],
    textures: Textures,
    where: str,
    lost_elements: Collection[tuple[str, int]],
    driven: Collection[int] = (),
) -> Iterator[Diagnostic]:
    """Reports W-MJCF-LEFT for omissions that affect motion or contact, and I-MJCF-LEFT for the rest.

    `spec`: the spec from which `model` was compiled. `robot_bodies`: the bodies that become links.
    `textures`: the textures that are carried over; `lost_elements`: (tag, number) of the elements that are
    not; `driven`: the actuators that the robot has itself.
    """
    omissions = [
        *_geoms(model, robot_bodies),
        *element_omissions(model, textures.materials),
        *_elements(model, lost_elements, textures.carried_numbers),
        *keyframe_omissions(model, driven),
        *viewer_omissions(model),
        *file_omissions(spec),
    ]
    affects_motion = [_text(omission) for omission in omissions if omission.affects_motion]
    if affects_motion:
        text = f"not carried over, so the robot may move differently: {'; '.join(affects_motion)}"
        yield Diagnostic("W-MJCF-LEFT", text, where, "check whether the robot needs it")
    harmless = [_text(omission) for omission in omissions if not omission.affects_motion]
    if harmless:
        text = f"not carried over (not part of the mechanism): {'; '.join(harmless)}"
        yield Diagnostic("I-MJCF-LEFT", text, where)


def scene_reports(model: Any, robot_bodies: Collection[int], where: str) -> Iterator[Diagnostic]:
    """Reports I-MJCF-SCENE for the bodies that are not part of the robot, and the geoms fixed to the
    world."""
    bodies = [
        body for body in range(1, model.nbody) if not model.body_parentid[body] and body not in robot_bodies
    ]
    world_geom_count = int((model.geom_bodyid == 0).sum())
    words = (
        [f"{count(len(bodies), 'body', 'bodies')} ({name_list(model.body(body).name for body in bodies)})"]
        if bodies
        else []
    )
    words += [count(world_geom_count, "geom of the world", "geoms of the world")] if world_geom_count else []
    if words:
        text = f"not part of the robot, so in the scene: {', '.join(words)}"
        hint = "scene.surroundings=drop leaves them out; the robot is the mechanism that has actuators"
        yield Diagnostic("I-MJCF-SCENE", text, where, hint)


def _text(omission: Omission) -> str:
    """Describes an omission: the attribute, how many elements set it, and the names of the first elements."""
    if not omission.names:
        return omission.words
    names = [name for name in omission.names if name][:_MAX_NAMES]
    ellipsis = ", ..." if names and len(names) < len(omission.names) else ""
    return f"{len(omission.names)} × {omission.words}" + (f" ({', '.join(names)}{ellipsis})" if names else "")


def _omission_of(words: str, affects_motion: bool, names: Iterable[str]) -> Iterator[Omission]:
    """Yields an omission of the elements with these names, if there are any."""
    all_names = tuple(names)
    if all_names:
        yield Omission(words, affects_motion, all_names)


def _geoms(model: Any, robot_bodies: Collection[int]) -> Iterator[Omission]:
    """Yields geoms that are left out, and the names of meshes that are only visible, which are joined."""
    all_geoms = range(model.ngeom)
    robot_geoms = [
        geom for geom in all_geoms if model.geom_bodyid[geom] and int(model.geom_bodyid[geom]) in robot_bodies
    ]
    scene_geoms = [geom for geom in all_geoms if geom not in robot_geoms]

    def names_of_geoms(geoms: Iterable[int]) -> Iterator[str]:
        return (model.geom(geom).name for geom in geoms)

    def kind(geom: int) -> int:
        return int(model.geom_type[geom])

    unknown_geoms = [geom for geom in robot_geoms if kind(geom) not in GEOMS and not is_extra(model, geom)]
    unknown_geoms += [geom for geom in scene_geoms if kind(geom) not in CONVERTED_GEOM_TYPES]
    yield from _omission_of("geom type (field, sdf, ...)", True, names_of_geoms(unknown_geoms))
    meshes = [
        geom
        for geom in robot_geoms
        if kind(geom) == mujoco.mjtGeom.mjGEOM_MESH and not can_collide(model, geom)
    ]
    useless_meshes = [geom for geom in meshes if not is_visual_only(model, geom)]
    yield from _omission_of(
        "mesh that is neither visible nor collides", False, names_of_geoms(useless_meshes)
    )
    yield from _omission_of(
        "name of a mesh that is only visible", False, (name for name in names_of_geoms(meshes) if name)
    )


_KINDS = {
    "pair": ("mjOBJ_PAIR", True),
    "exclude": ("mjOBJ_EXCLUDE", True),
    "tendon": ("mjOBJ_TENDON", True),
    "equality": ("mjOBJ_EQUALITY", True),
    "actuator": ("mjOBJ_ACTUATOR", True),
    "sensor": ("mjOBJ_SENSOR", False),
}
"""Elements that may be lost: tag → MuJoCo's name, and whether a loss changes motions."""

_NEVER_CARRIED_OVER = {
    "flex": ("mjOBJ_FLEX", "nflex", True),
    "skin": ("mjOBJ_SKIN", "nskin", False),
    "custom numeric": ("mjOBJ_NUMERIC", "nnumeric", False),
    "custom text": ("mjOBJ_TEXT", "ntext", False),
    "custom tuple": ("mjOBJ_TUPLE", "ntuple", False),
    "plugin": ("mjOBJ_PLUGIN", "nplugin", True),
}
"""Elements that are always left out: tag → MuJoCo's name, the field with their number, and whether the loss
changes motions."""


def _elements(
    model: Any, lost_elements: Collection[tuple[str, int]], textures: Collection[int]
) -> Iterator[Omission]:
    """Yields the elements of each kind that are not carried over."""
    for tag, (kind, affects_motion) in _KINDS.items():
        numbers = sorted(number for word, number in lost_elements if word == tag)
        names = (name_of(model, getattr(mujoco.mjtObj, kind), number) for number in numbers)
        yield from _omission_of(tag, affects_motion, names)
    for words, (kind, field, affects_motion) in _NEVER_CARRIED_OVER.items():
        yield from _omission_of(
            words, affects_motion, names_of(model, getattr(mujoco.mjtObj, kind), getattr(model, field))
        )
    images = enumerate(names_of(model, mujoco.mjtObj.mjOBJ_TEXTURE, model.ntex))
    yield from _omission_of("texture", False, (name for number, name in images if number not in textures))
    policies = getattr(model, "tree_sleep_policy", ())  # of MuJoCo 3.4 and later
    trees = (tree for tree, policy in enumerate(policies) if "AUTO" not in mujoco.mjtSleepPolicy(policy).name)
    yield from _omission_of(
        "body sleep", False, (model.body(int(model.tree_bodyadr[tree])).name for tree in trees)
    )
