"""Writes layers of USD, prim by prim; no other module of the export imports `pxr`.

Schemas are named, not looked up, so that schemas of PhysX and Newton, which `usd-core` does not know, are
written like any other. Numbers are rounded as in the other formats: a number far below the largest of its
vector becomes 0, and no zero has a sign.
"""

import math
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import numpy as np
import numpy.typing as npt
from pxr import Gf, Sdf, Vt

from linkwright.stages.formats.numbers import LENGTH, TURN, number, numbers
from linkwright.stages.robot.model.poses import quat_from_rotation
from linkwright.stages.robot.model.robot import Array

_VALUE_TYPES: Mapping[str, Any] = {
    "asset": Sdf.ValueTypeNames.Asset,
    "bool": Sdf.ValueTypeNames.Bool,
    "color3f": Sdf.ValueTypeNames.Color3f,
    "double[]": Sdf.ValueTypeNames.DoubleArray,
    "normal3f[]": Sdf.ValueTypeNames.Normal3fArray,
    "color3f[]": Sdf.ValueTypeNames.Color3fArray,
    "double": Sdf.ValueTypeNames.Double,
    "double3": Sdf.ValueTypeNames.Double3,
    "float": Sdf.ValueTypeNames.Float,
    "float2": Sdf.ValueTypeNames.Float2,
    "float3": Sdf.ValueTypeNames.Float3,
    "float3[]": Sdf.ValueTypeNames.Float3Array,
    "float4": Sdf.ValueTypeNames.Float4,
    "int[]": Sdf.ValueTypeNames.IntArray,
    "point3f": Sdf.ValueTypeNames.Point3f,
    "point3f[]": Sdf.ValueTypeNames.Point3fArray,
    "quatd": Sdf.ValueTypeNames.Quatd,
    "quatf": Sdf.ValueTypeNames.Quatf,
    "string": Sdf.ValueTypeNames.String,
    "texCoord2f[]": Sdf.ValueTypeNames.TexCoord2fArray,
    "token": Sdf.ValueTypeNames.Token,
    "token[]": Sdf.ValueTypeNames.TokenArray,
}
"""Name of a type in USD → the type of an attribute."""

_ARRAY_TYPES: Mapping[str, Any] = {
    "color3f[]": Vt.Vec3fArray,
    "float3[]": Vt.Vec3fArray,
    "double[]": Vt.DoubleArray,
    "int[]": Vt.IntArray,
    "normal3f[]": Vt.Vec3fArray,
    "point3f[]": Vt.Vec3fArray,
    "texCoord2f[]": Vt.Vec2fArray,
    "token[]": Vt.TokenArray,
}
"""Name of a type of arrays → the class of its values."""


