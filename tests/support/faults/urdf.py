"""Faults of a build's URDF."""

import re

from lxml import etree

from tests.support.faults.edits import (
    all_of,
    at,
    broken,
    draw,
    drop,
    holder,
    moved,
    numbers,
    of,
    pick,
    put,
    remove,
    swapped,
    times,
    turned_round,
    write,
)
from tests.support.faults.fault import NothingToChange, Planted, table

MOVING = "//joint[@type='revolute' or @type='continuous' or @type='prismatic']"
ORIGIN, LIMIT = f"{MOVING}/origin", f"{MOVING}/limit"
FREE = f"{MOVING}[not(@name = //mimic/@joint)]"
"""A joint that no other follows."""
SEEN_MESH = "//link/visual/geometry/mesh"


def inertial(part, *changes):
    """Changes a part of the <inertial> of a link whose mass is more than a speck."""
    mass = "mass" if part == "." else "../mass"
    return at(
        f"link/inertial/{part}", *changes, where=lambda node: float(node.find(mass).get("value")) > 1e-9
    )


def resized(factor):
    """Distances between all joints that are so many times as long."""

    def plant(files, rng):
        names = []
        for origin in files.root.xpath(ORIGIN):
            values = numbers(origin, "xyz")
            write(origin, "xyz", [factor * value for value in values])
            names += [holder(origin)] if max(map(abs, values)) > 1e-4 else []
        if not names:
            raise NothingToChange
        return tuple(names)

    return plant


def is_away(origin):
    return max(map(abs, numbers(origin, "xyz"))) > 1e-3


def is_turned(origin):
    return any(0.01 < abs(angle) < 3.13 for angle in numbers(origin, "rpy"))


def on_its_grandparent(parent, rng):
    (above,) = parent.xpath(f"//joint[child/@link = '{parent.get('link')}']/parent/@link")
    parent.set("link", above)


def in_degrees(limit, rng):
    for key in ("lower", "upper"):
        times(key, 57.29577951, digits=9)(limit, rng)


def another_type(joint, rng):
    joint.set("type", {"revolute": "prismatic", "prismatic": "revolute"}[joint.get("type")])


def each(factor):
    """Multiplies all attributes by a factor."""

    def change(node, rng):
        for key in node.attrib:
            node.set(key, f"{float(node.get(key)) * factor:.12g}" if factor else "0")

    return change


def against_the_triangle(tensor, rng):
    tensor.set("izz", f"{3 * (float(tensor.get('ixx')) + float(tensor.get('iyy'))):.12g}")


def product_turned_round(files, rng):
    skew = [
        (tensor, key)
        for tensor in files.root.iterfind("link/inertial/inertia")
        for key in ("ixy", "ixz", "iyz")
        if abs(float(tensor.get(key))) > 1e-4 * float(tensor.get("ixx")) > 0
    ]
    if not skew:
        raise NothingToChange
    tensor, key = rng.choice(skew)
    times(key, -1)(tensor, rng)
    return Planted((holder(tensor),), (f"inertia {key}",))


def is_frame(joint):
    """Whether the link of a fixed joint is empty, and no frame of a loop."""
    (link,) = joint.xpath("//link[@name = $name]", name=joint.find("child").get("link"))
    return len(link) == 0 and not re.search("_[ab]$", link.get("name"))


def colliders_gone(link, rng):
    for collision in link.findall("collision"):
        link.remove(collision)


def resized_solid(solid, rng):
    times("size" if solid.get("size") else "radius", 1.1, digits=15)(solid, rng)


def of_another_part(files, rng):
    mesh = pick(files.root.xpath(SEEN_MESH), rng)
    data = (files.folder / mesh.get("filename")).read_bytes()
    every = {node.get("filename") for node in files.root.iter("mesh")}
    meshes = sorted(name for name in every if (files.folder / name).read_bytes() != data)
    if not meshes:
        raise NothingToChange
    mesh.set("filename", rng.choice(meshes))
    return holder(mesh)


