"""Reads the materials of a USD: what a shape looks like, and how slippery it is."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pxr import Gf, UsdGeom, UsdShade

from linkwright.stages.validate.usd.prim_reader import schemas

FRICTION = {
    "PhysicsMaterialAPI": ("physics:staticFriction", "physics:dynamicFriction"),
    "NewtonMaterialAPI": ("newton:torsionalFriction", "newton:rollingFriction"),
}
"""The schemas of a material that say how slippery it is, and their attributes."""


@dataclass(frozen=True, slots=True)
class ReadUsdLook:
    """The colour of a shape's material, linear, with its opacity and its roughness, () where there is no
    material whose surface is known; and the path of its image as the file has it, "" for none. `display`: the
    colour without materials, () for none. `friction`: of its material of physics, by attribute."""

    colour: tuple[float, ...] = ()
    image: str = ""
    display: tuple[float, ...] = ()
    friction: Mapping[str, float] = field(default_factory=dict)


def look_of(prim: Any) -> ReadUsdLook:
    """Of a shape; what is above it counts, as materials and colours are inherited."""
    display = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor").Get() or ()
    colour, image = _surface(_bound(prim, UsdShade.Tokens.allPurpose))
    first = tuple(map(float, display[0])) if display else ()
    return ReadUsdLook(colour, image, first, _friction(_bound(prim, "physics")))


def _bound(prim: Any, purpose: str) -> Any:
    """The material, None where there is none: a binding without its schema is not looked at."""
    material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)
    if not material or "MaterialBindingAPI" not in schemas(binding.GetPrim()):
        return None
    # Without one for physics, that for everything is found.
    if purpose == "physics" and not binding.GetName().endswith(":physics"):
        return None
    return material


def _surface(material: Any) -> tuple[tuple[float, ...], str]:
    if material is None:
        return (), ""
    shader, *_ = material.ComputeSurfaceSource()
    if not shader or shader.GetIdAttr().Get() != "UsdPreviewSurface":
        return (), ""
    rest = float(_input(shader, "opacity", 1.0)), float(_input(shader, "roughness", 0.5))
    colour = shader.GetInput("diffuseColor")
    sources = colour.GetConnectedSources()[0] if colour else []
    if not sources:
        return (*map(float, _input(shader, "diffuseColor", Gf.Vec3f(0.18))), *rest), ""
    image = UsdShade.Shader(sources[0].source.GetPrim())
    if image.GetIdAttr().Get() != "UsdUVTexture":
        return (), ""
    scale = _input(image, "scale", Gf.Vec4f(1.0))
    file = _input(image, "file", None)
    return (*map(float, tuple(scale)[:3]), *rest), "" if file is None else str(file.path)


def _input(shader: Any, name: str, default: Any) -> Any:
    given = shader.GetInput(name)
    value = given.Get() if given else None
    return default if value is None else value


def _friction(material: Any) -> dict[str, float]:
    if material is None:
        return {}
    prim = material.GetPrim()
    found = {}
    for schema, names in FRICTION.items():
        for name in names:
            value = prim.GetAttribute(name).Get() if schema in schemas(prim) else None
            if value is not None:
                found[name] = float(value)
    return found
