"""Faults of an MJCF's geoms, meshes and names."""

import random
from pathlib import Path

from lxml import etree

from tests.support.mutations.edits import moved, named, numbers, pick, put
from tests.support.mutations.kind import Element, Files, Kinds, NothingToChange, Planted
from tests.support.mutations.urdf_links import broken

KINDS = Kinds("mjcf")


def collider(files: Files, rng: random.Random, condition: str = "") -> Element:
    return pick(files.mjcf.xpath(f"//body/geom[contains(@class, 'collision')]{condition}"), rng)


def of_geom(geom: Element) -> tuple[str, tuple[str, ...]]:
    name = named("geom", geom) if geom.get("name") else named("body", geom.getparent())
    return name, (named("body", geom.getparent()), f'geom mesh "{geom.get("mesh")}"')


@KINDS.add("collider gone", "C-SHAPE", simcheck="missing collision")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    body = geom.getparent()
    body.remove(geom)
    return Planted(named("body", body), ("geom",))


@KINDS.add("collider collides with nothing", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    geom.set("contype", "0")
    geom.set("conaffinity", "0")
    return Planted(named("body", geom.getparent()), ("geom",))


@KINDS.add("collider moved", "C-SHAPE", simcheck="offset collision")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng)
    moved(geom, "pos", rng, rng.uniform(0.001, 0.1))
    name, others = of_geom(geom)
    return Planted(name, ("pos",), others)


@KINDS.add("collider resized", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = collider(files, rng, "[@size]")
    put(geom, "size", [1.1 * value for value in numbers(geom, "size")])
    name, others = of_geom(geom)
    return Planted(name, ("size",), others)


@KINDS.add("collider added before the others", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    first = collider(files, rng)
    body, added = first.getparent(), etree.Element("geom", name="bumper", type="sphere", size="0.01")
    body.insert(list(body).index(first), added)
    return Planted('geom "bumper"', ("geom",))


@KINDS.add("collider added after the others", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    body = collider(files, rng).getparent()
    etree.SubElement(body, "geom", name="bumper", type="box", size="0.01 0.01 0.01")
    return Planted('geom "bumper"', ("geom",))


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


def _of_contact(attribute: str, value: str) -> None:
    @KINDS.add(f"collider's {attribute}", "C-CONTACT")
    def _(files: Files, rng: random.Random) -> Planted:
        geom = collider(files, rng)
        geom.set(attribute, value)
        name, others = of_geom(geom)
        return Planted(name, (attribute,), others)


for _attribute, _value in CONTACT.items():
    _of_contact(_attribute, _value)


@KINDS.add("friction of all colliders", "C-CONTACT")
def _(files: Files, rng: random.Random) -> Planted:
    files.mjcf.find(".//default[@class='collision']/geom").set("friction", "0 0 0")
    return Planted("geom", ("friction",))


@KINDS.add("hull of few points", "C-CONTACT")
def _(files: Files, rng: random.Random) -> Planted:
    stem = collider(files, rng, "[@mesh]").get("mesh")
    (mesh,) = (one for one in files.mjcf.xpath("//asset/mesh[@file]") if Path(one.get("file")).stem == stem)
    mesh.set("maxhullvert", "5")
    return Planted(f'mesh "{stem}"', ("maxhullvert",))


@KINDS.add("pair of colliders", "C-EXCLUDE")
def _(files: Files, rng: random.Random) -> Planted:
    names = files.mjcf.xpath("//body/geom[contains(@class, 'collision')]/@name")
    first, second = rng.sample(list(names), 2)
    contact = files.mjcf.find("contact")
    contact = etree.SubElement(files.mjcf, "contact") if contact is None else contact
    etree.SubElement(contact, "pair", geom1=first, geom2=second)
    return Planted(f'geom "{first}"', ("geom1",), (f'geom "{second}"',))


@KINDS.add("visual moved", "C-SHAPE")
def _(files: Files, rng: random.Random) -> Planted:
    geom = pick(files.mjcf.xpath("//body/geom[contains(@class, 'visual')]"), rng)
    moved(geom, "pos", rng, rng.uniform(0.001, 0.1))
    name, others = of_geom(geom)
    return Planted(name, ("pos",), others)


@KINDS.add("mesh of another part", "C-SHAPE")
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


@KINDS.add("mesh scaled to millimetres", "C-SHAPE", simcheck="millimetre units")
def _(files: Files, rng: random.Random) -> Planted:
    mesh = pick(files.mjcf.xpath("//asset/mesh[@file]"), rng)
    mesh.set("scale", "1000 1000 1000")
    stem = mesh.get("name") or Path(mesh.get("file")).stem
    geoms = [one for one in files.mjcf.xpath("//body/geom[@mesh]") if one.get("mesh") == stem]
    names = [name for geom in geoms for name in (of_geom(geom)[0], *of_geom(geom)[1])]
    return Planted(f'mesh "{stem}"', ("mesh", "scale"), tuple(names))


@KINDS.add("name given twice", "C-NAME", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample(files.mjcf.xpath("//body/joint[@name]"), 2)
    was = named("joint", second)
    second.set("name", first.get("name"))
    return Planted(named("joint", first), ("name",), (was,))


@KINDS.add("body renamed", "C-LINKS")
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


@KINDS.add("XML broken", "C-XML", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    return broken(files.folder / f"{files.name}.xml", rng)
