"""Each relation of two joints is there, with its numbers, and no other."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check
from stages.robot.model import Array, Relation
from stages.robot.plural import count
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index
from stages.validate.mujoco_abilities import mimics, reads_mimic

Pairs = Mapping[tuple[int, int], Array]
"""(follower, driver) → the five numbers of MuJoCo's equality of two joints."""

CODE = "C-RELATION"


def check(compiled: CompiledModel) -> Iterator[Check]:
    found = _found(compiled)
    wrong = [
        relation.name for relation in compiled.robot.relations if not _fits(compiled.model, relation, found)
    ]
    expected = len(compiled.robot.relations)
    surplus = len(found) - expected
    detail = f"{count(expected, 'relation')} with the numbers of the robot"
    if wrong:
        detail = f"differ: {', '.join(wrong)}"
    elif surplus:
        detail = f"expected {count(expected, 'relation')}, found {len(found)}"
    yield compiled.result("relations", not wrong and surplus == 0, detail, float(len(wrong)), 0.0)


def _found(compiled: CompiledModel) -> Pairs:
    model = compiled.model
    if compiled.urdf and not reads_mimic():
        return mimics(model, compiled.path.read_bytes())
    own = model.eq_type[: model.neq - compiled.surplus.equalities]
    rows = np.flatnonzero(own == mujoco.mjtEq.mjEQ_JOINT)
    return {(int(model.eq_obj1id[row]), int(model.eq_obj2id[row])): model.eq_data[row][:5] for row in rows}


def _fits(model: Any, relation: Relation, found: Pairs) -> bool:
    """Whether `found` has the relation with its numbers, solved for either of its joints."""
    y, x = joint_index(model, relation.follower), joint_index(model, relation.driver)
    factor, offset = relation.multiplier, relation.offset
    if (y, x) not in found and factor:
        y, x, factor, offset = x, y, 1 / factor, -offset / factor
    data = found.get((y, x))
    if data is None:
        return False
    zero = [float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (y, x)]
    expected = np.array([factor * zero[1] + offset - zero[0], factor, 0, 0, 0])
    return bool(np.abs(data - expected).max() <= SAME * max(1.0, abs(factor)))
