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


@KINDS.add("include missing", "C-ASSET", "C-LINKS", "C-XML", "C-REFERENCE", "C-COMPILE")
def _(files: Files, rng: random.Random) -> Planted:
    files.scene.find("include").set("file", "lost.xml")
    return Planted("include", ("file",))
