"""The points that the text of the files shows."""

import re
from collections.abc import Iterator
from contextlib import suppress

from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.readiness.finished import Aside, Finished, smallest_share

NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")

NOISE = 1e-12
"""A number below this share of the largest of its attribute is noise."""

OF_CLASS = ("contype", "conaffinity", "group", "density", "mass")
"""What a geom's class says, so that no geom repeats it."""


def the_robot_alone(finished: Finished) -> Iterator[str]:
    for one in finished.xml.iterfind("worldbody/*"):
        if one.tag == "light" or (one.tag == "geom" and one.get("type") == "plane"):
            yield f"move <{one.tag}> from {finished.path.name} to scene.xml"
    scene = finished.scene
    if all(one.get("file") != finished.path.name for one in scene.iter("include")):
        yield f"let scene.xml include {finished.path.name}"
    for place, words in (
        ("worldbody/geom", "a ground: ground.kind"),
        (".//light", "a light: scene.lights"),
        ("asset/texture[@type='skybox']", "a sky"),
    ):
        if scene.find(place) is None:
            yield f"give scene.xml {words}"


def paths(finished: Finished) -> Iterator[str]:
    compiler = finished.xml.find("compiler")
    said = {} if compiler is None else compiler.attrib
    if said.get("angle") != "radian":
        yield 'write <compiler angle="radian">'
    if said.get("autolimits") == "false":
        yield "leave out autolimits"
    folder = said.get("meshdir", "")
    used = {f"{folder}/{one.get('file')}" if folder else one.get("file") for one in _files(finished.xml)}
    for file in sorted(used):
        if file.startswith("/") or ".." in file or "://" in file:
            yield f"{file} is no path below the model's folder"
        elif not (finished.folder / file).is_file():
            yield f"{file} is not there"
    there = {
        path.relative_to(finished.folder).as_posix()
        for path in (finished.folder / "assets").glob("*")
        if path.suffix not in (".mtl", ".png")
    }
    with suppress(Aside):
        used |= {_below(one.get("filename", "")) for one in finished.urdf.iterfind(".//mesh")}
    yield from (f"nothing uses {file}" for file in sorted(there - used))


def _files(xml: Element) -> list[Element]:
    return [one for one in xml.iterfind("asset/*[@file]") if one.tag == "mesh"]


def _below(path: str) -> str:
    return path.removeprefix("package://").partition("/")[2] if path.startswith("package://") else path


def classes(finished: Finished) -> Iterator[str]:
    root = finished.xml.find("default/default")
    known = set() if root is None else {one.get("class") for one in root.iter("default")}
    if root is None or not root.get("class") or not {"visual", "collision"} <= known:
        yield "write a root default class with the classes visual and collision"
    bare, told = 0, set[str]()
    for geom in finished.xml.iterfind(".//worldbody//geom"):
        bare += geom.get("class") is None
        told |= {key for key in OF_CLASS if key in geom.attrib}
    if bare:
        yield f"give {bare} geoms a class"
    if told:
        yield f"let classes say {', '.join(sorted(told))}, not geoms"


def inertials(finished: Finished) -> Iterator[str]:
    for body in finished.xml.iterfind(".//worldbody//body"):
        if body.find("inertial") is None:
            yield f"write the inertia of {body.get('name')}"
    geoms = finished.xml.iterfind(".//worldbody//geom")
    massive = {geom.get("name", "a geom") for geom in geoms if float(geom.get("mass", 0.0)) > 0}
    if massive:
        yield f"{', '.join(sorted(massive))} have a mass of their own beside the inertia"


def one_convention(finished: Finished) -> Iterator[str]:
    found = set()
    for inertial in finished.xml.iterfind(".//worldbody//body/inertial"):
        found |= {"diaginertia", "fullinertia"} & set(inertial.attrib)
    if len(found) > 1:
        yield "write all inertias as diaginertia and quat, or all as fullinertia"


def order(finished: Finished) -> Iterator[str]:
    tree = [joint.get("name") for joint in finished.xml.iterfind(".//worldbody//joint")]
    driven = [(one.get("name"), one.get("joint")) for one in finished.xml.iterfind("actuator/*[@joint]")]
    for name, joint in driven:
        if not (name or "").startswith(joint):
            yield f"name the actuator {name} by its joint {joint}"
    places = [tree.index(joint) for _, joint in driven if joint in tree]
    if places != sorted(places):
        yield "write the actuators in the order of the joints"
    try:
        urdf = [one.get("name") for one in finished.urdf.iterfind("joint") if one.get("name") in tree]
    except Aside:
        return
    if urdf != [name for name in tree if name in urdf]:
        yield "write the URDF's joints in the MJCF's order"


def materials(finished: Finished) -> Iterator[str]:
    colours = [
        one.get("rgba") for one in finished.xml.iterfind("asset/material[@rgba]") if not one.get("texture")
    ]
    if len(colours) != len(set(colours)):
        yield "share the materials of one colour"
    own = [geom for geom in finished.xml.iterfind(".//worldbody//geom") if geom.get("rgba") is not None]
    if own:
        yield f"give {len(own)} geoms a material in place of a colour"


def numbers(finished: Finished) -> Iterator[str]:
    for one in finished.xml.iter():
        for key, text in one.attrib.items():
            words = text.split()
            if not words or not all(NUMBER.fullmatch(word) for word in words):
                continue
            zero = any(word.startswith("-") and float(word) == 0 for word in words)
            if zero or (key != "qpos" and smallest_share([float(word) for word in words], NOISE)):
                yield f'{one.tag} {one.get("name", "")}: {key}="{text}" has noise, or a negative zero'


def option(finished: Finished) -> Iterator[str]:
    found = finished.xml.find("option")
    said = {} if found is None else found.attrib
    if "timestep" not in said:
        yield "state the time step: scene.option.timestep"
    if said.get("integrator") not in ("implicitfast", "implicit"):
        yield "use the integrator implicitfast: scene.option.integrator"
