"""Reports features of an MJCF source that the files of other formats lack."""

from collections.abc import Collection, Iterator

from linkwright.stages.formats.written import Written
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.mjcf_extras import MjcfExtras, children_of
from linkwright.stages.robot.text.globs import name_list

OTHER_FORMATS = ("urdf", "sdf", "usd")

WORDS_OF_SECTION = {
    "tendon": "tendons",
    "equality": "equalities",
    "actuator": "actuators that do not drive a single joint",
    "sensor": "sensors of quantities that other formats lack",
}
"""Section of an MJCF → the name for its elements that are not part of the robot's model."""


def mjcf_only(written: Written, formats: Collection[str]) -> Iterator[Diagnostic]:
    """Reports features that the other formats lose (I-MJCF-ONLY). `formats`: the written formats."""
    formats_without = [name.upper() for name in OTHER_FORMATS if name in formats]
    features = dict(_features(written, written.extras)) if written.mjcf_form.extras is not None else {}
    if formats_without and features:
        words = "; ".join(f"{kind}: {name_list(names)}" for kind, names in features.items())
        text = f"{', '.join(formats_without)} cannot have what only an MJCF has: {words}"
        yield Diagnostic("I-MJCF-ONLY", text, written.robot.name, "use the MJCF where it matters")


def _features(written: Written, extras: MjcfExtras) -> Iterator[tuple[str, list[str]]]:
    """Yields (kind, names) of each feature."""
    rows = {"springs": [dof.name for dof in written.robot.dofs if dof.spring is not None]}
    links = dict.fromkeys(shape.link for shape in written.shapes.shapes if shape.ellipsoid is not None)
    rows["ellipsoids (hulls in the others)"] = [*links]
    for section in (*extras.sections, *extras.scene):
        if section.tag in WORDS_OF_SECTION:
            names = [element.name or element.tag for element in section.children]
            rows[WORDS_OF_SECTION[section.tag]] = [*rows.get(WORDS_OF_SECTION[section.tag], ()), *names]
    mounted = [mount.element for mount in extras.mounted if mount.element.tag in ("camera", "light")]
    rows["cameras and lights"] = [element.name or element.tag for element in mounted]
    rows["bodies beside the robot"] = [
        element.name or "body" for element in children_of(extras.scene, "worldbody") if element.tag == "body"
    ]
    yield from ((kind, names) for kind, names in rows.items() if names)
