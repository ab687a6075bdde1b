"""Faults of the scene."""

import random

from lxml import etree

from tests.support.mutations.kind import Element, Files, Kinds, Planted

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


def _option(name: str, attribute: str, value: str) -> None:
    @KINDS.add(name, "C-SCENE")
    def _(files: Files, rng: random.Random) -> Planted:
        etree.SubElement(files.scene, "option", **{attribute: value})
        return Planted("option", (attribute,))


_option("gravity of the moon", "gravity", "0 0 -1.62")
_option("wind", "wind", "5 0 0")
_option("air as dense as water", "density", "1000")
_option("another time step", "timestep", "0.005")
_option("another integrator", "integrator", "Euler")
_option("other friction cones", "cone", "elliptic")
_option("hardly any iterations", "iterations", "1")


@KINDS.add("limits switched off", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    etree.SubElement(etree.SubElement(files.scene, "option"), "flag", limit="disable")
    return Planted("flag", ("limit",))


def floor(files: Files) -> Element:
    return files.scene.find("worldbody/geom[@name='floor']")


@KINDS.add("ground removed", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    one = floor(files)
    one.getparent().remove(one)
    return Planted('geom "floor"', ("name",))


def _ground(name: str, attribute: str, value: str) -> None:
    @KINDS.add(name, "C-SCENE")
    def _(files: Files, rng: random.Random) -> Planted:
        floor(files).set(attribute, value)
        return Planted('geom "floor"', (attribute,))


_ground("ground 30 cm lower", "pos", "0 0 -0.3")
_ground("ground 2 cm up", "pos", "0 0 0.02")
_ground("ground tilted", "quat", "0.9962 0 0.0872 0")
_ground("ground without friction", "friction", "0 0 0")
_ground("ground soft", "solref", "0.2 1")
_ground("ground that is no plane", "type", "box")


@KINDS.add("ground without collisions", "C-SCENE")
def _(files: Files, rng: random.Random) -> Planted:
    floor(files).set("contype", "0")
    floor(files).set("conaffinity", "0")
    return Planted('geom "floor"', ("contype",))


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
