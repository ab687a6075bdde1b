"""What is seen of each part of a robot, read from its source without the product's own code."""

from collections.abc import Mapping
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

Seen = Mapping[tuple[str, str], trimesh.Trimesh]
"""By link and name of the part: its surface in the frame of the link."""


def of_urdf(path: Path) -> Seen:
    """The meshes of a URDF's visuals, by their number in the link."""
    found = {}
    for link in ElementTree.parse(path).getroot().iterfind("link"):
        for number, visual in enumerate(link.iterfind("visual"), 1):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            name = mesh.attrib["filename"].removeprefix("package://").lstrip("/")
            surface = trimesh.load(path.parent / name, force="mesh", process=False)
            surface.apply_transform(_origin(visual.find("origin")))
            found[link.attrib["name"], f"{link.attrib['name']}/visual {number}"] = surface
    return found


def _origin(element: ElementTree.Element | None) -> np.ndarray:
    pose = np.eye(4)
    if element is not None:
        xyz, rpy = ([float(x) for x in element.get(name, "0 0 0").split()] for name in ("xyz", "rpy"))
        pose[:3, :3], pose[:3, 3] = Rotation.from_euler("xyz", rpy).as_matrix(), xyz
    return pose
