"""Each link that is seen collides, unless that was asked for."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.shapes import asked_bare, seen_and_solid


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Of a robot of which something collides; an MJCF source says itself what does."""
    if compiled.robot.mjcf is not None:
        return
    every = seen_and_solid(compiled.model)
    if not any(solid for _, solid in every.values()):
        return
    bodies = {compiled.model.body(body).name: solid for body, (seen, solid) in every.items() if seen}
    bare = [name for name, solid in bodies.items() if not solid and not asked_bare(compiled, name)]
    findings = [Finding(named("body", name), "geom", f"{name} is seen and has no collider") for name in bare]
    detail = f"{count(len(bodies), 'link')} with a visual shape, each with a collider, or without as asked"
    if bare:
        detail = f"without a collider, so that they pass through everything: {', '.join(bare)}"
    value = float(len(bare))
    yield compiled.result("links that collide", not bare, detail, value, 0.0, findings, "warning")