class Prim:
    """A prim of a layer."""

    def __init__(self, spec: Any) -> None:
        self._spec = spec

    @property
    def path(self) -> str:
        """Returns the path of the prim in its layer."""
        return str(self._spec.path)

    def child(self, name: str, kind: str = "", *schemas: str) -> "Prim":
        """Adds a prim of the type `kind` below this prim, with these applied schemas."""
        prim = Prim(Sdf.PrimSpec(self._spec, name, Sdf.SpecifierDef, kind))
        prim.apply(*schemas)
        return prim

    def apply(self, *schemas: str) -> None:
        """Applies schemas after those that are applied already."""
        if schemas:
            earlier_schemas = (
                self._spec.GetInfo("apiSchemas").prependedItems if self._spec.HasInfo("apiSchemas") else []
            )
            schema_list = Sdf.TokenListOp()
            schema_list.prependedItems = [*earlier_schemas, *schemas]
            self._spec.SetInfo("apiSchemas", schema_list)

    def set(self, name: str, kind: str, value: Any, *, uniform: bool = False) -> None:
        """Adds an attribute of the type `kind`; None: without a value. A uniform attribute cannot change over
        time."""
        variability = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
        attribute = Sdf.AttributeSpec(self._spec, name, _VALUE_TYPES[kind], variability)
        if value is not None:
            attribute.default = _ARRAY_TYPES[kind](value) if kind in _ARRAY_TYPES else value

    def floats(self, name: str, kind: str, values: Iterable[float], least: float = 0.0) -> None:
        """Adds an attribute that is a vector, rounded as its texts in other formats. `least`: as in
        `numbers`."""
        self.set(name, kind, tuple(rounded(values, least)))

    def number(
        self, name: str, value: float, kind: str = "float", least: float = 0.0, *, uniform: bool = False
    ) -> None:
        """Adds an attribute that is a number, rounded as its text in other formats. `least`: as in
        `number`."""
        self.set(name, kind, float(number(value, least=least)), uniform=uniform)

    def doubles(self, name: str, values: Iterable[float]) -> None:
        """Adds a uniform attribute of many numbers in double precision, each rounded by itself."""
        self.set(name, "double[]", [float(number(value)) for value in values], uniform=True)

    def token(self, name: str, value: str) -> None:
        """Adds a uniform attribute that is a word."""
        self.set(name, "token", value, uniform=True)

    def point_to(self, name: str, *targets: "Prim | str") -> None:
        """Adds a relationship to prims, or to paths."""
        relationship = Sdf.RelationshipSpec(self._spec, name, custom=False)
        for target in targets:
            relationship.targetPathList.Prepend(target.path if isinstance(target, Prim) else target)

    def connect(self, name: str, kind: str, source: str) -> None:
        """Adds an attribute that gets its value from another attribute, at the path `source`."""
        attribute = Sdf.AttributeSpec(self._spec, name, _VALUE_TYPES[kind])
        attribute.connectionPathList.Prepend(source)

    def refer(self, path: str, layer: str = "", *, instance: bool = False) -> None:
        """Makes this prim a reference to the prim at `path` in a layer beside this one ("": in this layer).
        Instances of the same prim share its content."""
        self._spec.referenceList.Prepend(Sdf.Reference(layer, path))
        if instance:
            self._spec.instanceable = True

    def hide(self) -> None:
        """Makes the prim invisible, for every purpose of rendering."""
        self.set("visibility", "token", "invisible")

    def set_display_name(self, name: str) -> None:
        """Sets the name that people see."""
        self._spec.SetInfo("displayName", name)

    def place(self, pose: Array, scale: Sequence[float] | None = None) -> None:
        """Sets the prim's pose (4, 4) in its parent, in double precision, and its scale along its axes."""
        operations = ["xformOp:translate", "xformOp:orient"]
        self.floats("xformOp:translate", "double3", pose[:3, 3], LENGTH)
        w, *xyz = rounded(quat_from_rotation(pose[:3, :3]), TURN)
        if w > 0.5:
            # USD takes the angle from w alone, as an arc cosine: twelve digits would lose small turns.
            w = math.sqrt(1.0 - sum(part * part for part in xyz))
        self.set("xformOp:orient", "quatd", Gf.Quatd(w, Gf.Vec3d(*xyz)))
        if scale is not None:
            self.floats("xformOp:scale", "double3", scale)
            operations.append("xformOp:scale")
        self.set("xformOpOrder", "token[]", operations, uniform=True)

    def rotation(self, name: str, matrix: Array) -> None:
        """Adds an attribute that is a rotation (3, 3), as a quaternion in single precision."""
        w, *xyz = rounded(quat_from_rotation(matrix), TURN)
        self.set(name, "quatf", Gf.Quatf(w, Gf.Vec3f(*xyz)))

    def interpolate(self, name: str, mode: str) -> None:
        """Sets what a primvar has values for: each corner of each face (`faceVarying`), or each face
        (`uniform`)."""
        self._spec.attributes[name].SetInfo("interpolation", mode)

    def array(self, name: str, kind: str, values: npt.NDArray[Any]) -> None:
        """Adds an attribute of many numbers, without rounding."""
        self.set(name, kind, None)
        attribute = self._spec.attributes[name]
        attribute.default = _ARRAY_TYPES[kind].FromNumpy(np.ascontiguousarray(values))


class Layer:
    """A layer with a first prim of the type `kind`, which is its default prim. Units are metres and
    kilograms, with z up."""

    def __init__(self, name: str, kind: str) -> None:
        self._layer = Sdf.Layer.CreateAnonymous(".usda")
        top = self._layer.pseudoRoot
        for key, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
            top.SetInfo(key, value)
        self._layer.defaultPrim = name
        self.root = Prim(Sdf.PrimSpec(self._layer, name, Sdf.SpecifierDef, kind))
        self.root._spec.SetInfo("kind", "component")

    def describe(self, key: str, table: Mapping[str, str | int | float | tuple[float, ...]]) -> None:
        """Adds a table to the layer's custom data, under `key`. A tuple of three numbers becomes a
        float3."""
        values = {
            name: Gf.Vec3f(*value) if isinstance(value, tuple) else value for name, value in table.items()
        }
        self._layer.customLayerData = {**self._layer.customLayerData, key: values}

    def bytes(self, encoding: Literal["binary", "text"] = "text") -> bytes:
        """Returns the content of the layer's file. Raises OSError if usd-core cannot write it."""
        if encoding == "text":
            return str(self._layer.ExportToString()).encode()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "layer.usdc"
            if not self._layer.Export(str(path)):
                msg = "usd-core could not write a layer"
                raise OSError(msg)
            return path.read_bytes()


def rounded(values: Iterable[float], least: float = 0.0) -> list[float]:
    """Returns the values of a vector, rounded as their texts in other formats."""
    return [float(text) for text in numbers(values, least=least)]
