"""Moves attributes that elements of an MJCF have in common to default classes.

The classes are inside the robot's own class, and inherit its attributes. A class gets an attribute if each of
its elements has it, and most of them with the same value. The other elements keep their own value.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from linkwright.stages.export.mjcf.defaults.class_names import motor_of_joints, shared_name
from linkwright.stages.formats.xml import Element, element

NEVER_SHARED = ("name", "joint", "joint1", "joint2", "site1", "site2", "pos", "ref", "polycoef")
"""Attributes that are never shared: names, positions, and the numbers of a relation."""

JOINT_ATTRIBUTES = ("type", "damping", "frictionloss", "armature", "actuatorfrcrange")
"""Attributes of joints that depend on the joint's type and motor: joints with the same values form a
class."""

CONTACT_ATTRIBUTES = (
    "contype",
    "conaffinity",
    "condim",
    "friction",
    "solref",
    "solimp",
    "margin",
    "priority",
)
"""Attributes of contact: geoms with the same values form a class."""


def write_classes(root: Element, robot_class: Element, taken: set[str], motors: Mapping[str, str]) -> None:
    """Moves the common attributes of the elements of a model to classes. `robot_class`: the element of the
    robot's own class, which gets the classes; `taken`: the names of existing classes; `motors`: joint → its
    motor of the library.

    Joints of a type that all have the same attributes form a class with the name of the type. Other classes
    of joints are named after their motor or their joints.
    """
    world = root.find("worldbody")
    joints: dict[tuple[str | None, ...], list[Element]] = {}
    for joint in world.iter("joint"):
        joints.setdefault(tuple(joint.get(key) for key in JOINT_ATTRIBUTES), []).append(joint)
    group_counts = Counter(group[0].get("type") for group in joints.values())
    all_names = [joint.get("name") for joint in world.iter("joint")]
    for group in joints.values():
        kind, names = group[0].get("type"), [joint.get("name") for joint in group]
        specific_name = motor_of_joints(names, motors) or (
            shared_name(names, all_names) if group_counts[kind] > 1 else None
        )
        _write_class(robot_class, specific_name or kind, "joint", group, taken, JOINT_ATTRIBUTES)
    _write_contact_classes(
        robot_class, [geom for geom in world.iter("geom") if geom.get("class") == "collision"], taken
    )
    for section in ("equality", "actuator"):
        parent = root.find(section)
        kinds: dict[str, list[Element]] = {}
        for node in parent if parent is not None else ():
            kinds.setdefault(node.tag, []).append(node)
        if section == "equality" and kinds:
            # Connects, welds and relations share only their stiffness, in one class.
            nodes_of_section = [node for nodes in kinds.values() for node in nodes]
            _write_class(robot_class, "closure", section, nodes_of_section, taken)
        elif section == "actuator":
            for kind in sorted(kinds):
                _write_class(robot_class, kind, kind, kinds[kind], taken)


def _write_contact_classes(robot_class: Element, geoms: Sequence[Element], taken: set[str]) -> None:
    """Writes a class inside `collision` for each group of geoms with the same contact attributes."""
    groups: dict[tuple[tuple[str, str], ...], list[Element]] = {}
    for geom in geoms:
        attributes = tuple((key, geom.get(key)) for key in CONTACT_ATTRIBUTES if geom.get(key) is not None)
        if attributes:
            groups.setdefault(attributes, []).append(geom)
    collision = next(child for child in robot_class if child.get("class") == "collision")
    all_names = [geom.get("name") for geom in geoms]
    for attributes, group in groups.items():
        base_name = shared_name([geom.get("name") for geom in group], all_names, ignored=("collision",))
        name = _new_name(base_name or "collision", taken)
        element(element(collision, "default", class_=name), "geom", **dict(attributes))
        for geom in group:
            geom.set("class", name)
            for key, _ in attributes:
                del geom.attrib[key]


def _write_class(
    robot_class: Element,
    base_name: str,
    tag: str,
    elements: Sequence[Element],
    taken: set[str],
    always_shared: tuple[str, ...] = (),
) -> None:
    """Writes a class inside `robot_class` for elements of this tag, unless `_shared_attributes` finds
    nothing, and removes from the elements what they inherit from it."""
    shared = dict(_shared_attributes(elements, always_shared))
    if not shared:
        return
    name = _new_name(base_name, taken)
    element(element(robot_class, "default", class_=name), tag, **shared)
    for node in elements:
        for key, value in shared.items():
            if node.get(key) == value:
                del node.attrib[key]
        _set_class(node, name)


def _shared_attributes(
    elements: Sequence[Element], always_shared: tuple[str, ...]
) -> Iterator[tuple[str, str]]:
    """Yields (attribute, value) for a class. All elements must have the attribute, and more than half of
    them, at least two, the value; attributes in `always_shared` get their most common value in any case."""
    for key in elements[0].attrib:
        values = [node.get(key) for node in elements]
        if key in NEVER_SHARED or None in values:
            continue
        value, count = Counter(values).most_common(1)[0]
        if key in always_shared or (count > 1 and 2 * count > len(values)):
            yield key, value


def _set_class(node: Element, name: str) -> None:
    """Sets the class of an element, as its second attribute after the name."""
    attributes = dict(node.attrib)
    node.attrib.clear()
    own_name = attributes.pop("name", None)
    if own_name is not None:
        node.set("name", own_name)
    node.set("class", name)
    for key, value in attributes.items():
        node.set(key, value)


def _new_name(base_name: str, taken: set[str]) -> str:
    """Returns a new name, with a number if the base name is taken, and adds it to `taken`."""
    name, count = base_name, 1
    while name in taken:
        count += 1
        name = f"{base_name}_{count}"
    taken.add(name)
    return name
