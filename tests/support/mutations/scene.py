"""Faults of the scene."""

import random

from lxml import etree

from tests.support.mutations.kind import Files, Kinds, Planted

KINDS = Kinds("scene")


@KINDS.add("gravity off", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", gravity="0 0 0")
    return Planted("option", ("gravity",))


@KINDS.add("weight pulls upwards", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", gravity="0 0 9.81")
    return Planted("option", ("gravity",))


@KINDS.add("time step too long", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "option", timestep=f"{rng.uniform(0.015, 0.1):.3g}")
    return Planted("option", ("timestep",))


@KINDS.add("contact switched off", "C-OPTION")
def _(files: Files, rng: random.Random) -> Planted:
    option = etree.SubElement(files.scene, "option")
    etree.SubElement(option, "flag", contact="disable")
    return Planted("flag", ("contact",))


@KINDS.add("robot's angles in degrees", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(files.scene, "compiler", angle="degree")
    return Planted("joint", ("range",))


@KINDS.add("joint held in its place", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    joint = rng.choice(files.mjcf.xpath("//body/joint/@name"))
    etree.SubElement(etree.SubElement(files.scene, "equality"), "joint", joint1=joint)
    return Planted("equality", ("",))


@KINDS.add("links pass through each other", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    first, second = rng.sample(files.mjcf.xpath("//body/@name"), 2)
    etree.SubElement(etree.SubElement(files.scene, "contact"), "exclude", body1=first, body2=second)
    return Planted("exclude", ("body1",))


@KINDS.add("include missing", "C-ASSET", "C-LINKS", "C-XML", "C-REFERENCE", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    files.scene.find("include").set("file", "lost.xml")
    return Planted("include", ("file",))


@KINDS.add("obstacle inside the robot", "C-START")
def _(files: Files, rng: random.Random) -> Planted:
    size = f"{rng.uniform(0.08, 0.12):.3g}"
    box = {"type": "box", "size": f"{size} {size} {size}", "pos": "0 0 0.3"}
    etree.SubElement(files.scene.find("worldbody"), "geom", name="crate", **box)
    return Planted("body", ("pos",))


@KINDS.add("body of the scene inside the robot", "C-START")
def _(files: Files, rng: random.Random) -> Planted:
    body = etree.SubElement(files.scene.find("worldbody"), "body", name="crate", pos="0 0 0.3")
    etree.SubElement(body, "geom", type="box", size="0.1 0.1 0.1")
    return Planted("body", ("pos",))
