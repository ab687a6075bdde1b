"""Each relation of two joints is there, with its numbers, and no other."""

from collections.abc import Iterator, Mapping
from typing import Any

import mujoco
import numpy as np

from stages.robot.check import Check, Finding
from stages.robot.mjcf_extras import NO_EXTRAS
from stages.robot.model import Array, Relation
from stages.robot.plural import count
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import SAME, joint_index
from stages.validate.equalities import held_differences
from stages.validate.findings import differs, few, named
from stages.validate.mujoco_abilities import mimics, reads_mimic

SOLREF = (0.005, 1.0)
"""Of a relation: time constant [s] and damping ratio."""

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
    findings = few([*_findings(compiled, found), *(_unknown(compiled, found) if surplus > 0 else ())])
    passed = not wrong and surplus == 0
    yield compiled.result("relations", passed, detail, float(len(wrong)), 0.0, findings)
    if passed and expected and not compiled.urdf:
        yield _held(compiled)


def _held(compiled: CompiledModel) -> Check:
    """Followers follow as stiffly as loops are closed."""
    model, found = compiled.model, list[Finding]()
    by_source = (compiled.robot.mjcf or NO_EXTRAS).attributes_of("equality")
    for index in range(model.neq - compiled.surplus.equalities):
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT:
            name = model.equality(index).name
            found += held_differences(compiled, index, named("joint", name), SOLREF, by_source.get(name))
    detail = f"{count(len(compiled.robot.relations), 'relation')}, held as stiffly as loops"
    return compiled.within("relations are held", float(len(found)), 0.0, detail, few(found))


def _findings(compiled: CompiledModel, found: Pairs) -> Iterator[Finding]:
    """Of each relation: by its equality in an MJCF, by the <mimic> of its follower in a URDF."""
    model, urdf = compiled.model, compiled.urdf
    for one in compiled.robot.relations:
        if _fits(model, one, found):
            continue
        element = named("joint", one.follower if urdf else one.name)
        row = _row(model, one, found)
        if row is None:
            row = _row(model, one, _found(compiled, active=False))
            if row is not None:
                yield Finding(element, "active", f"is false, so that {one.follower} does not follow")
                continue
            missing = f"nothing says that {one.follower} follows {one.driver}"
            yield Finding(element, "mimic" if urdf else "", missing)
            continue
        data, expected, factor = row
        if not urdf:
            yield differs(element, "polycoef", data, expected)
            continue
        off = abs(data[1] - expected[1]) > SAME * max(1.0, abs(factor))
        place, word = (1, "multiplier") if off else (0, "offset")
        yield differs(element, f"mimic {word}", data[place], expected[place])


def _unknown(compiled: CompiledModel, found: Pairs) -> Iterator[Finding]:
    """The equalities or <mimic>s that are no relation of the robot's."""
    model = compiled.model
    known = {
        frozenset(joint_index(model, name) for name in (one.follower, one.driver))
        for one in compiled.robot.relations
    }
    for follower, driver in found:
        if frozenset((follower, driver)) not in known:
            first, second = (model.joint(index).name if index >= 0 else "" for index in (follower, driver))
            message = f"follows {second or 'nothing'}, which the robot does not have it do"
            yield Finding(named("joint", first), "mimic" if compiled.urdf else "polycoef", message)


def _found(compiled: CompiledModel, *, active: bool = True) -> Pairs:
    """The relations of a file; of an MJCF those that are active at the start, or not."""
    model = compiled.model
    if compiled.urdf and not reads_mimic():
        return mimics(model, compiled.path.read_bytes())
    own = model.eq_type[: model.neq - compiled.surplus.equalities]
    holds = (model.eq_active0[: len(own)] == active) | compiled.sets("active")
    rows = np.flatnonzero((own == mujoco.mjtEq.mjEQ_JOINT) & holds)
    return {(int(model.eq_obj1id[row]), int(model.eq_obj2id[row])): model.eq_data[row][:5] for row in rows}


def _fits(model: Any, relation: Relation, found: Pairs) -> bool:
    """Whether `found` has the relation with its numbers, solved for either of its joints."""
    row = _row(model, relation, found)
    if row is None:
        return False
    data, expected, factor = row
    return bool(np.abs(data - expected).max() <= SAME * max(1.0, abs(factor)))


def _row(model: Any, relation: Relation, found: Pairs) -> tuple[Array, Array, float] | None:
    """The five numbers of a relation, those expected, and its factor, solved for the joint that the file
    solves it for; None where the file does not have it."""
    y, x = joint_index(model, relation.follower), joint_index(model, relation.driver)
    factor, offset = relation.multiplier, relation.offset
    if (y, x) not in found and factor:
        y, x, factor, offset = x, y, 1 / factor, -offset / factor
    data = found.get((y, x))
    if data is None:
        return None
    zero = [float(model.qpos0[model.jnt_qposadr[joint]]) for joint in (y, x)]
    return data, np.array([factor * zero[1] + offset - zero[0], factor, 0, 0, 0]), factor
