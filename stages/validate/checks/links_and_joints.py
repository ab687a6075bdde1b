"""Every link and joint is there by name, and no other degree of freedom."""

from collections.abc import Iterator

from stages.robot.check import Check
from stages.robot.plural import count
from stages.validate.compiled import CompiledModel
from stages.validate.coordinates import WIDTH, joints_of, missing_names

CODE = "C-LINKS"


def check(compiled: CompiledModel) -> Iterator[Check]:
    robot, model = compiled.robot, compiled.model
    floating = 0 if robot.base.fixed or compiled.urdf else 6
    expected = sum(WIDTH[kind] for _, kind, _ in joints_of(robot, compiled.urdf)) + floating
    expected += compiled.surplus.dofs
    surplus = model.nv - expected
    missing = missing_names(compiled)
    detail = f"{count(len(robot.links), 'link')}, {_dofs(model.nv)}"
    if missing:
        detail = f"missing: {', '.join(missing)}"
    elif surplus:
        detail = f"expected {_dofs(expected)}, found {model.nv}"
    passed = not missing and surplus == 0
    yield compiled.result("links and joints", passed, detail, float(abs(surplus)), 0.0)


def _dofs(number: int) -> str:
    return count(number, "degree of freedom", "degrees of freedom")
