"""Faults of a build's MJCF: joints, bodies, inertials, geoms, meshes and names."""

from pathlib import Path

from lxml import etree

from tests.support.faults.edits import (
    all_of,
    at,
    broken,
    draw,
    drop,
    moved,
    named,
    numbers,
    of,
    pick,
    put,
    remove,
    times,
    turned_round,
    write,
)
from tests.support.faults.fault import NothingToChange, table
from tests.support.faults.urdf import renamed, same_name

JOINT = "//body/joint[@name]"
AXLE = f"{JOINT}[not(@type='ball')]"
MOVING = "//worldbody/body//body[joint]"
INERTIAL = "//body/inertial"
COLLIDER = "//body/geom[contains(@class, 'collision')]"
VISUAL = "//body/geom[contains(@class, 'visual')]"


def body(node):
    return named("body", node.getparent())


def of_geom(geom):
    """A geom by its name, its body and its mesh; without a name, by the last two."""
    name = named("geom", geom) if geom.get("name") else body(geom)
    return name, body(geom), f'geom mesh "{geom.get("mesh")}"'


def beside_its_axis(joint, rng):
    axis, place = numbers(joint, "axis", "0 0 1"), [0.0, 0.0, 0.0]
    place[min(range(3), key=lambda at: abs(axis[at]))] = 0.001
    write(joint, "pos", place)


def degrees(compiler, rng):
    compiler.set("angle", "degree")
    turning = compiler.xpath("//body/joint[@range][not(contains(@class, 'slide'))]")
    return tuple(named("joint", joint) for joint in turning)


def another_type(joint, rng):
    sliding = "slide" in (joint.get("type") or "") + (joint.get("class") or "")
    joint.set("type", "hinge" if sliding else "slide")


def on_its_grandparent(node, rng):
    node.getparent().getparent().append(node)


def joint_added(body, rng):
    etree.SubElement(body, "joint", name="more", type="slide")
    for key in body.xpath("//key[@qpos]"):
        key.set("qpos", key.get("qpos") + " 0")


def renamed_with_references(joint, rng):
    for key in ("joint", "joint1", "joint2"):
        for node in joint.xpath(f"//*[@{key} = $name]", name=joint.get("name")):
            node.set(key, node.get(key) + "_old")
    renamed(joint, rng)


def is_turned(inertial):
    return 0.01 < abs(numbers(inertial, "quat")[0]) < 0.99


BODIES = table(
    "mjcf",
    ("axis flipped", at(AXLE, of("axis", turned_round, "0 0 1")), "C-MOTION: axis", "reversed axis"),
    ("axis swapped", at(AXLE, of("axis", lambda v, _: (v[2], v[0], v[1]), "0 0 1")), "C-MOTION: axis"),
    ("joint's place 1 mm off", at(f"{JOINT}[not(contains(@class, 'slide'))]", beside_its_axis),
     "C-MOTION: pos"),
    ("range widened",
     at(f"{JOINT}[@range]", of("range", lambda v, rng: (v[0] - rng.uniform(0.001, 0.3), v[1]))),
     "C-JOINT: range"),
    ("range swapped", at(f"{JOINT}[@range]", of("range", lambda v, _: v[::-1])), "C-JOINT C-COMPILE: range",
     "swapped limits"),
    ("range removed", at(f"{JOINT}[@range]", drop("range")), "C-JOINT: range"),
    ("angles read as degrees", all_of("compiler", degrees), "C-JOINT: range"),
    ("damping negative", at(JOINT, put(damping="-0.5")), "C-JOINT C-COMPILE: damping"),
    ("damping changed", at(JOINT, put(damping=draw(2, 5))), "C-JOINT: damping"),
    ("friction changed", at(JOINT, put(frictionloss=draw(2, 5))), "C-JOINT: frictionloss"),
    ("armature changed", at(JOINT, put(armature=draw(0.1, 1))), "C-JOINT: armature"),
    ("effort changed", at(AXLE, put(actuatorfrcrange="-1234 1234")), "C-JOINT: actuatorfrcrange"),
    ("effort without limit", at(AXLE, put(actuatorfrclimited="false")), "C-JOINT: actuatorfrcrange"),
    ("spring in a joint", at(JOINT, put(stiffness=draw(0.1, 10))), "C-JOINT: stiffness"),
    ("limit soft", at(JOINT, of("solreflimit", lambda _, rng: (rng.uniform(0.1, 1), 1.0))),
     "C-JOINT: solreflimit"),
    ("limit begins early", at(JOINT, put(margin=draw(0.01, 0.3))), "C-JOINT: margin"),
    ("weight of a body taken off", at(MOVING, put(gravcomp="1")), "C-ACTUATOR: gravcomp"),
    ("joint type changed", at(AXLE, another_type), "C-JOINT: type"),
    ("body 1 mm off", at(MOVING, moved("pos", 0.001)), "C-MOTION: pos"),
    ("quaternion with its real part last",
     at("//worldbody/body//body[@quat][joint]", of("quat", lambda v, _: (*v[1:], v[0]))), "C-MOTION: quat"),
    ("joint added", all_of("(//worldbody//body)[last()]", joint_added, 'joint "more"'),
     "C-LINKS C-COMPILE: type | name"),
    ("joint renamed", at(JOINT, renamed_with_references), "C-LINKS: name"),
    ("body on another body", at("//worldbody/body//body/body[joint]", on_its_grandparent),
     "C-MOTION: parent | pos"),
    ("mass 1 % off", at(INERTIAL, times("mass", 0.99, 1.01)), "C-MASS: inertial mass"),
    ("mass in grams", at(INERTIAL, times("mass", 1000)), "C-MASS: inertial mass", "grams as kilograms"),
    ("inertial removed", at(INERTIAL, remove), "C-MASS C-COMPILE: inertial", "no inertial"),
    ("centre of mass 2 mm off", at(INERTIAL, moved("pos", 0.002)), "C-MASS: inertial pos"),
    ("axes of inertia turned the other way",
     at(f"{INERTIAL}[@quat]", of("quat", lambda v, _: (v[0], *(-x for x in v[1:]))), where=is_turned),
     "C-MASS: inertial quat | inertial diaginertia"),
    ("inertia 5 % off", at(f"{INERTIAL}[@diaginertia]", times("diaginertia", 1.05)),
     "C-MASS: inertial diaginertia"),
    ("inertia in kg mm²", at(f"{INERTIAL}[@diaginertia]", times("diaginertia", 1e6, digits=15)),
     "C-MASS: inertial diaginertia"),
)  # fmt: skip

