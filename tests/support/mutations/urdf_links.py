"""Faults of a URDF's links, shapes and names."""

import random
import re
from pathlib import Path

from lxml import etree

from tests.support.mutations.edits import moved, named, numbers, pick, put
from tests.support.mutations.kind import Element, Files, Kinds, NothingToChange, Planted
from tests.support.mutations.urdf_joints import MOVING, inertial

KINDS = Kinds("urdf")


@KINDS.add("mass 1 % off", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    mass = one.find("mass")
    mass.set("value", f"{float(mass.get('value')) * rng.choice((0.99, 1.01)):.12g}")
    return Planted(named("link", one.getparent()), ("inertial mass",))


@KINDS.add("mass in grams", "C-MASS", simcheck="grams as kilograms")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    mass = one.find("mass")
    mass.set("value", f"{float(mass.get('value')) * 1000:.12g}")
    return Planted(named("link", one.getparent()), ("inertial mass",))


@KINDS.add("mass zero", "C-MASS", "C-COMPILE", simcheck="zero mass")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    one.find("mass").set("value", "0")
    return Planted(named("link", one.getparent()), ("mass",))


@KINDS.add("inertial removed", "C-MASS", "C-COMPILE", simcheck="no inertial")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    link = one.getparent()
    link.remove(one)
    return Planted(named("link", link), ("inertial",))


@KINDS.add("centre of mass 2 mm off", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    moved(one.find("origin"), "xyz", rng, 0.002)
    return Planted(named("link", one.getparent()), ("inertial origin",))


@KINDS.add("centre of mass outside the part", "C-MASS", simcheck="centre of mass off the part")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.5, 2))
    return Planted(named("link", one.getparent()), ("inertial origin",))


