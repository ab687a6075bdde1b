"""Faults to plant in a finished build, each of which the build's checks must find and name.

A kind changes one place of one file. Where and by how much comes from a seed, so that other seeds are other
faults. `Planted` says what a finding must name: the element of the file, and one of some attributes.
"""

import random
import re
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

from stages.robot.check import Check

Element = etree._Element


@dataclass(frozen=True)
class Planted:
    """`element`: a finding names it, or one of `others`; `attributes`: one of which it names."""

    element: str
    attributes: tuple[str, ...]
    others: tuple[str, ...] = ()


@dataclass
class Files:
    """A finished build, to be changed. `name`: the robot's."""

    folder: Path
    name: str
    trees: dict[str, Element] = field(default_factory=dict)

    @property
    def urdf(self) -> Element:
        return self.tree(f"{self.name}.urdf")

    @property
    def mjcf(self) -> Element:
        return self.tree(f"{self.name}.xml")

    @property
    def scene(self) -> Element:
        return self.tree("scene.xml")

    def tree(self, file: str) -> Element:
        if file not in self.trees:
            self.trees[file] = etree.parse(self.folder / file).getroot()
        return self.trees[file]

    def save(self) -> None:
        for file, root in self.trees.items():
            (self.folder / file).write_bytes(etree.tostring(root, xml_declaration=True, encoding="utf-8"))

    def asset(self, file: str) -> Path:
        return self.folder / "assets" / file


class NothingToChange(Exception):
    """The build has nothing that this fault could be planted in."""


Plant = Callable[[Files, random.Random], Planted]


@dataclass(frozen=True)
class Kind:
    """A kind of fault. `file`: where it is planted: urdf, mjcf, scene or assets; `codes`: of the checks of
    which one names it; `simcheck`: what simcheck calls it, "" if that does not plant it."""

    name: str
    file: str
    codes: tuple[str, ...]
    plant: Plant
    simcheck: str = ""


KINDS: list[Kind] = []


def kind(name: str, file: str, *codes: str, simcheck: str = "") -> Callable[[Plant], Plant]:
    """Makes a function that plants a fault a kind of it."""

    def add(plant: Plant) -> Plant:
        KINDS.append(Kind(name, file, codes, plant, simcheck))
        return plant

    return add


def plant(one: Kind, source: Path, name: str, folder: Path, seed: int, *, whole: bool = False) -> Planted:
    """A copy of the build at `source` in `folder`, with a fault: of the file in which it is, its assets and
    what it includes, or `whole`. NothingToChange where the build has no place for it."""
    urdf, mjcf = f"{name}.urdf", f"{name}.xml"
    needed = {"urdf": (urdf,), "mjcf": (mjcf,), "scene": (mjcf, "scene.xml"), "assets": (urdf, mjcf)}
    if whole:
        shutil.copytree(source, folder)
    else:
        folder.mkdir()
        shutil.copytree(source / "assets", folder / "assets")
        for file in ("robot.json", *needed[one.file]):
            shutil.copy(source / file, folder / file)
    files = Files(folder, name)
    planted = one.plant(files, random.Random(f"{one.name} in {one.file}, {seed}"))
    files.save()
    return planted


def catches(one: Kind, planted: Planted, checks: Sequence[Check]) -> list[str]:
    """The codes of the checks that did not pass and name what was planted, by element and attribute."""
    names = (planted.element, *planted.others)
    return [
        check.code
        for check in checks
        if not check.passed
        and check.code in one.codes
        and any(
            any(name in found.element for name in names)
            and any(attribute in found.attribute for attribute in planted.attributes)
            for found in check.findings
        )
    ]


def pick(found: Sequence[Element], rng: random.Random) -> Element:
    if not found:
        raise NothingToChange
    return rng.choice(list(found))


def numbers(node: Element, key: str) -> list[float]:
    return [float(one) for one in node.get(key).split()]


def put(node: Element, key: str, values: Sequence[float]) -> None:
    node.set(key, " ".join(f"{one:.15g}" for one in values))


def moved(node: Element, key: str, rng: random.Random, distance: float) -> None:
    """Moves a vector by `distance` along one axis."""
    values = numbers(node, key) if node.get(key) else [0.0, 0.0, 0.0]
    values[rng.randrange(3)] += rng.choice((-1, 1)) * distance
    put(node, key, values)


def sign_of(values: Sequence[float]) -> list[float]:
    return [-one for one in values]


def named(tag: str, node: Element) -> str:
    return f'{tag} "{node.get("name")}"'


# URDF

