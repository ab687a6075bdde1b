"""What is wrong with the prims of a USD whatever robot they are: names of what is not there, quaternions that
are no rotations, and extents that are not those of the points."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import differs, named

UNIT = 1e-5
"""A quaternion's length is 1 within this, and an extent [m] that of the points: in single precision."""


def schemas(prim: Any) -> frozenset[str]:
    """The applied schemas, also those that usd-core does not know."""
    return frozenset(map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas()))


def flaws(stage: Any, top: Any) -> Iterator[Finding]:
    """Of all prims at and below `top`."""
    for prim in Usd.PrimRange(top, Usd.TraverseInstanceProxies()):
        yield from _named(stage, prim)
        yield from _turned(prim)
        yield from _extent(prim)


def _found(prim: Any, attribute: str, message: str) -> Finding:
    """Named by what is below the default prim, or below the scope that it is in."""
    return Finding(*_place(prim, attribute), message)


def _place(prim: Any, attribute: str) -> tuple[str, str]:
    _, *names = str(prim.GetPath()).strip("/").split("/")
    if len(names) > 1 and prim.GetStage().GetPrimAtPath(prim.GetPath().GetPrefixes()[1]).IsA("Scope"):
        names = names[1:]
    first, *inner = names or [prim.GetName()]
    return named("def", first), " ".join(("/".join(inner), attribute)).strip()


def _named(stage: Any, prim: Any) -> Iterator[Finding]:
    """Each relationship and each connection ends at something."""
    every = [(one.GetName(), one.GetTargets()) for one in prim.GetRelationships()]
    every += [(one.GetName(), one.GetConnections()) for one in prim.GetAuthoredAttributes()]
    for name, paths in every:
        for path in paths:
            if not stage.GetObjectAtPath(path):
                yield _found(prim, name, f"names <{path}>, which is not there")


def _turned(prim: Any) -> Iterator[Finding]:
    for attribute in prim.GetAuthoredAttributes():
        if attribute.GetTypeName() in (Sdf.ValueTypeNames.Quatd, Sdf.ValueTypeNames.Quatf):
            length = Gf.Quatd(attribute.Get()).GetLength()
            if not abs(length - 1) <= UNIT:
                place = _place(prim, attribute.GetName())
                yield Finding(*place, f"has the length {length:.6g}, expected 1")


def _extent(prim: Any) -> Iterator[Finding]:
    """What a renderer leaves out by its extent must not be seen."""
    boundable = UsdGeom.Boundable(prim)
    if not boundable or not boundable.GetExtentAttr().HasAuthoredValue():
        return
    found = np.array(boundable.GetExtentAttr().Get(), dtype=float)
    wanted = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, Usd.TimeCode.Default())
    if wanted is None or not len(wanted):
        return
    expected = np.array(wanted, dtype=float)
    if found.shape != expected.shape or not np.allclose(found, expected, rtol=UNIT, atol=UNIT):
        element, attribute = _place(prim, "extent")
        yield differs(element, attribute, found, expected, "m")
