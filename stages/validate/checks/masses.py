"""Mass, centre of mass and inertia of each link are those of its parts in CAD.

The expected values are summed independently over the parts, by second moments, not taken from the links
that the files were written from. A link whose inertial the user gave must have that.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np

from stages.robot.check import Check
from stages.robot.model import Array
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import body_index, placed
from stages.validate.equalities import carriers
from stages.validate.lumps import EXACT, UNITS, Lump, differences, expected_lump, merged, moved_lump
from stages.validate.mujoco_abilities import axes_error

CODE = "C-MASS"


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Each link's body, together with the carriers that have a share of it."""
    shares = {} if compiled.urdf else carriers(compiled.model, compiled.robot)
    worst, where = dict.fromkeys(UNITS, 0.0), dict.fromkeys(UNITS, "")
    engine_error = 0.0
    for link in compiled.robot.links:
        expected = expected_lump(link)
        lumps = [_lump(compiled.model, body_index(compiled.model, link.name), np.eye(4))]
        lumps += [_lump(compiled.model, body, pose) for body, pose in shares.get(link.name, [])]
        largest = float(np.abs(expected[2]).max())
        allowed = axes_error(largest) if compiled.urdf and largest else 0.0
        engine_error = max(engine_error, allowed)
        for key, value in differences(merged(lumps), expected, allowed).items():
            if not value < worst[key]:
                worst[key], where[key] = value, link.name
    for key, unit in UNITS.items():
        if key == "inertia" and engine_error > EXACT:
            unit += ", beyond the error of this MuJoCo's principal axes"
        detail = f"{key} of each link against CAD's parts ({unit}); worst: {where[key]}"
        yield compiled.within(key, worst[key], EXACT, detail)


def _lump(model: Any, body: int, link_from_body: Array) -> Lump:
    """The mass properties of a body, in the frame of a link."""
    axes = placed(model.body_iquat[body], model.body_ipos[body])
    tensor = axes[:3, :3] @ np.diag(model.body_inertia[body]) @ axes[:3, :3].T
    return moved_lump(float(model.body_mass[body]), axes[:3, 3], tensor, link_from_body)