def lost(mesh, rng):
    mesh.set("filename", mesh.get("filename").replace("assets/", "assets/lost_"))
    return "mesh", holder(mesh)


def same_name(path):
    """Gives the name of one element to another."""

    def plant(files, rng):
        first, second = rng.sample(files.root.xpath(path), 2)
        was = holder(second)
        second.set("name", first.get("name"))
        return holder(first), was

    return plant


def renamed(node, rng):
    node.set("name", node.get("name") + "_old")


def unknown_joint(robot, rng):
    etree.SubElement(etree.SubElement(robot, "transmission", name="gearbox"), "joint", name="no_such_joint")


def unknown_package(mesh, rng):
    mesh.set("filename", "package://no_such_package/" + mesh.get("filename"))
    return "mesh of"


JOINTS = table(
    "urdf",
    ("axis flipped", at(f"{MOVING}/axis", of("xyz", turned_round)), "C-MOTION: axis", "reversed axis"),
    ("axis swapped", at(f"{MOVING}/axis", of("xyz", lambda v, _: (v[2], v[0], v[1]))), "C-MOTION: axis"),
    ("axis zero", at(f"{MOVING}/axis", put(xyz="0 0 0")),
     "C-COMPILE C-XML C-NUMBER C-REFERENCE C-AXIS: axis", "zero axis"),
    ("limits swapped", at(f"{LIMIT}[@lower]", swapped("lower", "upper")), "C-JOINT: limit", "swapped limits"),
    ("limits widened",
     at(f"{LIMIT}[@upper]", of("upper", lambda v, rng: [v[0] + rng.uniform(0.001, 0.5)], "", 9)),
     "C-JOINT: limit upper"),
    ("limits removed", at(f"{LIMIT}[@lower]", drop("lower", "upper")), "C-JOINT: limit"),
    ("limits in degrees", at("//joint[@type='revolute']/limit[@lower]", in_degrees),
     "C-JOINT: limit", "limits in degrees"),
    ("effort changed", at(f"{LIMIT}[@effort]", times("effort", 0.5, 0.99, 10, digits=9)), "C-JOINT: effort"),
    ("velocity changed", at(f"{LIMIT}[@velocity]", times("velocity", 1.5, digits=9)), "C-JOINT: velocity"),
    ("damping negative", at(f"{MOVING}/dynamics", put(damping=draw(-1, -0.01))),
     "C-JOINT C-COMPILE: damping"),
    ("damping changed", at(f"{MOVING}/dynamics[@damping]", times("damping", 0.5, 2)), "C-JOINT: damping"),
    ("joint type changed", at(f"{MOVING}[@type!='continuous']", another_type), "C-JOINT: type"),
    ("joint fixed", at(f"{FREE}[not(mimic)]", put(type="fixed")), "C-LINKS: name | type"),
    ("joint origin 1 mm off", at(ORIGIN, moved("xyz", 0.001)), "C-MOTION: origin xyz"),
    ("joint origin turned the other way", at(ORIGIN, of("rpy", turned_round), where=is_turned),
     "C-MOTION: origin rpy"),
    ("all joints in millimetres", resized(1000.0), "C-MOTION: origin xyz", "millimetre units"),
    ("all joints far too near", resized(0.01), "C-MOTION: origin xyz", "too small"),
    ("joint within its parent", at(ORIGIN, put(xyz="0 0 0"), where=is_away),
     "C-MOTION: origin xyz", "joint inside its parent"),
    ("parent swapped", at(f"{MOVING}/parent[@link = //joint/child/@link]", on_its_grandparent),
     "C-MOTION: parent | origin"),
)  # fmt: skip

