"""Default classes of an MJCF: what elements of one kind have in common stands in one place.

A class is inside the robot's own, so it has what that has. An attribute is held by a class where each of its
elements has it, most of them with this value: what an element still says itself differs from its class.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

from linkwright.stages.export.mjcf.defaults.class_names import motor_of, named_after
from linkwright.stages.formats.xml import Element, element

OWN = ("name", "joint", "joint1", "joint2", "site1", "site2", "pos", "ref", "polycoef")
"""What is never shared: names, places, and a relation's own numbers."""

MOTOR = ("type", "damping", "frictionloss", "armature", "actuatorfrcrange")
"""What depends on the kind of a joint and on its motor: joints that say the same have a class."""

CONTACT = ("contype", "conaffinity", "condim", "friction", "solref", "solimp", "margin", "priority")
"""What a geom's contact depends on: those that say the same have a class."""


def write_classes(root: Element, robot: Element, taken: set[str], motors: Mapping[str, str]) -> None:
    """Gives the finished elements of a model their classes. `robot`: the element of the robot's own class, in
    which they go; `taken`: names of classes; `motors`: by joint, those of the library.

    The joints of one type are a class of its name where they all say the same. Else a class is named after
    its motor or its joints.
    """
    world = root.find("worldbody")
    joints: dict[tuple[str | None, ...], list[Element]] = {}
    for joint in world.iter("joint"):
        joints.setdefault(tuple(joint.get(key) for key in MOTOR), []).append(joint)
    types = Counter(same[0].get("type") for same in joints.values())
    every = [joint.get("name") for joint in world.iter("joint")]
    for same in joints.values():
        kind, names = same[0].get("type"), [joint.get("name") for joint in same]
        own = motor_of(names, motors) or (named_after(names, every) if types[kind] > 1 else None)
        _class(robot, own or kind, "joint", same, taken, MOTOR)
    _contacts(robot, [geom for geom in world.iter("geom") if geom.get("class") == "collision"], taken)
    for section in ("equality", "actuator"):
        above = root.find(section)
        kinds: dict[str, list[Element]] = {}
        for one in above if above is not None else ():
            kinds.setdefault(one.tag, []).append(one)
        if section == "equality" and kinds:
            # They share how stiff they are.
            _class(robot, "closure", section, [one for every in kinds.values() for one in every], taken)
        elif section == "actuator":
            for kind in sorted(kinds):
                _class(robot, kind, kind, kinds[kind], taken)


def _contacts(robot: Element, geoms: Sequence[Element], taken: set[str]) -> None:
    """A class inside `collision` for the geoms that say the same of their contacts."""
    groups: dict[tuple[tuple[str, str], ...], list[Element]] = {}
    for geom in geoms:
        told = tuple((key, geom.get(key)) for key in CONTACT if geom.get(key) is not None)
        if told:
            groups.setdefault(told, []).append(geom)
    collision = next(one for one in robot if one.get("class") == "collision")
    every = [geom.get("name") for geom in geoms]
    for told, same in groups.items():
        own = named_after([geom.get("name") for geom in same], every, dull=("collision",))
        name = _free(own or "collision", taken)
        element(element(collision, "default", class_=name), "geom", **dict(told))
        for geom in same:
            geom.set("class", name)
            for key, _ in told:
                del geom.attrib[key]


def _class(
    robot: Element,
    wanted: str,
    tag: str,
    elements: Sequence[Element],
    taken: set[str],
    always: tuple[str, ...] = (),
) -> None:
    """A class with what most of the elements say, for what all of them say something of."""
    held = dict(_held(elements, always))
    if not held:
        return
    name = _free(wanted, taken)
    element(element(robot, "default", class_=name), tag, **held)
    for one in elements:
        for key, value in held.items():
            if one.get(key) == value:
                del one.attrib[key]
        _set_class(one, name)


def _held(elements: Sequence[Element], always: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """The attributes of a class: the value of each that more than half of the elements have, two at least;
    of those that are `always` held whatever there is."""
    for key in elements[0].attrib:
        values = [one.get(key) for one in elements]
        if key in OWN or None in values:
            continue
        value, count = Counter(values).most_common(1)[0]
        if key in always or (count > 1 and 2 * count > len(values)):
            yield key, value


def _set_class(one: Element, name: str) -> None:
    """The class, after the name where there is one."""
    attributes = dict(one.attrib)
    one.attrib.clear()
    own = attributes.pop("name", None)
    if own is not None:
        one.set("name", own)
    one.set("class", name)
    for key, value in attributes.items():
        one.set(key, value)


def _free(wanted: str, taken: set[str]) -> str:
    """The name, or with the first number that makes it a new one."""
    name, number = wanted, 1
    while name in taken:
        number += 1
        name = f"{wanted}_{number}"
    taken.add(name)
    return name
