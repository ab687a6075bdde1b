"""The physics engine's copy of the model: one flat MJCF without what is only seen.

Texts of numbers are taken over as they are, so that the copy moves as the scene does.
"""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.xml import Element, element, tag, to_bytes
from linkwright.stages.mujoco.compile import NotCompiled, compiled_text
from linkwright.stages.mujoco.names import index_of
from linkwright.stages.show.live import includes
from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.engine.assets import with_assets
from linkwright.stages.show.live.engine.version import without_newer

_SEEN = ("visual", "sensor", "custom")
"""Sections that move nothing."""
_SEEN_ASSETS = ("texture", "material", "skin")
_SEEN_ANYWHERE = ("camera", "light")
_OF_FILES = ("meshdir", "assetdir", "texturedir", "strippath", "discardvisual")
_BEYOND = ("plugin", "extension", "attach", "model", "composite")
"""What the copy cannot have: it reads other files, or needs code that the page does not have."""


class NoCopy(Exception):
    """The model has no copy for the page's engine; the text says why."""


@dataclass(frozen=True, slots=True)
class EngineCopy:
    """The `text` of the copy, its `files` by name, and what it `lacks` of the scene: what, where, and what
    the page has instead."""

    text: str
    files: Mapping[str, bytes]
    lacks: Sequence[Mapping[str, str]]


def engine_copy(live: LiveModel, folder: Path) -> EngineCopy:
    """The engine's copy of a model whose files are in a folder. NoCopy where it cannot be made."""
    if live.document is None:
        raise NoCopy("only a robot with an MJCF simulates in the page (export=mjcf)")
    root = deepcopy(live.document)
    beyond = sorted({tag(node) for node in root.iter() if _is_beyond(node)})
    if beyond:
        raise NoCopy(f"the page's engine cannot have <{'>, <'.join(beyond)}>")
    _without_what_is_seen(root)
    _without_visual_geoms(root, live.model)
    _with_inertials(root, live.model)
    _with_ranges(root, live.model)
    files, lacks = with_assets(root, live.model, folder)
    for compiler in root.iterchildren("compiler"):
        for name in _OF_FILES:
            compiler.attrib.pop(name, None)
        if compiler.get("inertiafromgeom") == "true":
            del compiler.attrib["inertiafromgeom"]
    lacks += without_newer(root)
    for node in root.iter():
        if (node.get("name") or "").startswith(includes.OWN):
            del node.attrib["name"]
    text = to_bytes(root).decode()
    _require_same(live.model, text, files)
    return EngineCopy(text, files, lacks)


def _is_beyond(node: Element) -> bool:
    return tag(node) in _BEYOND or (tag(node) == "flexcomp" and node.get("file") is not None)


def _without_what_is_seen(root: Element) -> None:
    for section in list(root):
        if tag(section) in _SEEN:
            root.remove(section)
    for node in list(root.iter(*_SEEN_ASSETS, *_SEEN_ANYWHERE)):
        node.getparent().remove(node)
    for node in root.iter():
        node.attrib.pop("material", None)


def _without_visual_geoms(root: Element, model: Any) -> None:
    """Removes the geoms that collide with nothing and that nothing names."""
    named = {value for node in root.iter() for key, value in node.attrib.items() if key not in _OWN_NAMES}
    for geom in list(root.iter("geom")):
        name = geom.get("name")
        index = -1 if name is None else index_of(model, mujoco.mjtObj.mjOBJ_GEOM, name)
        if index < 0 or name in named or geom.get("fluidshape") is not None:
            continue
        if not model.geom_contype[index] and not model.geom_conaffinity[index]:
            geom.getparent().remove(geom)


_OWN_NAMES = frozenset({"name", "class", "childclass", "mesh", "material", "file"})


def _with_inertials(root: Element, model: Any) -> None:
    """Gives each body the inertia that MuJoCo takes from its geoms, which are not all there any more."""
    from_geoms = any(one.get("inertiafromgeom") == "true" for one in root.iterchildren("compiler"))
    for body in list(root.iter("body")):
        given = body.find("inertial")
        if given is not None and not from_geoms:
            continue
        index = index_of(model, mujoco.mjtObj.mjOBJ_BODY, body.get("name", ""))
        if index < 0:
            continue  # MuJoCo makes copies of it, with all that is in it.
        if given is not None:
            body.remove(given)
        if model.body_mass[index]:
            inertial = element(
                None,
                "inertial",
                pos=_text(model.body_ipos[index]),
                quat=_text(model.body_iquat[index]),
                mass=_text(model.body_mass[index]),
                diaginertia=_text(model.body_inertia[index]),
            )
            body.insert(0, inertial)


def _with_ranges(root: Element, model: Any) -> None:
    """Writes the range of each general actuator, which may be that of its joint by a newer attribute."""
    general = [node for node in root.iter("general") if node.get("inheritrange") is not None]
    for node in general:
        del node.attrib["inheritrange"]
    actuators = [one for section in root.iterchildren("actuator") for one in section]
    for index, node in enumerate(actuators if general else ()):
        place = int(model.actuator_ctrladr[index])
        if tag(node) == "general" and model.actuator_ctrllimited[place]:
            node.set("ctrlrange", _text(model.actuator_ctrlrange[place]))
            node.set("ctrllimited", "true")


def _text(values: Any) -> str:
    return " ".join(repr(float(one)) for one in np.atleast_1d(values))


def _require_same(model: Any, text: str, files: dict[str, bytes]) -> None:
    """NoCopy where the copy is not the same mechanism."""
    try:
        copy = compiled_text(text.encode(), files)
    except NotCompiled as error:
        raise NoCopy(f"MuJoCo does not compile the page's copy of the model: {error}") from error
    counts = ("nq", "nv", "nu", "na", "nbody", "njnt", "neq", "nkey", "nsite")
    differ = [name for name in counts if getattr(model, name) != getattr(copy, name)]
    if differ or not np.allclose(model.body_mass, copy.body_mass, rtol=1e-9, atol=0):
        raise NoCopy(f"the page's copy of the model differs in {', '.join(differ) or 'mass'}")