@KINDS.add("inertia's off-diagonal sign", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    skew = [
        (one, key)
        for one in files.urdf.iterfind("link/inertial")
        for key in ("ixy", "ixz", "iyz")
        if abs(float(one.find("inertia").get(key))) > 1e-4 * float(one.find("inertia").get("ixx")) > 0
    ]
    if not skew:
        raise NothingToChange
    one, key = rng.choice(skew)
    one.find("inertia").set(key, f"{-float(one.find('inertia').get(key)):.12g}")
    return Planted(named("link", one.getparent()), (f"inertia {key}",))


@KINDS.add("inertia in kg mm²", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    for key, value in one.find("inertia").attrib.items():
        one.find("inertia").set(key, f"{float(value) * 1e6:.12g}")
    return Planted(named("link", one.getparent()), ("inertia",))


@KINDS.add("inertia zero", "C-MASS", "C-COMPILE", simcheck="zero inertia")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    for key in one.find("inertia").attrib:
        one.find("inertia").set(key, "0")
    return Planted(named("link", one.getparent()), ("inertia",))


@KINDS.add(
    "inertia against the triangle inequality",
    "C-COMPILE",
    "C-MASS",
    "C-INERTIA",
    simcheck="inertia against the triangle inequality",
)
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    tensor = one.find("inertia")
    tensor.set("izz", f"{3 * (float(tensor.get('ixx')) + float(tensor.get('iyy'))):.12g}")
    return Planted(named("link", one.getparent()), ("inertia",))


@KINDS.add("inertia negative", "C-COMPILE", "C-MASS", "C-INERTIA", simcheck="negative inertia")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    tensor = one.find("inertia")
    tensor.set("ixx", f"{-float(tensor.get('ixx')):.12g}")
    return Planted(named("link", one.getparent()), ("inertia",))


@KINDS.add("mimic's sign", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    mimic.set("multiplier", f"{-float(mimic.get('multiplier', '1')):.12g}")
    return Planted(named("joint", mimic.getparent()), ("mimic multiplier",))


@KINDS.add("mimic's offset", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    mimic.set("offset", f"{float(mimic.get('offset', '0')) + rng.uniform(0.01, 0.2):.9g}")
    return Planted(named("joint", mimic.getparent()), ("mimic offset",))


@KINDS.add("mimic removed", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    joint = mimic.getparent()
    joint.remove(mimic)
    return Planted(named("joint", joint), ("mimic",))


@KINDS.add("frame moved", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    bare = {one.get("name") for one in files.urdf.iter("link") if len(one) == 0}
    ends = [
        one
        for one in files.urdf.xpath("//joint[@type='fixed']")
        if one.find("child").get("link") in bare and not re.search("_[ab]$", one.find("child").get("link"))
    ]
    joint = pick(ends, rng)
    moved(joint.find("origin"), "xyz", rng, 0.001)
    return Planted(named("joint", joint), ("origin xyz",))


def shape(files: Files, rng: random.Random, role: str, condition: str) -> tuple[Element, Element]:
    """A shape of a URDF's link, and the link."""
    one = pick(files.urdf.xpath(f"//link/{role}[{condition}]"), rng)
    return one, one.getparent()


@KINDS.add("collider gone", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "geometry")
    link.remove(one)
    return Planted(named("link", link), ("collision", "geom"))


@KINDS.add("colliders of a link gone", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    _, link = shape(files, rng, "collision", "geometry")
    for one in link.findall("collision"):
        link.remove(one)
    return Planted(named("link", link), ("collision", "geom"))


@KINDS.add("collider moved", "C-SHAPE", simcheck="offset collision")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "origin")
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.001, 0.1))
    return Planted(named("link", link), ("origin", "pos"))


@KINDS.add("collider resized", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "geometry/box or geometry/cylinder or geometry/sphere")
    solid = one.find("geometry")[0]
    key = next(name for name in ("size", "radius") if solid.get(name))
    put(solid, key, [1.1 * value for value in numbers(solid, key)])
    return Planted(named("link", link), ("size",))


@KINDS.add("visual moved", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "origin")
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.001, 0.1))
    return Planted(named("link", link), ("origin", "pos"))


@KINDS.add("mesh scaled to millimetres", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "geometry/mesh")
    one.find("geometry/mesh").set("scale", "1000 1000 1000")
    return Planted(named("link", link), ("mesh", "scale"))


@KINDS.add("mesh far too small", "C-SHAPE", "C-COMPILE", simcheck="too small")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "geometry/mesh")
    one.find("geometry/mesh").set("scale", "0.01 0.01 0.01")
    return Planted(named("link", link), ("mesh", "scale"))


@KINDS.add("mesh of another part", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "geometry/mesh")
    mesh = one.find("geometry/mesh")
    own = (files.folder / mesh.get("filename")).read_bytes()
    every = {node.get("filename") for node in files.urdf.iter("mesh")}
    others = sorted(name for name in every if (files.folder / name).read_bytes() != own)
    if not others:
        raise NothingToChange
    mesh.set("filename", rng.choice(others))
    return Planted(named("link", link), ("mesh", "filename"))


@KINDS.add("mesh of an unknown package", "C-PATH")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = pick(files.urdf.xpath("//mesh[@filename]"), rng)
    mesh.set("filename", "package://no_such_package/" + mesh.get("filename"))
    return Planted("mesh of", ("filename",))


@KINDS.add("transmission of an unknown joint", "C-REFERENCE")
def _(files: Files, rng: random.Random) -> Planted:
    one = etree.SubElement(files.urdf, "transmission", name="gearbox")
    etree.SubElement(one, "joint", name="no_such_joint")
    return Planted("joint", ("name",))


@KINDS.add("robot renamed", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    files.urdf.set("name", "another")
    return Planted("robot", ("name",))


@KINDS.add("mesh path broken", "C-ASSET", "C-COMPILE", simcheck="broken mesh path")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = pick(files.urdf.xpath("//mesh"), rng)
    mesh.set("filename", mesh.get("filename").replace("assets/", "assets/lost_"))
    link = next(one for one in mesh.iterancestors("link"))
    return Planted("mesh", ("filename",), (named("link", link),))


@KINDS.add("name given twice", "C-NAME", "C-COMPILE", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample(files.urdf.xpath(f"//{MOVING}"), 2)
    was = named("joint", second)
    second.set("name", first.get("name"))
    return Planted(named("joint", first), ("name",), (was,))


@KINDS.add("joint renamed", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    driven = {one.get("joint") for one in files.urdf.iterfind(".//mimic")}
    joint = pick([one for one in files.urdf.xpath(f"//{MOVING}") if one.get("name") not in driven], rng)
    was = named("joint", joint)
    joint.set("name", joint.get("name") + "_old")
    return Planted(was, ("name",))


@KINDS.add("XML broken", "C-XML", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    return broken(files.folder / f"{files.name}.urdf", rng)


def broken(path: Path, rng: random.Random) -> Planted:
    """A file without the end of one of its elements."""
    text = path.read_bytes()
    ends = [found.start() for found in re.finditer(rb"/>", text)]
    at = rng.choice(ends)
    path.write_bytes(text[:at] + text[at + 1 :])
    return Planted("", ("", "XML"))