LINKS = table(
    "urdf",
    ("mass 1 % off", inertial("mass", times("value", 0.99, 1.01)), "C-MASS: inertial mass"),
    ("mass in grams", inertial("mass", times("value", 1000)), "C-MASS: inertial mass", "grams as kilograms"),
    ("mass zero", inertial("mass", put(value="0")), "C-MASS C-COMPILE: mass", "zero mass"),
    ("inertial removed", inertial(".", remove), "C-MASS C-COMPILE: inertial", "no inertial"),
    ("centre of mass 2 mm off", inertial("origin", moved("xyz", 0.002)), "C-MASS: inertial origin"),
    ("centre of mass outside the part", inertial("origin", moved("xyz", 0.5, 2)), "C-MASS: inertial origin",
     "centre of mass off the part"),
    ("inertia's off-diagonal sign", product_turned_round, "C-MASS: inertia"),
    ("inertia in kg mm²", inertial("inertia", each(1e6)), "C-MASS: inertia"),
    ("inertia zero", inertial("inertia", each(0)), "C-MASS C-COMPILE: inertia", "zero inertia"),
    ("inertia against the triangle inequality", inertial("inertia", against_the_triangle),
     "C-COMPILE C-MASS C-INERTIA: inertia", "inertia against the triangle inequality"),
    ("inertia negative", inertial("inertia", times("ixx", -1)), "C-COMPILE C-MASS C-INERTIA: inertia",
     "negative inertia"),
    ("mimic's sign", at("//mimic", times("multiplier", -1, default="1")), "C-RELATION: mimic multiplier"),
    ("mimic's offset", at("//mimic", of("offset", lambda v, rng: [v[0] + rng.uniform(0.01, 0.2)], "0", 9)),
     "C-RELATION: mimic offset"),
    ("mimic removed", at("//mimic", remove), "C-RELATION: mimic"),
    ("frame moved", at("//joint[@type='fixed']/origin", moved("xyz", 0.001),
                       where=lambda node: is_frame(node.getparent())), "C-MOTION: origin xyz"),
    ("collider gone", at("//link/collision[geometry]", remove),
     "C-SHAPE: collision | geom", "missing collision"),
    ("colliders of a link gone",
     at("//link/collision[geometry]", lambda node, rng: colliders_gone(node.getparent(), rng)),
     "C-SHAPE: collision | geom", "missing collision"),
    ("collider moved", at("//link/collision/origin", moved("xyz", 0.001, 0.1)), "C-SHAPE: origin | pos",
     "offset collision"),
    ("collider resized",
     at("//link/collision/geometry/*[self::box or self::cylinder or self::sphere]", resized_solid),
     "C-SHAPE: size"),
    ("visual moved", at("//link/visual/origin", moved("xyz", 0.001, 0.1)), "C-SHAPE: origin | pos"),
    ("mesh scaled to millimetres", at(SEEN_MESH, put(scale="1000 1000 1000")), "C-SHAPE: mesh | scale",
     "millimetre units"),
    ("mesh far too small", at(SEEN_MESH, put(scale="0.01 0.01 0.01")), "C-SHAPE C-COMPILE: mesh | scale",
     "too small"),
    ("mesh of another part", of_another_part, "C-SHAPE: mesh | filename"),
    ("mesh of an unknown package", at("//mesh[@filename]", unknown_package), "C-PATH: filename"),
    ("transmission of an unknown joint", all_of("/robot", unknown_joint, "joint"), "C-REFERENCE: name"),
    ("robot renamed", all_of("/robot", put(name="another"), "robot"), "C-LINKS: name"),
    ("mesh path broken", at("//mesh", lost), "C-ASSET C-COMPILE: filename", "broken mesh path"),
    ("name given twice", same_name(MOVING), "C-NAME C-COMPILE C-LINKS: name"),
    ("joint renamed", at(FREE, renamed), "C-LINKS: name"),
    ("XML broken", broken, "C-XML C-COMPILE: "),
)  # fmt: skip

FAULTS = [*JOINTS, *LINKS]
