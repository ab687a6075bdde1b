"""Reads the materials of a USD, which give a shape its look and its friction."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from pxr import Gf, UsdGeom, UsdShade

from linkwright.stages.validate.usd.prim_reader import schemas

FRICTION = {
    "PhysicsMaterialAPI": ("physics:staticFriction", "physics:dynamicFriction"),
    "NewtonMaterialAPI": ("newton:torsionalFriction", "newton:rollingFriction"),
}
"""The schemas of a material that give its friction, and their attributes."""


@dataclass(frozen=True, slots=True)
class ReadUsdLook:
    """The look and the friction of a shape."""

    colour: tuple[float, ...] = ()
    """The linear colour, the opacity and the roughness of the material; () if its surface is not known."""

    image: str = ""
    """The path of the image in the file; "" without an image."""

    display_colour: tuple[float, ...] = ()
    """The colour of renderers without materials; () if missing."""

    friction: Mapping[str, float] = field(default_factory=dict)
    """The friction of the physics material, by attribute."""


def look_of(prim: Any) -> ReadUsdLook:
    """Returns the look of a shape, with the materials and colours that it inherits from prims above it."""
    display_colours = UsdGeom.PrimvarsAPI(prim).FindPrimvarWithInheritance("displayColor").Get() or ()
    display_colour = tuple(map(float, display_colours[0])) if display_colours else ()
    colour, image = _surface(_bound_material(prim, UsdShade.Tokens.allPurpose))
    return ReadUsdLook(colour, image, display_colour, _friction(_bound_material(prim, "physics")))


def _bound_material(prim: Any, purpose: str) -> Any:
    """Returns the material that is bound for a purpose, or None. A binding without its schema is ignored."""
    material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)
    if not material or "MaterialBindingAPI" not in schemas(binding.GetPrim()):
        return None
    # Without a physics material, USD returns the all-purpose material.
    if purpose == "physics" and not binding.GetName().endswith(":physics"):
        return None
    return material


def _surface(material: Any) -> tuple[tuple[float, ...], str]:
    """Returns `colour` and `image` of a `ReadUsdLook`. With an image, the colour is the image's factor."""
    if material is None:
        return (), ""
    shader, *_ = material.ComputeSurfaceSource()
    if not shader or shader.GetIdAttr().Get() != "UsdPreviewSurface":
        return (), ""
    opacity_and_roughness = (
        float(_input_value(shader, "opacity", 1.0)),
        float(_input_value(shader, "roughness", 0.5)),
    )
    colour = shader.GetInput("diffuseColor")
    sources = colour.GetConnectedSources()[0] if colour else []
    if not sources:
        return (*map(float, _input_value(shader, "diffuseColor", Gf.Vec3f(0.18))), *opacity_and_roughness), ""
    image = UsdShade.Shader(sources[0].source.GetPrim())
    if image.GetIdAttr().Get() != "UsdUVTexture":
        return (), ""
    scale = _input_value(image, "scale", Gf.Vec4f(1.0))
    file = _input_value(image, "file", None)
    return (*map(float, tuple(scale)[:3]), *opacity_and_roughness), "" if file is None else str(file.path)


def _input_value(shader: Any, name: str, default: Any) -> Any:
    """Returns the value of a shader's input; `default` without a value."""
    attribute = shader.GetInput(name)
    value = attribute.Get() if attribute else None
    return default if value is None else value


def _friction(material: Any) -> dict[str, float]:
    """Returns the friction of a material, by attribute, as far as its schemas have it."""
    if material is None:
        return {}
    prim = material.GetPrim()
    values = {}
    for schema, names in FRICTION.items():
        for name in names:
            value = prim.GetAttribute(name).Get() if schema in schemas(prim) else None
            if value is not None:
                values[name] = float(value)
    return values
