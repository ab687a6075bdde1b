"""Checks that each visible link has a collider, unless the user asked for none."""

from collections.abc import Iterator

from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.text.plural import count
from linkwright.stages.validate.compiled import CompiledModel
from linkwright.stages.validate.findings import named
from linkwright.stages.validate.model.shapes import is_bare_by_choice, seen_and_solid


def check(compiled: CompiledModel) -> Iterator[Check]:
    """Checks robots with colliders, except those from an MJCF, since such a source decides what collides."""
    if compiled.robot.mjcf is not None:
        return
    geoms = seen_and_solid(compiled.model)
    if not any(solid for _, solid in geoms.values()):
        return
    bodies = {compiled.model.body(body).name: solid for body, (seen, solid) in geoms.items() if seen}
    bare = [name for name, solid in bodies.items() if not solid and not is_bare_by_choice(compiled, name)]
    findings = [
        Finding(named("body", name), "geom", f"{name} has a visual shape and no collider") for name in bare
    ]
    detail = f"{count(len(bodies), 'link')} with a visual shape, each with a collider, or without as asked"
    if bare:
        detail = f"without a collider, so that they pass through everything: {', '.join(bare)}"
    value = float(len(bare))
    yield compiled.result("links that collide", not bare, detail, value, 0.0, findings, "warning")
