"""Finds, in the text of a URDF, an MJCF or an SDF, the things that readers do not take."""

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING

from linkwright.stages.formats.xml import Element, tag
from linkwright.stages.robot.check import Finding
from linkwright.stages.targets.row import Thing
from linkwright.stages.targets.versions import ADDED_VALUES, ADDED_WORDS, REMOVED_WORDS, Words
from linkwright.stages.validate.reading.documents import title_of

if TYPE_CHECKING:
    from linkwright.stages.validate.reading.documents import ModelDocument

FindThings = Callable[["ModelDocument"], Iterator[Finding]]


def _at(path: str, test: Callable[[Element], bool] = lambda _: True, attribute: str = "") -> FindThings:
    """Returns a function that finds the elements at a path that pass a test."""

    def find(document: "ModelDocument") -> Iterator[Finding]:
        elements = (element for element in document.root.iterfind(path) if test(element))
        return (Finding(title_of(element), attribute, "") for element in elements)

    return find


def _ends(attribute: str, ending: str) -> Callable[[Element], bool]:
    return lambda element: str(element.get(attribute, "")).lower().endswith(ending)


def _is_set(attribute: str) -> Callable[[Element], bool]:
    """Returns a test of whether an attribute has a number other than 0."""
    return lambda element: _is_nonzero(str(element.get(attribute, "")))


def _is_nonzero(text: str) -> bool:
    """Tells whether a text has a number other than 0. A text that is not numbers counts as one."""
    try:
        return any(float(word) != 0.0 for word in text.split())
    except ValueError:
        return True


def _words(words: Words, version: str, *, came: bool) -> FindThings:
    """Returns a function that finds the words of a document that are new in this version, or that are gone.
    Words are elements, attributes and values."""

    def find(document: "ModelDocument") -> Iterator[Finding]:
        for element in document.root.iter():
            name = tag(element)
            if name in words and not words[name]:
                yield Finding(title_of(element), "", "")
            for attribute in words.get(name, ()):
                if attribute in element.attrib:
                    yield Finding(title_of(element), attribute, "")
            for (tag_name, attribute, value), first in ADDED_VALUES.items():
                if came and first == version and name == tag_name and element.get(attribute) == value:
                    yield Finding(title_of(element), attribute, "")

    return find


def _text(path: str, test: Callable[[str], bool]) -> FindThings:
    """Returns a function that finds the elements at a path whose text passes a test."""
    return _at(path, lambda element: test((element.text or "").strip()))


def _closing(document: "ModelDocument") -> Iterator[Finding]:
    """Yields the joints of an SDF that close a loop, since earlier joints connect their links already. The
    names of links are those of their own model."""
    for model in document.root.iter("world", "model"):
        connected: dict[str, set[str]] = {}
        # Only the model's own children: a plugin may have elements of this name that are no joints.
        for joint in model.iterfind("joint"):
            parent, child = ((joint.findtext(end) or "").strip() for end in ("parent", "child"))
            if not (parent and child):
                continue
            links_of_parent = connected.get(parent, {parent})
            if child in links_of_parent:
                yield Finding(title_of(joint), "", "")
            links = links_of_parent | connected.get(child, {child})
            connected |= dict.fromkeys(links, links)


def _has_unusual_gravity(option: Element) -> bool:
    try:
        return [float(word) for word in str(option.get("gravity")).split()] != [0.0, 0.0, -9.81]
    except ValueError:
        return True


_MASSLESS = _at("link", lambda link: link.find("inertial") is None and link.get("name") != "world")
"""Finds links without an inertial, except `world`, which means everything that does not move."""

TEXT: Mapping[tuple[str, Thing], FindThings] = {
    ("urdf", "colliders in STL"): _at(".//collision/geometry/mesh", _ends("filename", ".stl"), "filename"),
    ("urdf", "damping"): _at("joint/dynamics", _is_set("damping"), "damping"),
    ("urdf", "effort"): _at("joint/limit", _is_set("effort"), "effort"),
    ("urdf", "frames"): _MASSLESS,
    ("urdf", "friction"): _at("joint/dynamics", _is_set("friction"), "friction"),
    ("urdf", "inertia"): _at("link", lambda link: link.find("inertial") is not None),
    ("urdf", "relations"): _at("joint/mimic"),
    ("urdf", "visuals in GLB"): _at(".//visual/geometry/mesh", _ends("filename", ".glb"), "filename"),
    ("urdf", "velocity"): _at("joint/limit", _is_set("velocity"), "velocity"),
    ("sdf", "balls"): _at(".//joint", lambda joint: joint.get("type") == "ball"),
    ("sdf", "colliders in STL"): _text(".//collision//uri", lambda uri: uri.lower().endswith(".stl")),
    ("sdf", "fixed base"): _text(".//joint/parent", lambda parent: parent == "world"),
    ("sdf", "friction"): _text(".//axis/dynamics/friction", _is_nonzero),
    ("sdf", "loops"): _closing,
    ("sdf", "relations"): _at(".//axis/mimic"),
    ("mjcf", "adhesion"): _at("actuator/adhesion"),
    ("mjcf", "cameras"): _at(".//camera"),
    ("mjcf", "cones"): _at(".//joint[@range]", lambda joint: joint.get("type") == "ball", "range"),
    ("mjcf", "delays of actuators"): _at("actuator/*", _is_set("delay"), "delay"),
    ("mjcf", "effort"): _at(".//joint[@actuatorfrcrange]", attribute="actuatorfrcrange"),
    ("mjcf", "everything"): _at("worldbody//joint"),
    ("mjcf", "friction"): _at(".//joint", _is_set("frictionloss"), "frictionloss"),
    ("mjcf", "gravity"): _at("option[@gravity]", _has_unusual_gravity, "gravity"),
    ("mjcf", "keyframes"): _at("keyframe/key"),
    ("mjcf", "loops"): _at("equality/*", lambda element: tag(element) in ("connect", "weld")),
    ("mjcf", "meshes in STL"): _at("asset/mesh", _ends("file", ".stl"), "file"),
    ("mjcf", "noslip iterations"): _at("option", _is_set("noslip_iterations"), "noslip_iterations"),
    ("mjcf", "orientation servos"): _at("actuator/orientation"),
    ("mjcf", "pid servos"): _at("actuator/pid"),
    ("mjcf", "pneumatic cylinders"): _at("actuator/cylinder"),
    ("mjcf", "polynomials of damping"): _at(
        ".//joint[@damping]", lambda joint: len(str(joint.get("damping")).split()) > 1, "damping"
    ),
    ("mjcf", "relations"): _at("equality/joint"),
    ("mjcf", "sensors"): _at("sensor/*"),
    ("mjcf", "spring-dampers"): _at(".//joint[@springdamper]", attribute="springdamper"),
    ("mjcf", "starts of joints"): _at(".//joint", _is_set("ref"), "ref"),
    ("mjcf", "time constants of servos"): _at("actuator/position", _is_set("timeconst"), "timeconst"),
    ("mjcf", "words that MuJoCo 4.0 no longer has"): _words(REMOVED_WORDS["4.0"], "4.0", came=False),
    ("mjcf", "words of MuJoCo 3.16"): _words(ADDED_WORDS["3.16"], "3.16", came=True),
    ("mjcf", "words of MuJoCo 3.17"): _words(ADDED_WORDS["3.17"], "3.17", came=True),
    ("mjcf", "words of MuJoCo 4.0"): _words(ADDED_WORDS["4.0"], "4.0", came=True),
}
"""Format and thing → function that finds such elements of a document."""
