"""The visual triangles of each part of a robot, read from its source without the product's own code.

By link, in the order of the source: the name of each mesh, and the mesh in the link's frame.
"""

import re
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from tests.support.fidelity import mesh_of


def of_urdf(path):
    """The meshes of a URDF's visuals."""
    parts = {}
    for link in ElementTree.parse(path).getroot().iterfind("link"):
        for visual in link.iterfind("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is not None:
                name = mesh.attrib["filename"].removeprefix("package://").lstrip("/")
                surface = trimesh.load(path.parent / name, force="mesh", process=False)
                surface.apply_transform(_origin(visual.find("origin")))
                parts.setdefault(link.attrib["name"], []).append((Path(name).stem, surface))
    return parts


def _origin(element):
    pose = np.eye(4)
    if element is not None:
        xyz, rpy = ([float(x) for x in element.get(name, "0 0 0").split()] for name in ("xyz", "rpy"))
        pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return pose


def of_mjcf(path):
    """The meshes of an MJCF that do not collide."""
    model = mujoco.MjModel.from_xml_path(str(path))
    parts = {}
    for geom in range(model.ngeom):
        seen = not model.geom_contype[geom] and not model.geom_conaffinity[geom]
        if seen and model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_MESH:
            name = model.mesh(model.geom_dataid[geom]).name
            body = model.body(model.geom_bodyid[geom]).name
            parts.setdefault(body, []).append((name, mesh_of(model, geom)))
    return parts


def meshes_of_parts(path):
    """The meshes that are seen in an MJCF with one for each part and colour (`mesh.visual.merge=part`), those
    of one part together."""
    surfaces = {}
    for link, meshes in of_mjcf(path).items():
        parts = {}
        for name, mesh in meshes:
            word = re.sub(r"__\d+$", "", name.removeprefix(f"{link}_"))
            parts.setdefault(word, []).append(mesh)
        surfaces[link] = [(name, trimesh.util.concatenate(every)) for name, every in parts.items()]
    return surfaces


def chosen(seen, link, part):
    """The mesh of a part by the name that a report gives it: its number among the link's visuals, its own
    number among the geoms of an MJCF, or its name in CAD."""
    own = part.rpartition("/")[2]
    numbered = re.fullmatch(r"visual (\d+)", own)
    if numbered:
        return seen[link][int(numbered[1]) - 1]
    word = re.sub(r"\W+", "_", own.lower()).strip("_").removesuffix("_1")
    (found,) = [part for part in seen[link] if part[0] == word]
    return found
