"""The points that the text of the files shows."""

import hashlib
import re

import mujoco
import numpy as np
from lxml import etree

FACES = 200_000
"""Faces that MuJoCo reads of an STL."""

NUMBER = re.compile(r"-?\d+(\.\d+)?([eE][-+]?\d+)?")
WRITTEN = 1e-5
"""MuJoCo writes numbers with six digits."""

NOISE = 1e-12
"""A number below this share of the largest of its attribute is noise."""


def the_robot_alone(built):
    """2: the robot's file has no world; the scene has it all."""
    for element in built.xml.find("worldbody"):
        if element.tag in ("light", "camera"):
            yield f"<{element.tag}> in the robot's world"
        if element.tag == "geom" and element.get("type") == "plane":
            yield "a floor in the robot's file"
    scene = built.scene_xml
    if scene.find("include").get("file") != built.path.name:
        yield "the scene does not include the robot"
    for tag in ("worldbody/light", "worldbody/geom[@type='plane']", "asset/texture[@type='skybox']"):
        if scene.find(tag) is None:
            yield f"the scene has no {tag}"


def paths(built):
    """3: relative paths of files that are there; each file is used."""
    compiler = built.xml.find("compiler")
    if compiler.get("angle") != "radian":
        yield "angles are not in radians"
    if compiler.get("autolimits") == "false":
        yield "autolimits is off"
    folder = compiler.get("meshdir", "")
    used = set()
    for element in built.xml.iterfind("asset/*[@file]"):
        file = f"{folder}/{element.get('file')}"
        used.add(file)
        if file.startswith("/") or ".." in file or "://" in file:
            yield f"{file}: not a path below the model's folder"
        if not (built.folder / file).exists():
            yield f"{file}: not there"
    urdf = built.folder / f"{built.robot['name']}.urdf"
    if urdf.exists():
        used |= {mesh.get("filename") for mesh in etree.parse(str(urdf)).iterfind(".//mesh")}
    there = {str(path.relative_to(built.folder)) for path in (built.folder / "assets").glob("*")}
    materials = {file for file in there if file.endswith((".mtl", ".png"))}
    for file in sorted(there - used - materials):
        yield f"{file}: nothing uses it"


def classes(built):
    """4: classes for what is seen and what collides; geoms repeat nothing that these say."""
    (root,) = built.xml.findall("default/default")
    names = {default.get("class") for default in root.iterfind("default")}
    if not root.get("class") or not {"visual", "collision"} <= names:
        yield f"classes are {root.get('class')}: {names}"
    for geom in built.xml.iterfind(".//worldbody//geom"):
        if geom.get("class") is None:
            yield f"a geom without a class: {dict(geom.attrib)}"
        for key in ("contype", "conaffinity", "group", "density", "mass"):
            if key in geom.attrib:
                yield f"{geom.get('name')}: {key} is said by the geom"
    for joint in built.xml.iterfind(".//worldbody//joint"):
        if joint.get("class") is None and len(built.xml.findall(".//worldbody//joint")) > 1:
            yield f"{joint.get('name')}: no class"


def nothing_twice(built):
    """4: no attribute repeats what the element's class says."""
    said = {}

    def read(element, above):
        name = element.get("class")
        for child in element:
            if child.tag != "default":
                inherited = said.get((above, child.tag), {}) if above else {}
                said[name, child.tag] = {**inherited, **child.attrib}
        if above:
            for (of, tag), attributes in list(said.items()):
                if of == above:
                    said.setdefault((name, tag), attributes)
        for child in element.iterfind("default"):
            read(child, name)

    for root in built.xml.iterfind("default/default"):
        read(root, None)
    for element in built.xml.iterfind("*//*[@class]"):
        for key, value in said.get((element.get("class"), element.tag), {}).items():
            if element.tag != "default" and element.get(key) == value:
                yield f"{element.tag} {element.get('name')}: {key} is that of its class"


def inertials(built):
    """7 and 11: each body says its inertia, and all by the same convention."""
    spellings = set()
    for body in built.xml.iterfind(".//worldbody//body"):
        inertial = body.find("inertial")
        if inertial is None:
            yield f"{body.get('name')}: no <inertial>"
            continue
        spellings |= {"diaginertia", "fullinertia"} & set(inertial.attrib)
        quat = np.array([float(part) for part in inertial.get("quat", "1 0 0 0").split()])
        if quat[0] < 0 or abs(np.linalg.norm(quat) - 1) > 1e-9:
            yield f"{body.get('name')}: the inertia's quat is {quat}"
    if len(spellings) > 1:
        yield "some inertias are diagonal, some are full"


