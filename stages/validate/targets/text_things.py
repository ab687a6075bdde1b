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
"""A function that yields a finding on each thing of a kind in a document."""


def _elements(path: str, test: Callable[[Element], bool] = lambda _: True, attribute: str = "") -> FindThings:
    """Returns a function that finds the elements at a path that pass a test. `attribute`: the one that the
    findings name."""

    def find(document: "ModelDocument") -> Iterator[Finding]:
        elements = (element for element in document.root.iterfind(path) if test(element))
        return (Finding(title_of(element), attribute, "") for element in elements)

    return find


def _has_ending(attribute: str, ending: str) -> Callable[[Element], bool]:
    """Returns a test of whether an attribute has an ending, in small or capital letters."""
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


def _words(words: Words, version: str, *, are_added: bool) -> FindThings:
    """Returns a function that finds the words in a document that a version of MuJoCo has added, or else has
    removed. Words are elements and attributes; of added words also values."""

    def find(document: "ModelDocument") -> Iterator[Finding]:
        for element in document.root.iter():
            name = tag(element)
            if name in words and not words[name]:
                yield Finding(title_of(element), "", "")
            for attribute in words.get(name, ()):
                if attribute in element.attrib:
                    yield Finding(title_of(element), attribute, "")
            for (tag_name, attribute, value), first_version in ADDED_VALUES.items():
                is_added = are_added and first_version == version
                if is_added and name == tag_name and element.get(attribute) == value:
                    yield Finding(title_of(element), attribute, "")

    return find


def _elements_by_text(path: str, test: Callable[[str], bool]) -> FindThings:
    """Returns a function that finds the elements at a path whose text passes a test."""
    return _elements(path, lambda element: test((element.text or "").strip()))


def _loops(document: "ModelDocument") -> Iterator[Finding]:
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
    """Tells whether the gravity of an MJCF differs from MuJoCo's default."""
    try:
        return [float(word) for word in str(option.get("gravity")).split()] != [0.0, 0.0, -9.81]
    except ValueError:
        return True


_MASSLESS_LINKS = _elements(
    "link", lambda link: link.find("inertial") is None and link.get("name") != "world"
)
"""Finds links without an inertial, except `world`, which means everything that does not move."""

TEXT_FINDERS: Mapping[tuple[str, Thing], FindThings] = {
    ("urdf", "colliders in STL"): _elements(
        ".//collision/geometry/mesh", _has_ending("filename", ".stl"), "filename"
    ),
    ("urdf", "damping"): _elements("joint/dynamics", _is_set("damping"), "damping"),
    ("urdf", "effort"): _elements("joint/limit", _is_set("effort"), "effort"),
    ("urdf", "frames"): _MASSLESS_LINKS,
    ("urdf", "friction"): _elements("joint/dynamics", _is_set("friction"), "friction"),
    ("urdf", "inertia"): _elements("link", lambda link: link.find("inertial") is not None),
    ("urdf", "relations"): _elements("joint/mimic"),
    ("urdf", "visuals in GLB"): _elements(
        ".//visual/geometry/mesh", _has_ending("filename", ".glb"), "filename"
    ),
    ("urdf", "velocity"): _elements("joint/limit", _is_set("velocity"), "velocity"),
    ("sdf", "balls"): _elements(".//joint", lambda joint: joint.get("type") == "ball"),
    ("sdf", "colliders in STL"): _elements_by_text(
        ".//collision//uri", lambda uri: uri.lower().endswith(".stl")
    ),
    ("sdf", "fixed base"): _elements_by_text(".//joint/parent", lambda parent: parent == "world"),
    ("sdf", "friction"): _elements_by_text(".//axis/dynamics/friction", _is_nonzero),
    ("sdf", "loops"): _loops,
    ("sdf", "relations"): _elements(".//axis/mimic"),
    ("mjcf", "adhesion"): _elements("actuator/adhesion"),
    ("mjcf", "cameras"): _elements(".//camera"),
    ("mjcf", "cones"): _elements(".//joint[@range]", lambda joint: joint.get("type") == "ball", "range"),
    ("mjcf", "delays of actuators"): _elements("actuator/*", _is_set("delay"), "delay"),
    ("mjcf", "effort"): _elements(".//joint[@actuatorfrcrange]", attribute="actuatorfrcrange"),
    ("mjcf", "everything"): _elements("worldbody//joint"),
    ("mjcf", "friction"): _elements(".//joint", _is_set("frictionloss"), "frictionloss"),
    ("mjcf", "gravity"): _elements("option[@gravity]", _has_unusual_gravity, "gravity"),
    ("mjcf", "keyframes"): _elements("keyframe/key"),
    ("mjcf", "loops"): _elements("equality/*", lambda element: tag(element) in ("connect", "weld")),
    ("mjcf", "meshes in STL"): _elements("asset/mesh", _has_ending("file", ".stl"), "file"),
    ("mjcf", "noslip iterations"): _elements("option", _is_set("noslip_iterations"), "noslip_iterations"),
    ("mjcf", "orientation servos"): _elements("actuator/orientation"),
    ("mjcf", "pid servos"): _elements("actuator/pid"),
    ("mjcf", "pneumatic cylinders"): _elements("actuator/cylinder"),
    ("mjcf", "polynomials of damping"): _elements(
        ".//joint[@damping]", lambda joint: len(str(joint.get("damping")).split()) > 1, "damping"
    ),
    ("mjcf", "relations"): _elements("equality/joint"),
    ("mjcf", "sensors"): _elements("sensor/*"),
    ("mjcf", "spring-dampers"): _elements(".//joint[@springdamper]", attribute="springdamper"),
    ("mjcf", "starts of joints"): _elements(".//joint", _is_set("ref"), "ref"),
    ("mjcf", "time constants of servos"): _elements("actuator/position", _is_set("timeconst"), "timeconst"),
    ("mjcf", "words that MuJoCo 4.0 no longer has"): _words(REMOVED_WORDS["4.0"], "4.0", are_added=False),
    ("mjcf", "words of MuJoCo 3.16"): _words(ADDED_WORDS["3.16"], "3.16", are_added=True),
    ("mjcf", "words of MuJoCo 3.17"): _words(ADDED_WORDS["3.17"], "3.17", are_added=True),
    ("mjcf", "words of MuJoCo 4.0"): _words(ADDED_WORDS["4.0"], "4.0", are_added=True),
}
"""Format and thing → function that finds such elements of a document."""