CONTACT = {
    "friction": "0 0 0",
    "condim": "1",
    "solref": "0.2 1",
    "solimp": "0.1 0.2 0.01",
    "priority": "3",
    "margin": "0.02",
    "gap": "0.01",
}
"""Attributes of a collider's contact, and other values than any robot here has."""


def added_before(geom, rng):
    geom.addprevious(etree.Element("geom", name="bumper", type="sphere", size="0.01"))
    return 'geom "bumper"'


def added_after(geom, rng):
    etree.SubElement(geom.getparent(), "geom", name="bumper", type="box", size="0.01 0.01 0.01")
    return 'geom "bumper"'


def contact_of(root):
    contact = root.find("contact")
    return etree.SubElement(root, "contact") if contact is None else contact


def few_points(geom, rng):
    stem = geom.get("mesh")
    (mesh,) = (file for file in geom.xpath("//asset/mesh[@file]") if Path(file.get("file")).stem == stem)
    mesh.set("maxhullvert", "5")
    return f'mesh "{stem}"'


def pair_of_colliders(files, rng):
    first, second = rng.sample(list(files.root.xpath(f"{COLLIDER}/@name")), 2)
    etree.SubElement(contact_of(files.root), "pair", geom1=first, geom2=second)
    return f'geom "{first}"', f'geom "{second}"'


def of_another_part(files, rng):
    geom = pick(files.root.xpath("//body/geom[@mesh][contains(@class, 'visual')]"), rng)
    sizes = {path.stem: path.stat().st_size for path in (files.folder / "assets").glob("*.stl")}
    every = set(map(str, files.root.xpath(f"{VISUAL}/@mesh")))
    meshes = sorted(mesh for mesh in every if sizes.get(mesh) != sizes.get(geom.get("mesh")))
    if not meshes:
        raise NothingToChange
    geom.set("mesh", rng.choice(meshes))
    return of_geom(geom)


def in_millimetres(mesh, rng):
    mesh.set("scale", "1000 1000 1000")
    stem = mesh.get("name") or Path(mesh.get("file")).stem
    geoms = mesh.xpath("//body/geom[@mesh = $stem]", stem=stem)
    return f'mesh "{stem}"', *(name for geom in geoms for name in of_geom(geom))


SHAPES = table(
    "mjcf",
    ("collider gone", at(COLLIDER, remove, names=body), "C-SHAPE: geom", "missing collision"),
    ("collider collides with nothing", at(COLLIDER, put(contype="0", conaffinity="0"), names=body),
     "C-SHAPE: geom"),
    ("collider moved", at(COLLIDER, moved("pos", 0.001, 0.1), names=of_geom),
     "C-SHAPE: pos", "offset collision"),
    ("collider resized", at(f"{COLLIDER}[@size]", times("size", 1.1, digits=15), names=of_geom),
     "C-SHAPE: size"),
    ("collider added before the others", at(COLLIDER, added_before, names=body), "C-SHAPE: geom"),
    ("collider added after the others", at(COLLIDER, added_after, names=body), "C-SHAPE: geom"),
    *((f"collider's {key}", at(COLLIDER, put(**{key: value}), names=of_geom), f"C-CONTACT: {key}")
      for key, value in CONTACT.items()),
    ("friction of all colliders",
     all_of(".//default[@class='collision']/geom", put(friction="0 0 0"), "geom"),
     "C-CONTACT: friction"),
    ("hull of few points", at(f"{COLLIDER}[@mesh]", few_points, names=body), "C-CONTACT: maxhullvert"),
    ("pair of colliders", pair_of_colliders, "C-EXCLUDE: geom1"),
    ("visual moved", at(VISUAL, moved("pos", 0.001, 0.1), names=of_geom), "C-SHAPE: pos"),
    ("mesh of another part", of_another_part, "C-SHAPE: mesh | pos"),
    ("mesh scaled to millimetres", at("//asset/mesh[@file]", in_millimetres, names=str),
     "C-SHAPE: mesh | scale",
     "millimetre units"),
    ("name given twice", same_name(JOINT), "C-NAME C-COMPILE: name"),
    ("body renamed", at("//body[not(@name = //@body1 | //@body2 | //@objname | //@refname)]", renamed),
     "C-LINKS: name"),
    ("XML broken", broken, "C-XML C-COMPILE: "),
)  # fmt: skip
