"""Finds errors of a USD's prims that do not depend on the robot.

These are references to missing prims, quaternions that are not of unit length, wrong extents, and cones of
ball joints that are not circular about the axis X.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from pxr import Gf, Sdf, Usd, UsdGeom, UsdPhysics

from linkwright.stages.robot.check import Finding
from linkwright.stages.validate.findings import differs, named

FLOAT32_TOLERANCE = 1e-5
"""Tolerance of the length of a unit quaternion, and of an extent [m]: both are in single precision."""


def schemas(prim: Any) -> frozenset[str]:
    """Returns the applied schemas, also those that usd-core does not know."""
    return frozenset(map(str, prim.GetPrimTypeInfo().GetAppliedAPISchemas()))


def filtered_paths(prim: Any) -> list[Any]:
    """Returns the paths of the prims with which a body or a collider does not collide."""
    if not prim.HasAPI(UsdPhysics.FilteredPairsAPI):
        return []
    return list(UsdPhysics.FilteredPairsAPI(prim).GetFilteredPairsRel().GetTargets())


def flaws(stage: Any, top: Any) -> Iterator[Finding]:
    """Yields the errors of all prims at and below `top`."""
    for prim in Usd.PrimRange(top, Usd.TraverseInstanceProxies()):
        yield from _missing_targets(stage, prim)
        yield from _quaternion_findings(prim)
        yield from _extent_findings(prim)
        yield from _cone_findings(prim)


def _element_and_attribute(prim: Any, attribute: str) -> tuple[str, str]:
    """Returns the title of the prim that a finding is on, and the attribute with the path from there. This
    prim is directly below the default prim, or directly below a scope there."""
    _, *names = str(prim.GetPath()).strip("/").split("/")
    if len(names) > 1 and prim.GetStage().GetPrimAtPath(prim.GetPath().GetPrefixes()[1]).IsA("Scope"):
        names = names[1:]
    first, *inner = names or [prim.GetName()]
    return named("def", first), " ".join(("/".join(inner), attribute)).strip()


def _missing_targets(stage: Any, prim: Any) -> Iterator[Finding]:
    """Yields relationships and connections to missing prims."""
    references = [(relation.GetName(), relation.GetTargets()) for relation in prim.GetRelationships()]
    references += [
        (attribute.GetName(), attribute.GetConnections()) for attribute in prim.GetAuthoredAttributes()
    ]
    for name, paths in references:
        for path in paths:
            if not stage.GetObjectAtPath(path):
                yield Finding(*_element_and_attribute(prim, name), f"names <{path}>, which does not exist")


def _quaternion_findings(prim: Any) -> Iterator[Finding]:
    """Yields the quaternions that are not of unit length."""
    for attribute in prim.GetAuthoredAttributes():
        if attribute.GetTypeName() in (Sdf.ValueTypeNames.Quatd, Sdf.ValueTypeNames.Quatf):
            length = Gf.Quatd(attribute.Get()).GetLength()
            if not abs(length - 1) <= FLOAT32_TOLERANCE:
                element_and_attribute = _element_and_attribute(prim, attribute.GetName())
                yield Finding(*element_and_attribute, f"has the length {length:.6g}, expected 1")


def _cone_findings(prim: Any) -> Iterator[Finding]:
    """Checks that the cone of a ball joint is circular. PhysX accepts only cones about X."""
    if prim.GetTypeName() != "PhysicsSphericalJoint":
        return
    joint = UsdPhysics.SphericalJoint(prim)
    angles = [
        attribute.Get() for attribute in (joint.GetConeAngle0LimitAttr(), joint.GetConeAngle1LimitAttr())
    ]
    if angles[0] != angles[1]:
        element, attribute = _element_and_attribute(prim, "physics:coneAngle1Limit")
        yield differs(element, attribute, angles[1], angles[0], "deg")
    if joint.GetAxisAttr().Get() != "X":
        yield differs(*_element_and_attribute(prim, "physics:axis"), str(joint.GetAxisAttr().Get()), "X")


def _extent_findings(prim: Any) -> Iterator[Finding]:
    """Checks the extent, by which renderers skip prims outside the picture."""
    boundable = UsdGeom.Boundable(prim)
    if not boundable or not boundable.GetExtentAttr().HasAuthoredValue():
        return
    extent = np.array(boundable.GetExtentAttr().Get(), dtype=float)
    computed = UsdGeom.Boundable.ComputeExtentFromPlugins(boundable, Usd.TimeCode.Default())
    if computed is None or not len(computed):
        return
    expected = np.array(computed, dtype=float)
    if extent.shape != expected.shape or not np.allclose(
        extent, expected, rtol=FLOAT32_TOLERANCE, atol=FLOAT32_TOLERANCE
    ):
        element, attribute = _element_and_attribute(prim, "extent")
        yield differs(element, attribute, extent, expected, "m")
