"""Sets the fields of a variant in a compiled model, and lets MuJoCo derive the others from them."""

import copy
from typing import Any

import mujoco
import numpy as np

from linkwright.stages.formats.variants import KINDS, Variants
from linkwright.stages.mujoco.names import OBJ, count_of, names_of

_OBJECT_BY_KIND = {
    "body": OBJ.mjOBJ_BODY,
    "joint": OBJ.mjOBJ_JOINT,
    "geom": OBJ.mjOBJ_GEOM,
    "actuator": OBJ.mjOBJ_ACTUATOR,
}


def names_in(model: Any) -> dict[str, tuple[str, ...]]:
    """Returns the names of a model's elements by kind, "" for those without a name."""
    return {
        kind: tuple(names_of(model, _OBJECT_BY_KIND[kind], count_of(model, _OBJECT_BY_KIND[kind])))
        for kind in KINDS
    }


def places(model: Any) -> Any:
    """Returns the index of each geom among the geoms of its body (ngeom,)."""
    return (np.arange(model.ngeom) - model.body_geomadr[model.geom_bodyid]).astype(np.int32)


def misfit(model: Any, variants: Variants) -> str:
    """Returns the name of the first array, or pair of arrays, that does not fit this model; "" if all fit.
    The model may have further elements after those of the robot."""
    names_of_model = names_in(model)
    for kind, names in variants.names.items():
        if kind != "geom" and names != names_of_model[kind][: len(names)]:
            return f"{kind}_names"
    bodies, geom_places = variants.geom_bodyid, variants.geom_in_body
    valid = (bodies >= 0) & (bodies < model.nbody) if bodies.shape == geom_places.shape else np.False_
    if not valid.all() or not ((geom_places >= 0) & (geom_places < model.body_geomnum[bodies])).all():
        return "geom_bodyid and geom_in_body"
    for field, values in variants.fields.items():
        array = getattr(model, field, None)
        # The file may name anything of the model, and have arrays of any shape.
        if not isinstance(array, np.ndarray) or values.ndim < 2:
            return field
        if array[_rows(model, variants, field)].shape != values.shape[1:]:
            return field
    return ""


def variant(model: Any, variants: Variants, number: int) -> Any:
    """Returns a copy of the model as the variant of the index `number`."""
    copied = copy.copy(model)
    for field, values in variants.fields.items():
        getattr(copied, field)[_rows(model, variants, field)] = values[number]
    # These fields tell MuJoCo that an element has the frame of its body or of its mass. That may no longer
    # hold.
    copied.body_sameframe[copied.body_simple == 0] = 0
    copied.geom_sameframe[:] = copied.site_sameframe[:] = 0
    mujoco.mj_setConst(copied, mujoco.MjData(copied))
    return copied


def _rows(model: Any, variants: Variants, field: str) -> Any:
    """Returns the rows of the model's array that hold a field's values. The model may have further rows: a
    scene has more geoms on the world."""
    if field.startswith("geom_"):
        return model.body_geomadr[variants.geom_bodyid] + variants.geom_in_body
    return slice(variants.fields[field].shape[1])
