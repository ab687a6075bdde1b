"""Layers of USD, written prim by prim: the only module that imports `pxr`.

Schemas are named, not looked up, so that those of PhysX and Newton, which `usd-core` does not know, are
written as any other. Numbers are as in the other formats: noise beside what is larger is 0, and no zero has a
sign.
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

_TYPES: Mapping[str, Any] = {
    "asset": Sdf.ValueTypeNames.Asset,
    "bool": Sdf.ValueTypeNames.Bool,
    "color3f": Sdf.ValueTypeNames.Color3f,
    "color3f[]": Sdf.ValueTypeNames.Color3fArray,
    "double": Sdf.ValueTypeNames.Double,
    "double3": Sdf.ValueTypeNames.Double3,
    "float": Sdf.ValueTypeNames.Float,
    "float2": Sdf.ValueTypeNames.Float2,
    "float3": Sdf.ValueTypeNames.Float3,
    "float3[]": Sdf.ValueTypeNames.Float3Array,
    "float4": Sdf.ValueTypeNames.Float4,
    "int": Sdf.ValueTypeNames.Int,
    "int[]": Sdf.ValueTypeNames.IntArray,
    "point3f": Sdf.ValueTypeNames.Point3f,
    "point3f[]": Sdf.ValueTypeNames.Point3fArray,
    "quatd": Sdf.ValueTypeNames.Quatd,
    "quatf": Sdf.ValueTypeNames.Quatf,
    "string": Sdf.ValueTypeNames.String,
    "texCoord2f[]": Sdf.ValueTypeNames.TexCoord2fArray,
    "token": Sdf.ValueTypeNames.Token,
    "token[]": Sdf.ValueTypeNames.TokenArray,
    "vector3f": Sdf.ValueTypeNames.Vector3f,
}

_ARRAYS: Mapping[str, Any] = {
    "color3f[]": Vt.Vec3fArray,
    "float3[]": Vt.Vec3fArray,
    "int[]": Vt.IntArray,
    "point3f[]": Vt.Vec3fArray,
    "texCoord2f[]": Vt.Vec2fArray,
    "token[]": Vt.TokenArray,
}


class Prim:
    """A prim of a layer."""

    def __init__(self, spec: Any) -> None:
        self._spec = spec

    @property
    def path(self) -> str:
        return str(self._spec.path)

    def child(self, name: str, kind: str = "", *schemas: str) -> "Prim":
        """A new prim below this one, of the type `kind`, with these applied schemas."""
        made = Prim(Sdf.PrimSpec(self._spec, name, Sdf.SpecifierDef, kind))
        made.apply(*schemas)
        return made

    def apply(self, *schemas: str) -> None:
        """Applies schemas behind those that are."""
        if schemas:
            before = (
                self._spec.GetInfo("apiSchemas").prependedItems if self._spec.HasInfo("apiSchemas") else []
            )
            listed = Sdf.TokenListOp()
            listed.prependedItems = [*before, *schemas]
            self._spec.SetInfo("apiSchemas", listed)

    def set(self, name: str, kind: str, value: Any, *, uniform: bool = False) -> None:
        """A new attribute of a type of USD."""
        vary = Sdf.VariabilityUniform if uniform else Sdf.VariabilityVarying
        made = Sdf.AttributeSpec(self._spec, name, _TYPES[kind], vary)
        if value is not None:
            made.default = _ARRAYS[kind](value) if kind in _ARRAYS else value

    def floats(self, name: str, kind: str, values: Iterable[float], least: float = 0.0) -> None:
        """A new attribute of several numbers, with the values that their texts in other formats have."""
        self.set(name, kind, tuple(rounded(values, least)))

    def number(self, name: str, value: float, kind: str = "float", least: float = 0.0) -> None:
        """A new attribute that is a number."""
        self.set(name, kind, float(number(value, least=least)))

    def token(self, name: str, value: str) -> None:
        """A new uniform attribute that is a word."""
        self.set(name, "token", value, uniform=True)

    def point_to(self, name: str, *targets: "Prim | str") -> None:
        """A new relationship."""
        made = Sdf.RelationshipSpec(self._spec, name, custom=False)
        for one in targets:
            made.targetPathList.Prepend(one.path if isinstance(one, Prim) else one)

    def connect(self, name: str, kind: str, source: str) -> None:
        """A new attribute that has its value from another."""
        made = Sdf.AttributeSpec(self._spec, name, _TYPES[kind])
        made.connectionPathList.Prepend(source)

    def refer(self, path: str, layer: str = "", *, instance: bool = False) -> None:
        """Makes this prim what `path` is in a layer beside this one, maybe as an instance."""
        self._spec.referenceList.Prepend(Sdf.Reference(layer, path))
        if instance:
            self._spec.instanceable = True

    def call(self, name: str) -> None:
        """The name that people see."""
        self._spec.SetInfo("displayName", name)

    def place(self, pose: Array, scale: Sequence[float] | None = None) -> None:
        """Where it is in its parent (4, 4), in double precision, and how it is scaled along its axes."""
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

    def turned(self, name: str, rotation: Array) -> None:
        """A new attribute that is a rotation (3, 3), as a quaternion in single precision."""
        w, *xyz = rounded(quat_from_rotation(rotation), TURN)
        self.set(name, "quatf", Gf.Quatf(w, Gf.Vec3f(*xyz)))

    def interpolate(self, name: str, how: str) -> None:
        """What the values of a primvar are for: such as each corner of each face (`faceVarying`)."""
        self._spec.attributes[name].SetInfo("interpolation", how)

    def array(self, name: str, kind: str, values: npt.NDArray[Any]) -> None:
        """A new attribute of many numbers, as they are."""
        self.set(name, kind, None)
        made = self._spec.attributes[name]
        made.default = _ARRAYS[kind].FromNumpy(np.ascontiguousarray(values))


class Layer:
    """A layer whose first prim, of the type `kind`, is what it is used for: metres, kilograms, z upwards."""

    def __init__(self, name: str, kind: str) -> None:
        self._layer = Sdf.Layer.CreateAnonymous(".usda")
        top = self._layer.pseudoRoot
        for key, value in (("upAxis", "Z"), ("metersPerUnit", 1.0), ("kilogramsPerUnit", 1.0)):
            top.SetInfo(key, value)
        self._layer.defaultPrim = name
        self.root = Prim(Sdf.PrimSpec(self._layer, name, Sdf.SpecifierDef, kind))
        self.root._spec.SetInfo("kind", "component")

    def bytes(self, encoding: Literal["binary", "text"] = "text") -> bytes:
        """The file."""
        if encoding == "text":
            return str(self._layer.ExportToString()).encode()
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "layer.usdc"
            if not self._layer.Export(str(path)):
                msg = "usd-core could not write a layer"
                raise OSError(msg)
            return path.read_bytes()


def rounded(values: Iterable[float], least: float = 0.0) -> list[float]:
    """The values that the texts of a vector have in other formats."""
    return [float(text) for text in numbers(values, least=least)]
