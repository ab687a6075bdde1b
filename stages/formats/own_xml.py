"""Recognizes XML that a user adds: its language, and the named elements of an MJCF or URDF."""

from collections.abc import Iterable, Iterator

from linkwright.stages.formats.xml import Element

_SECTION_TEXT = """
actuator asset compiler contact custom default deformable equality extension keyframe option sensor
size statistic tendon visual worldbody
"""

_INNER_TEXT = """
accelerometer actuatorfrc actuatorpos actuatorvel adhesion attach ballangvel ballquat body bone
camera camprojection clock composite config connect cylinder damper dcmotor distance e_kinetic
e_potential edge elasticity element exclude fixed flag flex flexcomp flexstrain force frame
frameangacc frameangvel framelinacc framelinvel framepos framequat framexaxis frameyaxis framezaxis
freejoint fromto general geom global gyro headlight hfield include inertial insidesite instance
intvelocity joint jointactuatorfrc jointlimitfrc jointlimitpos jointlimitvel jointpos jointvel key
layer lengthrange light magnetometer map material mesh model motor mujoco muscle normal numeric
orientation pair pid pin plugin position pulley quality rangefinder replicate rgba scale site skin
spatial subtreeangmom subtreecom subtreelinvel tactile tendonactuatorfrc tendonlimitfrc
tendonlimitpos tendonlimitvel tendonpos tendonvel text texture torque touch tuple user velocimeter
velocity weld
"""

_URDF_TEXT = """
axis calibration capsule child collision color contact_coefficients drake:compliant_hydroelastic
dynamics gazebo geometry group_state inertial joint limit link material mimic mujoco origin parent
ros2_control safety_controller sensor texture transmission verbose visual
"""

SECTION_TAGS = frozenset(_SECTION_TEXT.split())
"""The elements below the root of an MJCF."""

MJCF_TAGS = SECTION_TAGS | frozenset(_INNER_TEXT.split())
"""Every element of an MJCF (MuJoCo's XML reference), of all versions that are supported."""

URDF_TAGS = frozenset(_URDF_TEXT.split())
"""Elements of a URDF, and of its usual extensions, that may be at the top of an addition to it."""

_SHARED_NAMESPACES = ("actuator", "sensor", "tendon", "equality")
"""Sections of an MJCF whose elements have unique names, whatever their tags."""


def language_of(elements: Iterable[Element]) -> str | None:
    """Returns the language of elements: "mjcf" if MuJoCo knows them and all in them, otherwise "urdf" if a
    URDF or an extension of it has them; None for neither. An element with a prefix counts as an extension."""
    tops = list(elements)
    if all(str(node.tag) in MJCF_TAGS for element in tops for node in element.iter()):
        return "mjcf"
    is_urdf = all(str(node.tag) in URDF_TAGS or node.prefix or ":" in str(node.tag) for node in tops)
    return "urdf" if is_urdf else None


def unknown_tag(elements: Iterable[Element]) -> str:
    """Returns the tag of the first element that is neither of MJCF nor of URDF, or ""."""
    tags = [str(node.tag) for node in elements]
    return next((tag for tag in tags if tag not in MJCF_TAGS | URDF_TAGS), "")


def name_of(element: Element) -> str | None:
    """Returns the name of an element; for a class of an MJCF, the name of the class."""
    name: str | None = element.get("class" if element.tag == "default" else "name")
    return name


def kind_of(element: Element) -> str:
    """Returns the kind of an element, among whose elements names are unique: its section for actuators,
    sensors, tendons and equalities, otherwise its tag; a freejoint is a joint."""
    section = section_of(element)
    above = element.getparent()
    if section in _SHARED_NAMESPACES and above is not None and above.tag == section:
        return str(section)
    return "joint" if element.tag == "freejoint" else str(element.tag)


def section_of(element: Element) -> str:
    """Returns the tag of the element below the root that contains an element or is the element; "" for the
    root."""
    tags = [str(node.tag) for node in (element, *element.iterancestors())]
    return tags[-2] if len(tags) > 1 else ""


def named_elements(root: Element, urdf: bool) -> Iterator[tuple[str, str, Element]]:
    """Yields (kind, name, element) of all elements of a document whose names must be unique.

    In a URDF these are links and joints: a material is named wherever it is used.
    """
    for node in root.iterchildren() if urdf else root.iter():
        name = name_of(node)
        if name and node is not root and (not urdf or node.tag in ("link", "joint")):
            yield kind_of(node), name, node
