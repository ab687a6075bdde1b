"""XML that a user adds: the language that it is of, and what has a name in a MJCF or URDF."""

from collections.abc import Iterable, Iterator

from linkwright.stages.formats.xml import Element

_SECTIONS = """
actuator asset compiler contact custom default deformable equality extension keyframe option sensor
size statistic tendon visual worldbody
"""

_INSIDE = """
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

_URDF = """
axis calibration capsule child collision color contact_coefficients drake:compliant_hydroelastic
dynamics gazebo geometry group_state inertial joint limit link material mimic mujoco origin parent
ros2_control safety_controller sensor texture transmission verbose visual
"""

SECTIONS = frozenset(_SECTIONS.split())
"""The elements below the root of an MJCF."""

MJCF = SECTIONS | frozenset(_INSIDE.split())
"""Every element of an MJCF (MuJoCo's XML reference; those of all versions that are supported)."""

URDF = frozenset(_URDF.split())
"""Elements of a URDF, and of what is often in one, that may be on top of an addition to it."""

_MANY = ("actuator", "sensor", "tendon", "equality")
"""Sections of an MJCF of whose elements no two have the same name, whatever their tags."""


def language_of(elements: Iterable[Element]) -> str | None:
    """ "mjcf" where MuJoCo knows every element, else "urdf"; None for what is in neither."""
    every = list(elements)
    if all(str(one.tag) in MJCF for element in every for one in element.iter()):
        return "mjcf"
    known = all(str(one.tag) in URDF or one.prefix or ":" in str(one.tag) for one in every)
    return "urdf" if known else None


def unknown_tag(elements: Iterable[Element]) -> str:
    """The first of the elements that are neither of MJCF nor of URDF, or what is in it; "" for none."""
    every = [str(one.tag) for one in elements]
    return next((tag for tag in every if tag not in MJCF | URDF), "")


def name_of(element: Element) -> str | None:
    """The name of an element; of a class of an MJCF, that of the class."""
    name: str | None = element.get("class" if element.tag == "default" else "name")
    return name


def kind_of(element: Element) -> str:
    """What an element is among those of which no two have the same name."""
    section = section_of(element)
    above = element.getparent()
    if section in _MANY and above is not None and above.tag == section:
        return str(section)
    return "joint" if element.tag == "freejoint" else str(element.tag)


def section_of(element: Element) -> str:
    """The element below the root that an element is in, or is."""
    way = [str(one.tag) for one in (element, *element.iterancestors())]
    return way[-2] if len(way) > 1 else ""


def names(root: Element, urdf: bool) -> Iterator[tuple[str, str, Element]]:
    """(kind, name, element) of all in a document that has a name which must be unique. In a URDF these are
    links and joints: a material is named wherever it is used."""
    for one in root.iterchildren() if urdf else root.iter():
        name = name_of(one)
        if name and one is not root and not (urdf and one.tag not in ("link", "joint")):
            yield kind_of(one), name, one
