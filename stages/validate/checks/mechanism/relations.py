"""Each relation of two joints is there, with its numbers, and no other."""

from collections.abc import Iterator

import mujoco

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.model.mjcf_extras import NO_EXTRAS
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import few, named
from linkwright.stages.validate.model.equalities import held_differences
from linkwright.stages.validate.read.compiled import read_compiled
from linkwright.stages.validate.same.relations import relations

SOLREF = (0.005, 1.0)
"""Of a relation: time constant [s] and damping ratio."""


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of an MJCF also how stiffly followers follow."""
    (found,) = relations(read_compiled(compiled))
    yield found
    if found.passed and compiled.robot.relations and not compiled.urdf:
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
