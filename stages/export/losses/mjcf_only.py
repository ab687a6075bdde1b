"""What a robot has from its MJCF source and no other format can have."""

from collections.abc import Collection, Iterator

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras, children_of
from linkwright.stages.robot.text.globs import listed

OTHERS = ("urdf", "sdf", "usd")

SECTIONS = {
    "tendon": "tendons",
    "equality": "equalities",
    "actuator": "actuators that are on no single joint",
    "sensor": "sensors of what other formats lack",
}
"""Section of an MJCF → what its elements are called, of those that the robot does not have itself."""


def mjcf_only(written: Written, formats: Collection[str]) -> Iterator[Diagnostic]:
    """I-MJCF-ONLY. `formats`: those that are written."""
    others = [name.upper() for name in OTHERS if name in formats]
    found = dict(_lacking(written, written.extras)) if written.mjcf_form.extras is not None else {}
    if others and found:
        words = "; ".join(f"{what}: {listed(names)}" for what, names in found.items())
        text = f"{', '.join(others)} cannot have what only an MJCF has: {words}"
        yield Diagnostic("I-MJCF-ONLY", text, written.robot.name, "use the MJCF where it matters")


def _lacking(written: Written, extras: MjcfExtras) -> Iterator[tuple[str, list[str]]]:
    """What it is, and the names."""
    rows = {"springs": [dof.name for dof in written.robot.dofs if dof.spring is not None]}
    links = dict.fromkeys(shape.link for shape in written.shapes.shapes if shape.ellipsoid is not None)
    rows["ellipsoids, of which the others have the hulls"] = [*links]
    for section in (*extras.sections, *extras.scene):
        if section.tag in SECTIONS:
            names = [element.name or element.tag for element in section.children]
            rows[SECTIONS[section.tag]] = [*rows.get(SECTIONS[section.tag], ()), *names]
    mounted = [one.element for one in extras.mounted if one.element.tag in ("camera", "light")]
    rows["cameras and lights"] = [element.name or element.tag for element in mounted]
    rows["bodies beside the robot"] = [
        element.name or "body" for element in children_of(extras.scene, "worldbody") if element.tag == "body"
    ]
    yield from ((what, names) for what, names in rows.items() if names)
