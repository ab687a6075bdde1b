"""MuJoCo's properties of geoms in contact: those of a compiled model against what is given, and MuJoCo's
defaults of what is not."""

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
from linkwright.stages.validate.model.coordinates import SAME

ATTRIBUTES = ("friction", "condim", "solref", "solimp", "solmix", "priority", "margin", "gap")

_BARE = b'<mujoco><worldbody><geom size="1"/></worldbody></mujoco>'


@functools.cache
def _default() -> Any:
    return compiled_text(_BARE, {})


def contact_differences(
    model: Any, geom: int, element: str, given: ContactProperties | None, own: Collection[str]
) -> Iterator[Finding]:
    """What a geom has otherwise. `own`: attributes that the user's own XML sets, whose values are the
    user's."""
    values = {} if given is None else given.given()
    for attribute in ATTRIBUTES:
        field = f"geom_{attribute}"
        if attribute in own or not hasattr(model, field):
            continue
        found = getattr(model, field)[geom]
        expected = values.get(attribute, getattr(_default(), field)[0])
        if not np.allclose(found, expected, rtol=SAME, atol=SAME):
            yield differs(element, attribute, found, expected)


def sets_defaults(compiled: CompiledModel) -> bool:
    """Whether the user's own XML adds to a class of defaults, so that what a geom has from it is the
    user's."""
    return any(
        one.adds and "default" in (tag_of(one.target), *one.added_tags)
        for one in compiled.written.amendments.changes
    )