def orders(built):
    """18: actuators are named by their joints, in the tree's order, which the URDF's joints have too; an
    MJCF's are in its own order."""
    tree = [joint.get("name") for joint in built.xml.iterfind(".//worldbody//joint")]
    driven = [(element.get("name"), element.get("joint")) for element in built.xml.iterfind("actuator/*")]
    for name, joint in driven:
        if not name.startswith(joint):
            yield f"actuator {name} drives {joint}"
    places = [tree.index(joint) for _, joint in driven]
    if places != sorted(places) and not built.as_its_file:
        yield f"actuators are not in the tree's order: {driven}"
    urdf = etree.parse(str(built.folder / f"{built.robot['name']}.urdf")).getroot()
    both = [joint.get("name") for joint in urdf.iterfind("joint") if joint.get("name") in tree]
    if both != [name for name in tree if name in both]:
        yield "the URDF's joints come in another order"


def assets(built):
    """25: STL files that MuJoCo reads whole, none twice."""
    digests = {}
    for path in sorted((built.folder / "assets").glob("*")):
        data = path.read_bytes()
        first = digests.setdefault(hashlib.sha256(data).hexdigest(), path.name)
        if first != path.name:
            yield f"{path.name} is {first} again"
        if path.suffix == ".stl":
            faces = int.from_bytes(data[80:84], "little")
            if len(data) != 84 + 50 * faces or not 0 < faces <= FACES:
                yield f"{path.name}: {faces} faces in {len(data)} bytes"


def materials(built):
    """26: colours are named materials, shared."""
    colours = [material.get("rgba") for material in built.xml.iterfind("asset/material[@rgba]")]
    if len(colours) != len(set(colours)):
        yield "two materials of one colour"
    for geom in built.xml.iterfind(".//worldbody//geom"):
        if geom.get("rgba") is not None:
            yield f"{geom.get('name') or geom.get('mesh')}: a colour without a name"


def numbers(built):
    """33: no noise beside large numbers, no negative zero."""
    for element in (*built.xml.iter(), *built.scene_xml.iter()):
        for key, text in element.attrib.items():
            words = text.split()
            if not words or not all(NUMBER.fullmatch(word) for word in words):
                continue
            values = np.abs([float(word) for word in words])
            if any(word.startswith("-") and float(word) == 0 for word in words):
                yield f"{element.tag} {key}: {text}"
            if key != "qpos" and ((values > 0) & (values < NOISE * values.max())).any():
                yield f"{element.tag} {key}: {text}"


def round_trip(built):
    """34: what MuJoCo writes of the file compiles to the same model."""
    spec = mujoco.MjSpec.from_file(str(built.path))
    first = spec.compile()
    second = mujoco.MjSpec.from_string(spec.to_xml(), assets=_files(built)).compile()
    for key in ("nq", "nv", "nu", "nbody", "ngeom", "neq", "nsite", "nkey", "nexclude"):
        if getattr(first, key) != getattr(second, key):
            yield f"{key}: {getattr(first, key)} and {getattr(second, key)}"
            return
    for key in (
        "body_mass",
        "body_inertia",
        "body_pos",
        "jnt_range",
        "dof_armature",
        "geom_size",
        "key_qpos",
    ):
        first_value, other = getattr(first, key), getattr(second, key)
        apart = np.abs(first_value - other).max(initial=0.0)
        if apart > WRITTEN * max(1.0, np.abs(first_value).max(initial=0.0)):
            yield f"{key}: {apart}"


def _files(built):
    return {path.name: path.read_bytes() for path in (built.folder / "assets").glob("*")}


def derivation(built):
    """35: each parameter of a joint says where it comes from."""
    for name, dof in built.dofs.items():
        for key in ("damping", "friction", "armature", "effort", "velocity"):
            if dof.get(key) is not None and not dof["provenance"].get(key):
                yield f"{name}: nobody knows where its {key} is from"


POINTS = (
    the_robot_alone,
    paths,
    classes,
    nothing_twice,
    inertials,
    orders,
    assets,
    materials,
    numbers,
    round_trip,
    derivation,
)
