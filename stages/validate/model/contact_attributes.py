"""Compares MuJoCo's contact properties of geoms with given properties, or with the defaults."""

import functools
from collections.abc import Collection, Iterator
from typing import Any

import numpy as np

from linkwright.stages.mujoco.compile import compiled_text
from linkwright.stages.robot.check import Finding
from linkwright.stages.robot.model.amendments import tag_of
from linkwright.stages.robot.model.geom_form import ContactProperties
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import differs
from linkwright.stages.validate.model.coordinates import ENGINE_TOLERANCE

ATTRIBUTES = ("friction", "condim", "solref", "solimp", "solmix", "priority", "margin", "gap")

_DEFAULT_GEOM_MJCF = b'<mujoco><worldbody><geom size="1"/></worldbody></mujoco>'


@functools.cache
def _model_of_defaults() -> Any:
    """Returns a model with a single geom, whose contact properties are MuJoCo's defaults."""
    return compiled_text(_DEFAULT_GEOM_MJCF, {})


def contact_differences(
    model: Any, geom: int, element: str, properties: ContactProperties | None, set_by_user: Collection[str]
) -> Iterator[Finding]:
    """Yields the differences of a geom from `properties`; those that are not given, or all for None, must be
    MuJoCo's defaults. `set_by_user`: attributes that the user's own XML sets, which are not compared."""
    values = {} if properties is None else properties.given()
    for attribute in ATTRIBUTES:
        field = f"geom_{attribute}"
        if attribute in set_by_user or not hasattr(model, field):
            continue
        value = getattr(model, field)[geom]
        expected = values.get(attribute, getattr(_model_of_defaults(), field)[0])
        if not np.allclose(value, expected, rtol=ENGINE_TOLERANCE, atol=ENGINE_TOLERANCE):
            yield differs(element, attribute, value, expected)


def sets_defaults(compiled: CompiledModel) -> bool:
    """Tells whether the user's own XML adds to a class of defaults, so that values from it are the user's."""
    return any(
        change.adds and "default" in (tag_of(change.target), *change.added_tags)
        for change in compiled.written.amendments.changes
    )
