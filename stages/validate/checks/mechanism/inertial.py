"""Checks that the mass, centre of mass and inertia of each body are plausible for its shapes."""

from collections.abc import Iterator
from typing import Any

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import link
from linkwright.stages.validate.model import inertials
from linkwright.stages.validate.model.body_shapes import extents
from linkwright.stages.validate.model.inertials import ShapedInertial
from linkwright.stages.validate.model.poses import rotation


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks the bodies that have both a mass and a shape."""
    # Body 0 is the world.
    shaped = (_shaped_inertial(compiled.model, body) for body in range(1, compiled.model.nbody))
    return inertials.checks(compiled.path.name, (inertial for inertial in shaped if inertial is not None))


def _shaped_inertial(model: Any, body: int) -> ShapedInertial | None:
    """Returns the inertial and the shapes of a body; None without a shape."""
    shapes = extents(model, body)
    if shapes is None:
        return None
    element = link(model.body(body).name, urdf=False)
    return ShapedInertial(
        mass=float(model.body_mass[body]),
        com=model.body_ipos[body],
        moments=model.body_inertia[body],
        axes=rotation(model.body_iquat[body]),
        shapes=shapes,
        # Bodies that are welded to the world do not move.
        moves=bool(model.body_weldid[body]),
        places={
            "inertia": (element, "inertial diaginertia"),
            "centre": (element, "inertial pos"),
            "mass": (element, "inertial mass"),
            "shape": (element, "geom"),
        },
    )