MOVING = "joint[@type='revolute' or @type='continuous' or @type='prismatic']"


def joints(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.urdf.xpath(f"//{MOVING}{condition}"), rng)


def inertial(files: Files, rng: random.Random) -> Element:
    """The <inertial> of a link with a mass that is no speck, of the robot's own links."""
    own = [one for one in files.urdf.iterfind("link/inertial") if float(one.find("mass").get("value")) > 1e-9]
    return pick(own, rng)


@kind("axis flipped", "urdf", "C-MOTION", simcheck="reversed axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    axis = joint.find("axis")
    put(axis, "xyz", sign_of(numbers(axis, "xyz")))
    return Planted(named("joint", joint), ("axis",))


@kind("axis swapped", "urdf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    axis = joint.find("axis")
    x, y, z = numbers(axis, "xyz")
    put(axis, "xyz", (z, x, y))
    return Planted(named("joint", joint), ("axis",))


@kind("axis zero", "urdf", "C-COMPILE", "C-XML", "C-NUMBER", "C-REFERENCE", "C-AXIS", simcheck="zero axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    joint.find("axis").set("xyz", "0 0 0")
    return Planted(named("joint", joint), ("axis",))


@kind("limits swapped", "urdf", "C-JOINT", simcheck="swapped limits")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@lower]")
    limit = joint.find("limit")
    low, high = limit.get("lower"), limit.get("upper")
    limit.set("lower", high)
    limit.set("upper", low)
    return Planted(named("joint", joint), ("limit",))


@kind("limits widened", "urdf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@upper]")
    limit = joint.find("limit")
    limit.set("upper", f"{float(limit.get('upper')) + rng.uniform(0.001, 0.5):.9g}")
    return Planted(named("joint", joint), ("limit upper",))


@kind("limits removed", "urdf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@lower]")
    for key in ("lower", "upper"):
        del joint.find("limit").attrib[key]
    return Planted(named("joint", joint), ("limit",))


@kind("limits in degrees", "urdf", "C-JOINT", simcheck="limits in degrees")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[@type='revolute'][limit/@lower]")
    for key in ("lower", "upper"):
        joint.find("limit").set(key, f"{float(joint.find('limit').get(key)) * 57.29577951:.9g}")
    return Planted(named("joint", joint), ("limit",))


@kind("effort changed", "urdf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@effort]")
    limit = joint.find("limit")
    limit.set("effort", f"{float(limit.get('effort')) * rng.choice((0.5, 0.99, 10)):.9g}")
    return Planted(named("joint", joint), ("effort",))


@kind("velocity changed", "urdf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[limit/@velocity]")
    joint.find("limit").set("velocity", f"{float(joint.find('limit').get('velocity')) * 1.5:.9g}")
    return Planted(named("joint", joint), ("velocity",))


@kind("damping negative", "urdf", "C-JOINT", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[dynamics]")
    joint.find("dynamics").set("damping", f"{-rng.uniform(0.01, 1):.6g}")
    return Planted(named("joint", joint), ("damping",))


@kind("joint type changed", "urdf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng, "[@type!='continuous']")
    joint.set("type", {"revolute": "prismatic", "prismatic": "revolute"}[joint.get("type")])
    return Planted(named("joint", joint), ("type",))


@kind("joint fixed", "urdf", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    driven = {one.get("joint") for one in files.urdf.iterfind(".//mimic")}
    free = [one for one in files.urdf.xpath(f"//{MOVING}[not(mimic)]") if one.get("name") not in driven]
    joint = pick(free, rng)
    joint.set("type", "fixed")
    return Planted(named("joint", joint), ("name", "type"))


@kind("joint origin 1 mm off", "urdf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = joints(files, rng)
    moved(joint.find("origin"), "xyz", rng, 0.001)
    return Planted(named("joint", joint), ("origin xyz",))


@kind("joint origin turned the other way", "urdf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    turned = [
        one
        for one in files.urdf.xpath(f"//{MOVING}")
        if any(0.01 < abs(angle) < 3.13 for angle in numbers(one.find("origin"), "rpy"))
    ]
    joint = pick(turned, rng)
    origin = joint.find("origin")
    put(origin, "rpy", sign_of(numbers(origin, "rpy")))
    return Planted(named("joint", joint), ("origin rpy",))


@kind("all joints in millimetres", "urdf", "C-MOTION", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    return resized(files, 1000.0)


@kind("all joints far too near", "urdf", "C-MOTION", simcheck="too small")
def _(files: Files, rng: random.Random) -> Planted:
    return resized(files, 0.01)


def resized(files: Files, factor: float) -> Planted:
    names = []
    for joint in files.urdf.xpath(f"//{MOVING}"):
        origin = joint.find("origin")
        values = numbers(origin, "xyz")
        put(origin, "xyz", [factor * value for value in values])
        names += [named("joint", joint)] if max(map(abs, values)) > 1e-4 else []
    if not names:
        raise NothingToChange
    return Planted(names[0], ("origin xyz",), tuple(names))


@kind("joint within its parent", "urdf", "C-MOTION", simcheck="joint inside its parent")
def _(files: Files, rng: random.Random) -> Planted:
    away = [
        one
        for one in files.urdf.xpath(f"//{MOVING}")
        if max(map(abs, numbers(one.find("origin"), "xyz"))) > 1e-3
    ]
    joint = pick(away, rng)
    joint.find("origin").set("xyz", "0 0 0")
    return Planted(named("joint", joint), ("origin xyz",))


@kind("parent swapped", "urdf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    parents = {
        one.find("child").get("link"): one.find("parent").get("link")
        for one in files.urdf.iter("joint")
        if one.find("child") is not None
    }
    deep = [one for one in files.urdf.xpath(f"//{MOVING}") if one.find("parent").get("link") in parents]
    joint = pick(deep, rng)
    joint.find("parent").set("link", parents[joint.find("parent").get("link")])
    return Planted(named("joint", joint), ("parent", "origin"))


@kind("mass 1 % off", "urdf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    mass = one.find("mass")
    mass.set("value", f"{float(mass.get('value')) * rng.choice((0.99, 1.01)):.12g}")
    return Planted(named("link", one.getparent()), ("inertial mass",))


@kind("mass in grams", "urdf", "C-MASS", simcheck="grams as kilograms")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    mass = one.find("mass")
    mass.set("value", f"{float(mass.get('value')) * 1000:.12g}")
    return Planted(named("link", one.getparent()), ("inertial mass",))


@kind("mass zero", "urdf", "C-MASS", "C-COMPILE", simcheck="zero mass")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    one.find("mass").set("value", "0")
    return Planted(named("link", one.getparent()), ("mass",))


@kind("inertial removed", "urdf", "C-MASS", "C-COMPILE", simcheck="no inertial")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    link = one.getparent()
    link.remove(one)
    return Planted(named("link", link), ("inertial",))


@kind("centre of mass 2 mm off", "urdf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    moved(one.find("origin"), "xyz", rng, 0.002)
    return Planted(named("link", one.getparent()), ("inertial origin",))


@kind("centre of mass outside the part", "urdf", "C-MASS", simcheck="centre of mass off the part")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.5, 2))
    return Planted(named("link", one.getparent()), ("inertial origin",))


@kind("inertia's off-diagonal sign", "urdf", "C-MASS")
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


@kind("inertia in kg mm²", "urdf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    for key, value in one.find("inertia").attrib.items():
        one.find("inertia").set(key, f"{float(value) * 1e6:.12g}")
    return Planted(named("link", one.getparent()), ("inertia",))


@kind("inertia zero", "urdf", "C-MASS", "C-COMPILE", simcheck="zero inertia")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    for key in one.find("inertia").attrib:
        one.find("inertia").set(key, "0")
    return Planted(named("link", one.getparent()), ("inertia",))


@kind(
    "inertia against the triangle inequality",
    "urdf",
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


@kind("inertia negative", "urdf", "C-COMPILE", "C-MASS", "C-INERTIA", simcheck="negative inertia")
def _(files: Files, rng: random.Random) -> Planted:
    one = inertial(files, rng)
    tensor = one.find("inertia")
    tensor.set("ixx", f"{-float(tensor.get('ixx')):.12g}")
    return Planted(named("link", one.getparent()), ("inertia",))


@kind("mimic's sign", "urdf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    mimic.set("multiplier", f"{-float(mimic.get('multiplier', '1')):.12g}")
    return Planted(named("joint", mimic.getparent()), ("mimic multiplier",))


@kind("mimic's offset", "urdf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    mimic.set("offset", f"{float(mimic.get('offset', '0')) + rng.uniform(0.01, 0.2):.9g}")
    return Planted(named("joint", mimic.getparent()), ("mimic offset",))


@kind("mimic removed", "urdf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    mimic = pick(files.urdf.xpath("//mimic"), rng)
    joint = mimic.getparent()
    joint.remove(mimic)
    return Planted(named("joint", joint), ("mimic",))


@kind("frame moved", "urdf", "C-MOTION")
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


@kind("collider gone", "urdf", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "geometry")
    link.remove(one)
    return Planted(named("link", link), ("collision", "geom"))


@kind("colliders of a link gone", "urdf", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    _, link = shape(files, rng, "collision", "geometry")
    for one in link.findall("collision"):
        link.remove(one)
    return Planted(named("link", link), ("collision", "geom"))


@kind("collider moved", "urdf", "C-SHAPE", simcheck="offset collision")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "origin")
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.001, 0.1))
    return Planted(named("link", link), ("origin", "pos"))


@kind("collider resized", "urdf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "collision", "geometry/box or geometry/cylinder or geometry/sphere")
    solid = one.find("geometry")[0]
    key = next(name for name in ("size", "radius") if solid.get(name))
    put(solid, key, [1.1 * value for value in numbers(solid, key)])
    return Planted(named("link", link), ("size",))


@kind("visual moved", "urdf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "origin")
    moved(one.find("origin"), "xyz", rng, rng.uniform(0.001, 0.1))
    return Planted(named("link", link), ("origin", "pos"))


@kind("mesh scaled to millimetres", "urdf", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "geometry/mesh")
    one.find("geometry/mesh").set("scale", "1000 1000 1000")
    return Planted(named("link", link), ("mesh", "scale"))


@kind("mesh far too small", "urdf", "C-SHAPE", "C-COMPILE", simcheck="too small")
def _(files: Files, rng: random.Random) -> Planted:
    one, link = shape(files, rng, "visual", "geometry/mesh")
    one.find("geometry/mesh").set("scale", "0.01 0.01 0.01")
    return Planted(named("link", link), ("mesh", "scale"))


@kind("mesh of another part", "urdf", "C-SHAPE")
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


@kind("mesh path broken", "urdf", "C-ASSET", "C-COMPILE", simcheck="broken mesh path")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = pick(files.urdf.xpath("//mesh"), rng)
    mesh.set("filename", mesh.get("filename").replace("assets/", "assets/lost_"))
    link = next(one for one in mesh.iterancestors("link"))
    return Planted("mesh", ("filename",), (named("link", link),))


@kind("name given twice", "urdf", "C-NAME", "C-COMPILE", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample(files.urdf.xpath(f"//{MOVING}"), 2)
    was = named("joint", second)
    second.set("name", first.get("name"))
    return Planted(named("joint", first), ("name",), (was,))


@kind("joint renamed", "urdf", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    driven = {one.get("joint") for one in files.urdf.iterfind(".//mimic")}
    joint = pick([one for one in files.urdf.xpath(f"//{MOVING}") if one.get("name") not in driven], rng)
    was = named("joint", joint)
    joint.set("name", joint.get("name") + "_old")
    return Planted(was, ("name",))


@kind("XML broken", "urdf", "C-XML", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    return broken(files.folder / f"{files.name}.urdf", rng)


def broken(path: Path, rng: random.Random) -> Planted:
    """A file without the end of one of its elements."""
    text = path.read_bytes()
    ends = [found.start() for found in re.finditer(rb"/>", text)]
    at = rng.choice(ends)
    path.write_bytes(text[:at] + text[at + 1 :])
    return Planted("", ("", "XML"))


# MJCF


def named_joint(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//body/joint[@name]{condition}"), rng)


def body_of(node: Element) -> Element:
    return next(node.iterancestors("body"))


def moving_bodies(files: Files, rng: random.Random) -> Element:
    """Bodies with joints, below the first."""
    return pick(files.mjcf.xpath("//worldbody/body//body[joint]"), rng)


@kind("axis flipped", "mjcf", "C-MOTION", simcheck="reversed axis")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    put(joint, "axis", sign_of(numbers(joint, "axis") if joint.get("axis") else [0, 0, 1]))
    return Planted(named("joint", joint), ("axis",))


@kind("axis swapped", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    x, y, z = numbers(joint, "axis") if joint.get("axis") else (0.0, 0.0, 1.0)
    put(joint, "axis", (z, x, y))
    return Planted(named("joint", joint), ("axis",))


@kind("joint's place 1 mm off", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(contains(@class, 'slide'))]")
    axis = numbers(joint, "axis") if joint.get("axis") else [0.0, 0.0, 1.0]
    place = [0.0, 0.0, 0.0]
    place[min(range(3), key=lambda at: abs(axis[at]))] = 0.001
    put(joint, "pos", place)
    return Planted(named("joint", joint), ("pos",))


@kind("range widened", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    low, high = numbers(joint, "range")
    put(joint, "range", (low - rng.uniform(0.001, 0.3), high))
    return Planted(named("joint", joint), ("range",))


@kind("range swapped", "mjcf", "C-JOINT", "C-COMPILE", simcheck="swapped limits")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    put(joint, "range", numbers(joint, "range")[::-1])
    return Planted(named("joint", joint), ("range",))


@kind("range removed", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[@range]")
    del joint.attrib["range"]
    return Planted(named("joint", joint), ("range",))


@kind("angles read as degrees", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    files.mjcf.find("compiler").set("angle", "degree")
    turning = [
        one.get("name") for one in files.mjcf.xpath("//body/joint[@range][not(contains(@class, 'slide'))]")
    ]
    return Planted(f'joint "{turning[0]}"', ("range",), tuple(f'joint "{name}"' for name in turning))


@kind("damping negative", "mjcf", "C-JOINT", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("damping", "-0.5")
    return Planted(named("joint", joint), ("damping",))


@kind("armature changed", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng)
    joint.set("armature", f"{rng.uniform(0.1, 1):.6g}")
    return Planted(named("joint", joint), ("armature",))


@kind("effort changed", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    joint.set("actuatorfrcrange", "-1234 1234")
    return Planted(named("joint", joint), ("actuatorfrcrange",))


@kind("joint type changed", "mjcf", "C-JOINT")
def _(files: Files, rng: random.Random) -> Planted:
    joint = named_joint(files, rng, "[not(@type='ball')]")
    sliding = "slide" in (joint.get("type") or "") + (joint.get("class") or "")
    joint.set("type", "hinge" if sliding else "slide")
    return Planted(named("joint", joint), ("type",))


@kind("body 1 mm off", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    body = moving_bodies(files, rng)
    moved(body, "pos", rng, 0.001)
    return Planted(named("body", body), ("pos",))


@kind("quaternion with its real part last", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    body = pick(files.mjcf.xpath("//worldbody/body//body[@quat][joint]"), rng)
    w, x, y, z = numbers(body, "quat")
    put(body, "quat", (x, y, z, w))
    return Planted(named("body", body), ("quat",))


@kind("body on another body", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    deep = files.mjcf.xpath("//worldbody/body//body/body[joint]")
    body = pick(deep, rng)
    body.getparent().getparent().append(body)
    return Planted(named("body", body), ("parent", "pos"))


@kind("mass 1 % off", "mjcf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    one.set("mass", f"{float(one.get('mass')) * rng.choice((0.99, 1.01)):.12g}")
    return Planted(named("body", one.getparent()), ("inertial mass",))


@kind("mass in grams", "mjcf", "C-MASS", simcheck="grams as kilograms")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    one.set("mass", f"{float(one.get('mass')) * 1000:.12g}")
    return Planted(named("body", one.getparent()), ("inertial mass",))


@kind("inertial removed", "mjcf", "C-MASS", "C-COMPILE", simcheck="no inertial")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    body = one.getparent()
    body.remove(one)
    return Planted(named("body", body), ("inertial",))


@kind("centre of mass 2 mm off", "mjcf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial"), rng)
    moved(one, "pos", rng, 0.002)
    return Planted(named("body", one.getparent()), ("inertial pos",))


@kind("axes of inertia turned the other way", "mjcf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(
        [
            one
            for one in files.mjcf.xpath("//body/inertial[@quat]")
            if 0.01 < abs(numbers(one, "quat")[0]) < 0.99
        ],
        rng,
    )
    w, *rest = numbers(one, "quat")
    put(one, "quat", (w, *sign_of(rest)))
    return Planted(named("body", one.getparent()), ("inertial quat", "inertial diaginertia"))


@kind("inertia in kg mm²", "mjcf", "C-MASS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//body/inertial[@diaginertia]"), rng)
    put(one, "diaginertia", [1e6 * value for value in numbers(one, "diaginertia")])
    return Planted(named("body", one.getparent()), ("inertial diaginertia",))


@kind("loop's site 1 mm off", "mjcf", "C-LOOP", "C-CLOSED")
def _(files: Files, rng: random.Random) -> Planted:
    closing = {node.get(key): node for node in files.mjcf.xpath("//connect") for key in ("site1", "site2")}
    site = pick([one for one in files.mjcf.iter("site") if one.get("name") in closing], rng)
    moved(site, "pos", rng, 0.001)
    return Planted(named("site", site), ("pos", "site1"), (named("connect", closing[site.get("name")]),))


@kind("loop's equality removed", "mjcf", "C-LOOP")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/connect | //equality/weld"), rng)
    one.getparent().remove(one)
    return Planted(f'connect "{one.get("name").removesuffix("_axis")}"', ("site1",))


@kind("relation's sign", "mjcf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    offset, factor, *rest = numbers(one, "polycoef")
    put(one, "polycoef", (offset, -factor, *rest))
    return Planted(named("joint", one), ("polycoef",))


@kind("relation's offset", "mjcf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    offset, *rest = numbers(one, "polycoef")
    put(one, "polycoef", (offset + rng.uniform(0.01, 0.2), *rest))
    return Planted(named("joint", one), ("polycoef",))


@kind("relation removed", "mjcf", "C-RELATION")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//equality/joint"), rng)
    one.getparent().remove(one)
    return Planted(named("joint", one), ("", "polycoef"))


@kind("actuator on another joint", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    every = {node.get("name") for node in files.mjcf.xpath("//body/joint[@name][not(@type='ball')]")}
    one.set("joint", rng.choice(sorted(every - {one.get("joint")})))
    return Planted(named(one.tag, one), ("joint",))


def actuator(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//actuator/*[@joint]{condition}"), rng)


@kind("actuator removed", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    one.getparent().remove(one)
    for key in files.mjcf.iter("key"):
        if key.get("ctrl"):
            key.set("ctrl", " ".join(key.get("ctrl").split()[:-1]))
    return Planted(named(one.tag, one), ("name",))


@kind("gear's sign", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    first = numbers(one, "gear")[0] if one.get("gear") else 1.0
    one.set("gear", f"{-first:g}")
    return Planted(named(one.tag, one), ("gear",))


@kind("servo without stiffness", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng, "[@kp]")
    one.set("kp", "0")
    return Planted(named(one.tag, one), ("kp",))


@kind("range of control", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng, "[@ctrlrange]")
    low, high = numbers(one, "ctrlrange")
    put(one, "ctrlrange", (low, high + rng.uniform(0.01, 1)))
    return Planted(named(one.tag, one), ("ctrlrange",))


@kind("range of force", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = actuator(files, rng)
    one.set("forcerange", "-0.001 0.001")
    return Planted(named(one.tag, one), ("forcerange",))


@kind("keyframe off", "mjcf", "C-KEYFRAME")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key[@qpos]"), rng)
    values = numbers(key, "qpos")
    at = rng.randrange(7 if files.mjcf.find(".//freejoint") is not None else 0, len(values))
    values[at] += rng.choice((-1, 1)) * rng.uniform(0.01, 0.5)
    put(key, "qpos", values)
    return Planted(named("key", key), ("qpos",))


@kind("keyframe removed", "mjcf", "C-KEYFRAME")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key"), rng)
    key.getparent().remove(key)
    return Planted(named("key", key), ("name",))


@kind("control of the keyframe", "mjcf", "C-ACTUATOR")
def _(files: Files, rng: random.Random) -> Planted:
    key = pick(files.mjcf.xpath("//key[@name='home'][@ctrl]"), rng)
    values = numbers(key, "ctrl")
    values[rng.randrange(len(values))] += rng.uniform(0.01, 0.5)
    put(key, "ctrl", values)
    return Planted(named("key", key), ("ctrl",))


@kind("sensor on another place", "mjcf", "C-SENSOR")
def _(files: Files, rng: random.Random) -> Planted:
    keys = ("site", "joint", "actuator", "objname")
    one = pick([node for node in files.mjcf.xpath("//sensor/*") if any(node.get(key) for key in keys)], rng)
    key = next(key for key in keys if one.get(key))
    pool = {
        "site": "//body//site/@name",
        "joint": "//body/joint[not(@type='ball')]/@name",
        "actuator": "//actuator/*/@name",
        "objname": "//body//site/@name" if one.get("objtype") == "site" else "//body/@name",
    }
    others = sorted(set(map(str, files.mjcf.xpath(pool[key]))) - {one.get(key)})
    if not others:
        raise NothingToChange
    one.set(key, rng.choice(others))
    return Planted(named(one.tag, one), (key, "site", "objname"))


@kind("sensor removed", "mjcf", "C-SENSOR")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//sensor/*"), rng)
    one.getparent().remove(one)
    return Planted(named(one.tag, one), ("name",))


@kind("site of a frame moved", "mjcf", "C-MOTION")
def _(files: Files, rng: random.Random) -> Planted:
    used = {node.get(key) for node in files.mjcf.xpath("//equality/*") for key in ("site1", "site2")}
    site = pick(
        [one for one in files.mjcf.iter("site") if one.get("name") and one.get("name") not in used], rng
    )
    moved(site, "pos", rng, 0.001)
    return Planted(named("site", site), ("pos",))


@kind("freejoint removed", "mjcf", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//freejoint"), rng)
    body = one.getparent()
    body.remove(one)
    for key in files.mjcf.iter("key"):
        key.set("qpos", " ".join(key.get("qpos").split()[7:]))
    return Planted(named("body", body), ("freejoint",))


@kind("freejoint added", "mjcf", "C-LINKS", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    if files.mjcf.find(".//freejoint") is not None:
        raise NothingToChange
    body = files.mjcf.find("worldbody/body")
    body.insert(0, etree.Element("freejoint", name="floats"))
    for key in files.mjcf.iter("key"):
        key.set("qpos", "0 0 0 1 0 0 0 " + key.get("qpos"))
    return Planted('joint "floats"', ("type",))


@kind("exclude removed", "mjcf", "C-EXCLUDE")
def _(files: Files, rng: random.Random) -> Planted:
    one = pick(files.mjcf.xpath("//exclude"), rng)
    one.getparent().remove(one)
    return exclude(one.get("body1"), one.get("body2"))


def exclude(first: str, second: str) -> Planted:
    one, other = (f'exclude "{a}" "{b}"' for a, b in ((first, second), (second, first)))
    return Planted(one, ("body1",), (other,))


@kind("exclude added", "mjcf", "C-EXCLUDE")
def _(files: Files, rng: random.Random) -> Planted:
    holder = files.mjcf.find("contact")
    if holder is None:
        holder = etree.SubElement(files.mjcf, "contact")
    known = {frozenset((one.get("body1"), one.get("body2"))) for one in holder.iter("exclude")}
    solid = files.mjcf.xpath("//body[geom[contains(@class, 'collision')]]")
    pairs = [
        (one.get("name"), other.get("name"))
        for one in solid
        for other in solid
        if one.get("name") < other.get("name")
        and one.getparent() is not other
        and other.getparent() is not one
        and frozenset((one.get("name"), other.get("name"))) not in known
    ]
    if not pairs:
        raise NothingToChange
    first, second = rng.choice(pairs)
    etree.SubElement(holder, "exclude", body1=first, body2=second)
    return exclude(first, second)


def collider(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//body/geom[contains(@class, 'collision')]{condition}"), rng)


def of_geom(geom: Element) -> tuple[str, tuple[str, ...]]:
    name = named("geom", geom) if geom.get("name") else named("body", geom.getparent())
    return name, (named("body", geom.getparent()), f'geom mesh "{geom.get("mesh")}"')


@kind("collider gone", "mjcf", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    body = geom.getparent()
    body.remove(geom)
    return Planted(named("body", body), ("geom",))


@kind("collider collides with nothing", "mjcf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    geom.set("contype", "0")
    geom.set("conaffinity", "0")
    return Planted(named("body", geom.getparent()), ("geom",))


@kind("collider moved", "mjcf", "C-SHAPE", simcheck="offset collision")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    moved(geom, "pos", rng, rng.uniform(0.001, 0.1))
    name, others = of_geom(geom)
    return Planted(name, ("pos",), others)


@kind("collider resized", "mjcf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng, "[@size]")
    put(geom, "size", [1.1 * value for value in numbers(geom, "size")])
    name, others = of_geom(geom)
    return Planted(name, ("size",), others)


@kind("visual moved", "mjcf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = pick(files.mjcf.xpath("//body/geom[contains(@class, 'visual')]"), rng)
    moved(geom, "pos", rng, rng.uniform(0.001, 0.1))
    name, others = of_geom(geom)
    return Planted(name, ("pos",), others)


@kind("mesh of another part", "mjcf", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = pick(files.mjcf.xpath("//body/geom[@mesh][contains(@class, 'visual')]"), rng)
    sizes = {path.stem: path.stat().st_size for path in (files.folder / "assets").glob("*.stl")}
    every = {one.get("mesh") for one in files.mjcf.xpath("//body/geom[@mesh][contains(@class, 'visual')]")}
    others = sorted(one for one in every if sizes.get(one) != sizes.get(geom.get("mesh")))
    if not others:
        raise NothingToChange
    geom.set("mesh", rng.choice(others))
    name, names = of_geom(geom)
    return Planted(name, ("mesh", "pos"), names)


@kind("mesh scaled to millimetres", "mjcf", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = pick(files.mjcf.xpath("//asset/mesh[@file]"), rng)
    mesh.set("scale", "1000 1000 1000")
    stem = mesh.get("name") or Path(mesh.get("file")).stem
    geoms = [one for one in files.mjcf.xpath("//body/geom[@mesh]") if one.get("mesh") == stem]
    names = [name for geom in geoms for name in (of_geom(geom)[0], *of_geom(geom)[1])]
    return Planted(f'mesh "{stem}"', ("mesh", "scale"), tuple(names))


@kind("name given twice", "mjcf", "C-NAME", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample(files.mjcf.xpath("//body/joint[@name]"), 2)
    was = named("joint", second)
    second.set("name", first.get("name"))
    return Planted(named("joint", first), ("name",), (was,))


@kind("body renamed", "mjcf", "C-LINKS")
def _(files: Files, rng: random.Random) -> Planted:
    held = {
        one.get(key)
        for one in files.mjcf.iter("exclude", "*")
        for key in ("body1", "body2", "objname", "refname")
    }
    body = pick([one for one in files.mjcf.iter("body") if one.get("name") not in held], rng)
    was = named("body", body)
    body.set("name", body.get("name") + "_old")
    return Planted(was, ("name",))


@kind("XML broken", "mjcf", "C-XML", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    return broken(files.folder / f"{files.name}.xml", rng)


# The scene


@kind("gravity off", "scene", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", gravity="0 0 0")
    return Planted("option", ("gravity",))


@kind("weight pulls upwards", "scene", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", gravity="0 0 9.81")
    return Planted("option", ("gravity",))


@kind("time step too long", "scene", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", timestep=f"{rng.uniform(0.015, 0.1):.3g}")
    return Planted("option", ("timestep",))


@kind("contact switched off", "scene", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    option = etree.SubElement(files.scene, "option")
    etree.SubElement(option, "flag", contact="disable")
    return Planted("flag", ("contact",))


@kind("include missing", "scene", "C-ASSET", "C-LINKS", "C-XML", "C-REFERENCE", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    files.scene.find("include").set("file", "lost.xml")
    return Planted("include", ("file",))


# Assets


def stl(files: Files, rng: random.Random) -> Path:
    found = sorted((files.folder / "assets").glob("*.stl"))
    if not found:
        raise NothingToChange
    return rng.choice(found)


def of_mesh(files: Files, path: Path) -> Planted:
    """Findings name the mesh by its name or its file, or a geom that has it, or the link that does."""
    geoms = [one for one in files.mjcf.xpath("//body/geom[@mesh]") if one.get("mesh") == path.stem]
    users = [of_geom(one)[0] for one in geoms if one.get("name")]
    links = [
        one for one in files.urdf.iter("link") if one.xpath(f".//mesh[contains(@filename, '/{path.name}')]")
    ]
    users += [named("link", one) for one in links]
    return Planted(
        f'mesh "{path.stem}"', ("mesh", "file", ""), (f'"assets/{path.name}"', f'"{path.name}"', *users)
    )


@kind("mesh in millimetres", "assets", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    scaled(path, 1000.0)
    return of_mesh(files, path)


def scaled(path: Path, factor: float) -> None:
    """The same binary STL, `factor` times as large."""
    import numpy as np

    data = bytearray(path.read_bytes())
    faces = np.frombuffer(data, dtype=np.dtype([("floats", "<f4", 12), ("rest", "<u2")]), offset=84)
    faces["floats"][:, 3:] *= factor
    path.write_bytes(bytes(data))


@kind("mesh 1 % too large", "assets", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    scaled(path, 1.01)
    return of_mesh(files, path)


@kind("mesh replaced by another", "assets", "C-SHAPE", "C-ASSET")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    others = [one for one in sorted(path.parent.glob("*.stl")) if one.read_bytes() != path.read_bytes()]
    different = [one for one in others if one.stat().st_size != path.stat().st_size]
    if not different:
        raise NothingToChange
    shutil.copy(rng.choice(different), path)
    return of_mesh(files, path)


@kind("mesh cut short", "assets", "C-ASSET", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    return of_mesh(files, path)


@kind("mesh empty", "assets", "C-ASSET", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.write_bytes(b"")
    return of_mesh(files, path)


@kind("mesh missing", "assets", "C-ASSET", "C-COMPILE", "C-PRESENT", simcheck="broken mesh path")
def _(files: Files, rng: random.Random) -> Planted:
    path = stl(files, rng)
    path.unlink()
    return of_mesh(files, path)
