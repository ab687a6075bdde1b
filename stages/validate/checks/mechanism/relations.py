"""Checks that a file has the robot's relations, with the same multipliers and offsets, and enforces them
stiffly."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.equalities import solver_differences
from linkwright.stages.validate.read.compiled import read_compiled
from linkwright.stages.validate.same.relations import compare_relations

SOLREF = (0.005, 1.0)
"""Expected `solref` of relations: time constant [s] and damping ratio."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the relations and, in an MJCF, how stiffly they are enforced."""
    (relation_check,) = compare_relations(read_compiled(compiled))
    yield relation_check
    if relation_check.passed and compiled.robot.relations and not compiled.urdf:
        yield _stiffness_check(compiled)


def _stiffness_check(compiled: CompiledModel) -> Check:
    """Checks that relations are enforced as stiffly as loops."""
    model, findings = compiled.model, list[Finding]()
    source_attributes = (compiled.robot.mjcf or NO_EXTRAS).attributes_of("equality")
    # The surplus equalities, which the user or the source adds, come last.
    for index in range(model.neq - compiled.surplus.equalities):
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT:
            name = model.equality(index).name
            attributes = source_attributes.get(name)
            findings += solver_differences(compiled, index, named("joint", name), SOLREF, attributes)
    detail = f"{count(len(compiled.robot.relations), 'relation')}, held as stiffly as loops"
    return compiled.within("relations are held", float(len(findings)), 0.0, detail, few(findings))
