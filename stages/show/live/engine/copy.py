"""Makes the physics engine's copy of the model: a single MJCF without purely visual elements.

Numbers keep their text, so that the copy moves exactly as the scene does.
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
from linkwright.stages.mujoco.names import controls_of, index_of
from linkwright.stages.show.live import includes
from linkwright.stages.show.live.compiled import LiveModel
from linkwright.stages.show.live.engine.assets import with_assets
from linkwright.stages.show.live.engine.version import remove_newer

_VISUAL_SECTIONS = ("visual", "sensor", "custom")
"""Sections without effect on motion."""
_VISUAL_ASSETS = ("texture", "material", "skin")
_VISUAL_ELEMENTS = ("camera", "light")
_FILE_ATTRIBUTES = ("meshdir", "assetdir", "texturedir", "strippath", "discardvisual")
_UNSUPPORTED = ("plugin", "extension", "attach", "model", "composite")
"""Elements that the copy cannot contain: they read other files, or need code that the page does not have."""


class NoCopy(Exception):
    """An error for a model of which the page's engine cannot have a copy; its text is the reason."""


@dataclass(frozen=True, slots=True)
class EngineCopy:
    """The `text` of the copy, its `files` by name, and the features of the scene that it `lacks`, each with
    its place and the page's replacement."""

    text: str
    files: Mapping[str, bytes]
    lacks: Sequence[Mapping[str, str]]


def engine_copy(live: LiveModel, folder: Path) -> EngineCopy:
    """Makes the engine's copy of a model whose files are in a folder. Raises NoCopy if that is impossible."""
    if live.document is None:
        raise NoCopy("only a robot with an MJCF simulates in the page (export=mjcf)")
    root = deepcopy(live.document)
    unsupported = sorted({tag(node) for node in root.iter() if _is_unsupported(node)})
    if unsupported:
        raise NoCopy(f"the page's engine cannot have <{'>, <'.join(unsupported)}>")
    _remove_visual_elements(root)
    _remove_visual_geoms(root, live.model)
    _set_inertials(root, live.model)
    _set_ranges(root, live.model)
    files, lacks = with_assets(root, live.model, folder)
    for compiler in root.iterchildren("compiler"):
        for name in _FILE_ATTRIBUTES:
            compiler.attrib.pop(name, None)
        if compiler.get("inertiafromgeom") == "true":
            del compiler.attrib["inertiafromgeom"]
    lacks += remove_newer(root)
    for node in root.iter():
        if (node.get("name") or "").startswith(includes.NAME_PREFIX):
            del node.attrib["name"]
    text = to_bytes(root).decode()
    _require_same(live.model, text, files)
    return EngineCopy(text, files, lacks)


def _is_unsupported(node: Element) -> bool:
    return tag(node) in _UNSUPPORTED or (tag(node) == "flexcomp" and node.get("file") is not None)


def _remove_visual_elements(root: Element) -> None:
    for section in list(root):
        if tag(section) in _VISUAL_SECTIONS:
            root.remove(section)
    for node in list(root.iter(*_VISUAL_ASSETS, *_VISUAL_ELEMENTS)):
        node.getparent().remove(node)
    for node in root.iter():
        node.attrib.pop("material", None)


def _remove_visual_geoms(root: Element, model: Any) -> None:
    """Removes geoms that collide with nothing and that no element names."""
    referenced_names = {
        value for node in root.iter() for key, value in node.attrib.items() if key not in _NO_REFERENCES
    }
    for geom in list(root.iter("geom")):
        name = geom.get("name")
        index = -1 if name is None else index_of(model, mujoco.mjtObj.mjOBJ_GEOM, name)
        if index < 0 or name in referenced_names or geom.get("fluidshape") is not None:
            continue
        if not model.geom_contype[index] and not model.geom_conaffinity[index]:
            geom.getparent().remove(geom)


_NO_REFERENCES = frozenset({"name", "class", "childclass", "mesh", "material", "file"})


def _set_inertials(root: Element, model: Any) -> None:
    """Gives each body the inertia that MuJoCo computes from its geoms, since some geoms are removed."""
    compilers = root.iterchildren("compiler")
    replaces_inertials = any(compiler.get("inertiafromgeom") == "true" for compiler in compilers)
    for body in list(root.iter("body")):
        inertial_of_file = body.find("inertial")
        if inertial_of_file is not None and not replaces_inertials:
            continue
        index = index_of(model, mujoco.mjtObj.mjOBJ_BODY, body.get("name", ""))
        if index < 0:
            continue  # MuJoCo makes the body, with its content, from a copy of another element.
        if inertial_of_file is not None:
            body.remove(inertial_of_file)
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


def _set_ranges(root: Element, model: Any) -> None:
    """Writes the range of general actuators that inherit it from their joint by an attribute of newer
    versions."""
    general_actuators = [node for node in root.iter("general") if node.get("inheritrange") is not None]
    for node in general_actuators:
        del node.attrib["inheritrange"]
    actuators = [actuator for section in root.iterchildren("actuator") for actuator in section]
    for index, node in enumerate(actuators if general_actuators else ()):
        control = controls_of(model, index).start
        if tag(node) == "general" and model.actuator_ctrllimited[control]:
            node.set("ctrlrange", _text(model.actuator_ctrlrange[control]))
            node.set("ctrllimited", "true")


def _text(values: Any) -> str:
    return " ".join(repr(float(number)) for number in np.atleast_1d(values))


def _require_same(model: Any, text: str, files: dict[str, bytes]) -> None:
    """Raises NoCopy if the copy differs from the model in its counts or its masses."""
    try:
        copy = compiled_text(text.encode(), files)
    except NotCompiled as error:
        raise NoCopy(f"MuJoCo does not compile the page's copy of the model: {error}") from error
    counts = ("nq", "nv", "nu", "na", "nbody", "njnt", "neq", "nkey", "nsite")
    differences = [name for name in counts if getattr(model, name) != getattr(copy, name)]
    if differences or not np.allclose(model.body_mass, copy.body_mass, rtol=1e-9, atol=0):
        raise NoCopy(f"the page's copy of the model differs in {', '.join(differences) or 'mass'}")
