"""The inertial of each body can be that of what is seen of it: what has other units is found.

A body whose mass lies within its shape has a radius of gyration about each axis, √(I/m), that is no larger
than the shape reaches from that axis, its centre of mass within the shape, and a density that matter has.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check, CheckLevel, Finding
from stages.robot.model import Array
from stages.robot.plural import count
from stages.validate.body_shapes import BodyExtents, extents, outside, reaches
from stages.validate.compiled import CompiledModel
from stages.validate.findings import MARK, link
from stages.validate.mujoco_poses import rotation

CODE = "C-INERTIAL"

LARGE, TOO_LARGE = 1.05, 5.0
"""The radius of gyration, as a share of the shape's reach: more cannot be, and so much more is no part that
is not shown. A thousand times the inertia makes it 32 times larger."""

SMALL = 0.05
"""A share that a body with its mass in one spot may have; a solid one has 0.3 to 0.7."""

TYPICAL = 0.5

OUT, FAR_OUT = 0.1, 2.0
"""How far outside its shape the centre of mass is, as a share of the shape's size: an unseen part may pull it
a little way, but not away."""

DENSE, TOO_DENSE = 12_000.0, 60_000.0
"""Of the mass in a box around the shape [kg/m³]: denser than lead, and far denser than any metal (osmium has
22,600)."""

THIN, TOO_THIN = 1.0, 0.05
"""The same [kg/m³]: an empty frame may have it; half of hydrogen's."""

GRAM = 1e-3
"""A mass below this [kg] stands for none: a marker that is only seen."""

_LARGER = ((1e3, "g m² read as kg m²?"), (1e6, "kg mm² read as kg m²?"), (1e9, "g mm² read as kg m²?"))
_SMALLER = ((1e-3, "a mass in g read as kg?"), (1e-6, "an inertia of a shape in mm?"))


@dataclass(frozen=True, slots=True)
class _Judged:
    """What is found of a body's quantity: `wrong` where it cannot be, else it is only odd."""

    value: float
    wrong: bool
    finding: Finding | None


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Three results; none where no body has both a mass and a shape."""
    model = compiled.model
    found: dict[str, list[_Judged]] = {"inertia": [], "centre": [], "density": []}
    for body in range(1, model.nbody):
        shape = extents(model, body)
        if shape is None or model.body_mass[body] <= 0.0 or shape.size <= 0.0 or _marked(model, body, shape):
            continue
        found["inertia"].append(_gyration(model, body, shape))
        found["centre"].append(_centre(model, body, shape))
        if shape.volume > (1e-3 * shape.size) ** 3:
            found["density"].append(_density(model, body, shape))
    bodies = count(len(found["inertia"]), "body", "bodies")
    for name, key, limit, words in (
        ("inertia fits the shape", "inertia", LARGE, "radius of gyration as a share of the shape's reach"),
        ("centre of mass in the shape", "centre", OUT, "how far out as a share of the shape's size"),
        ("density of matter", "density", DENSE, "mass in a box around the shape [kg/m³]"),
    ):
        if found[key]:
            yield _result(compiled, name, found[key], limit, f"{words}, of {bodies}")


def _marked(model: Any, body: int, shape: BodyExtents) -> bool:
    """Whether the shapes of a body are a mark and not its form, such as a box of a millimetre."""
    first = int(model.body_geomadr[body])
    kinds = model.geom_type[first : first + int(model.body_geomnum[body])]
    return shape.size < MARK and bool((kinds != mujoco.mjtGeom.mjGEOM_MESH).all())


def _result(compiled: CompiledModel, name: str, every: list[_Judged], limit: float, words: str) -> Check:
    odd = sorted((one for one in every if one.finding), key=lambda one: not one.wrong)
    detail = f"{words}: at most {max(one.value for one in every):.3g}"
    if odd:
        detail = "; ".join(f"{one.finding.element}: {one.finding.message}" for one in odd[:3] if one.finding)
    level: CheckLevel = "warning" if odd and not odd[0].wrong else "error"
    value = odd[0].value if odd else max(one.value for one in every)
    findings = [one.finding for one in odd if one.finding]
    return compiled.result(name, not odd, detail, value, limit, findings, level)


def _gyration(model: Any, body: int, shape: BodyExtents) -> _Judged:
    mass, moments = float(model.body_mass[body]), model.body_inertia[body]
    reach = reaches(shape, model.body_ipos[body], rotation(model.body_iquat[body]))
    shares = np.sqrt(moments / mass) / np.maximum(reach, 1e-6 * shape.size)
    worst = int(shares.argmax())
    share = float(shares[worst])
    if SMALL <= share <= LARGE:
        return _Judged(share, False, None)
    radius = 1e3 * math.sqrt(moments[worst] / mass)
    guess = _guess((share / TYPICAL) ** 2)
    words = f"its radius of gyration is {radius:.3g} mm, but its shape reaches {1e3 * reach[worst]:.3g} mm"
    finding = Finding(_element(model, body), "inertial diaginertia", f"{words} from that axis{guess}")
    return _Judged(share, share > TOO_LARGE, finding)


def _guess(factor: float) -> str:
    """The mistake of units that makes an inertia so many times what it should be."""
    for of_units, words in (*_LARGER, *_SMALLER):
        if abs(math.log10(max(factor, 1e-300) / of_units)) < 1.0:
            return f": about {of_units:,.6g} times what it could be, {words}"
    return ""


def _centre(model: Any, body: int, shape: BodyExtents) -> _Judged:
    com: Array = model.body_ipos[body]
    share = outside(shape, com) / shape.size
    if share <= OUT:
        return _Judged(share, False, None)
    inside = outside(shape, 1e-3 * com) <= OUT * shape.size
    guess = ": mm read as m?" if share > FAR_OUT and inside else ""
    words = f"its centre of mass is {1e3 * share * shape.size:.3g} mm outside its shape{guess}"
    return _Judged(share, share > FAR_OUT, Finding(_element(model, body), "inertial pos", words))


def _density(model: Any, body: int, shape: BodyExtents) -> _Judged:
    mass = float(model.body_mass[body])
    density = mass / shape.volume
    if THIN <= density <= DENSE or mass < GRAM:
        return _Judged(density, False, None)
    words = f"{mass:.3g} kg within {1e6 * shape.volume:.3g} cm³ is {density:.3g} kg/m³"
    if density > DENSE:
        words += ", denser than lead" + (
            ": g read as kg, or a shape in m read as mm?" if density > 1e5 else ""
        )
    else:
        words += ", next to nothing" + (": a shape in mm read as m?" if density < TOO_THIN else "")
    wrong = density > TOO_DENSE or density < TOO_THIN
    attribute = "inertial mass" if density > DENSE else "geom"
    return _Judged(density, wrong, Finding(_element(model, body), attribute, words))


def _element(model: Any, body: int) -> str:
    return link(model.body(body).name, urdf=False)
