"""Checks that the relations of joints are the robot's, with their numbers."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.equalities import solver_differences
from linkwright.stages.validate.read.compiled import read_compiled
from linkwright.stages.validate.same.relations import relations

SOLREF = (0.005, 1.0)
"""Solver reference of relations: time constant [s] and damping ratio."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Compares the relations; in an MJCF also how stiffly followers follow."""
    (check_of_relations,) = relations(read_compiled(compiled))
    yield check_of_relations
    if check_of_relations.passed and compiled.robot.relations and not compiled.urdf:
        yield _stiffness_check(compiled)


def _stiffness_check(compiled: CompiledModel) -> Check:
    """Checks that followers follow as stiffly as loops are closed."""
    model, findings = compiled.model, list[Finding]()
    by_source = (compiled.robot.mjcf or NO_EXTRAS).attributes_of("equality")
    for index in range(model.neq - compiled.surplus.equalities):
        if model.eq_type[index] == mujoco.mjtEq.mjEQ_JOINT:
            name = model.equality(index).name
            findings += solver_differences(compiled, index, named("joint", name), SOLREF, by_source.get(name))
    detail = f"{count(len(compiled.robot.relations), 'relation')}, held as stiffly as loops"
    return compiled.within("relations are held", float(len(findings)), 0.0, detail, few(findings))
