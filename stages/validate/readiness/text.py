"""Judges the points about the text of the files."""

import re
from collections.abc import Iterator
from contextlib import suppress

from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.readiness.finished import FinishedRobot, NotApplicable, has_noise

_NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")

NOISE_SHARE = 1e-12
"""Share of an attribute's largest number below which a number is noise."""

CLASS_ATTRIBUTES = ("contype", "conaffinity", "group", "density", "mass")
"""Attributes that belong into a geom's class, so that no geom repeats them."""


def the_robot_alone(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether ground, lights and sky are in scene.xml, and not in the robot's file."""
    for element in finished.xml.iterfind("worldbody/*"):
        if element.tag == "light" or (element.tag == "geom" and element.get("type") == "plane"):
            yield f"move <{element.tag}> from {finished.path.name} to scene.xml"
    scene = finished.scene
    if all(include.get("file") != finished.path.name for include in scene.iter("include")):
        yield f"let scene.xml include {finished.path.name}"
    for place, words in (
        ("worldbody/geom", "a ground: ground.kind"),
        (".//light", "a light: scene.lights"),
        ("asset/texture[@type='skybox']", "a sky"),
    ):
        if scene.find(place) is None:
            yield f"give scene.xml {words}"


def paths(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether angles are in radians, and every path leads to a file, and every asset is used."""
    compiler = finished.xml.find("compiler")
    settings = {} if compiler is None else compiler.attrib
    if settings.get("angle") != "radian":
        yield 'write <compiler angle="radian">'
    if settings.get("autolimits") == "false":
        yield "leave out autolimits"
    folder = settings.get("meshdir", "")
    files = (mesh.get("file") for mesh in _meshes(finished.xml))
    used = {f"{folder}/{file}" if folder else file for file in files}
    for file in sorted(used):
        if file.startswith("/") or ".." in file or "://" in file:
            yield f"{file} is no path below the model's folder"
        elif not (finished.folder / file).is_file():
            yield f"{file} is not there"
    existing = {
        path.relative_to(finished.folder).as_posix()
        for path in (finished.folder / "assets").glob("*")
        if path.suffix not in (".mtl", ".png")
    }
    with suppress(NotApplicable):
        used |= {_path_in_package(mesh.get("filename", "")) for mesh in finished.urdf.iterfind(".//mesh")}
    yield from (f"nothing uses {file}" for file in sorted(existing - used))


def _meshes(xml: Element) -> list[Element]:
    return [asset for asset in xml.iterfind("asset/*[@file]") if asset.tag == "mesh"]


def _path_in_package(path: str) -> str:
    """Returns a URDF's path without the package that it may begin with."""
    return path.removeprefix("package://").partition("/")[2] if path.startswith("package://") else path


def classes(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether geoms have classes, and leave to these what they have in common."""
    root = finished.xml.find("default/default")
    names = set() if root is None else {default.get("class") for default in root.iter("default")}
    if root is None or not root.get("class") or not {"visual", "collision"} <= names:
        yield "write a root default class with the classes visual and collision"
    bare, repeated = 0, set[str]()
    for geom in finished.xml.iterfind(".//worldbody//geom"):
        bare += geom.get("class") is None
        repeated |= {key for key in CLASS_ATTRIBUTES if key in geom.attrib}
    if bare:
        yield f"give {bare} geoms a class"
    if repeated:
        yield f"let classes say {', '.join(sorted(repeated))}, not geoms"


def inertials(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether each body has an inertial, and no geom has a mass."""
    for body in finished.xml.iterfind(".//worldbody//body"):
        if body.find("inertial") is None:
            yield f"write the inertia of {body.get('name')}"
    geoms = finished.xml.iterfind(".//worldbody//geom")
    massive = {geom.get("name", "a geom") for geom in geoms if float(geom.get("mass", 0.0)) > 0}
    if massive:
        yield f"{', '.join(sorted(massive))} have a mass of their own beside the inertia"


def inertia_convention(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether all inertias have the same form."""
    forms = set()
    for inertial in finished.xml.iterfind(".//worldbody//body/inertial"):
        forms |= {"diaginertia", "fullinertia"} & set(inertial.attrib)
    if len(forms) > 1:
        yield "write all inertias as diaginertia and quat, or all as fullinertia"


def order(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether actuators have the names of their joints, and all files the same order."""
    tree = [joint.get("name") for joint in finished.xml.iterfind(".//worldbody//joint")]
    actuators = finished.xml.iterfind("actuator/*[@joint]")
    driven = [(actuator.get("name"), actuator.get("joint")) for actuator in actuators]
    for name, joint in driven:
        if not (name or "").startswith(joint):
            yield f"name the actuator {name} by its joint {joint}"
    places = [tree.index(joint) for _, joint in driven if joint in tree]
    if places != sorted(places):
        yield "write the actuators in the order of the joints"
    try:
        urdf = [joint.get("name") for joint in finished.urdf.iterfind("joint") if joint.get("name") in tree]
    except NotApplicable:
        return
    if urdf != [name for name in tree if name in urdf]:
        yield "write the URDF's joints in the MJCF's order"


def materials(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether geoms have materials, and no two materials have the same colour."""
    with_colour = finished.xml.iterfind("asset/material[@rgba]")
    colours = [material.get("rgba") for material in with_colour if not material.get("texture")]
    if len(colours) != len(set(colours)):
        yield "share the materials of one colour"
    coloured = [geom for geom in finished.xml.iterfind(".//worldbody//geom") if geom.get("rgba") is not None]
    if coloured:
        yield f"give {len(coloured)} geoms a material in place of a colour"


def numbers(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether numbers have neither noise nor negative zeros."""
    for element in finished.xml.iter():
        for key, text in element.attrib.items():
            words = text.split()
            if not words or not all(_NUMBER.fullmatch(word) for word in words):
                continue
            zero = any(word.startswith("-") and float(word) == 0 for word in words)
            if zero or (key != "qpos" and has_noise([float(word) for word in words], NOISE_SHARE)):
                yield f'{element.tag} {element.get("name", "")}: {key}="{text}" has noise, or a negative zero'


def option(finished: FinishedRobot) -> Iterator[str]:
    """Judges whether the time step and an implicit integrator are stated."""
    element = finished.xml.find("option")
    settings = {} if element is None else element.attrib
    if "timestep" not in settings:
        yield "state the time step: scene.option.timestep"
    if settings.get("integrator") not in ("implicitfast", "implicit"):
        yield "use the integrator implicitfast: scene.option.integrator"
