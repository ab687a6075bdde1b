"""Faults of an MJCF's geoms, meshes and names."""

import random
from pathlib import Path

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
