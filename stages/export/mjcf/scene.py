"""scene.xml: the robot in a small world, with a floor, light and sky, ready for a viewer."""

import numpy as np

from stages.export.keys import ExportKeys
from stages.export.mjcf.placement import placement
from stages.formats.numbers import spaced
from stages.formats.xml import element, to_bytes
from stages.robot.model import Robot
from stages.robot.poses import from_parts, rotation_from_rpy


def write_scene(robot: Robot, keys: ExportKeys) -> bytes:
    """The scene around `<name>.xml`, which it includes."""
    root = element(None, "mujoco", model=f"{robot.name}_scene")
    element(root, "include", file=f"{robot.name}.xml")
    visual = element(root, "visual")
    element(visual, "headlight", diffuse="0.6 0.6 0.6", ambient="0.3 0.3 0.3", specular="0 0 0")
    element(visual, "rgba", haze="0.15 0.25 0.35 1")
    element(visual, "global", azimuth="140", elevation="-20")
    asset = element(root, "asset")
    element(
        asset,
        "texture",
        type="skybox",
        builtin="gradient",
        rgb1="0.3 0.5 0.7",
        rgb2="0 0 0",
        width="512",
        height="3072",
    )
    world = element(root, "worldbody")
    element(world, "light", pos="0 0 2.5", dir="0 0 -1", type="directional")
    ground = keys.ground
    if ground.kind == "plane":
        element(
            asset,
            "texture",
            type="2d",
            name="checker",
            builtin="checker",
            mark="edge",
            rgb1="0.2 0.3 0.4",
            rgb2="0.1 0.2 0.3",
            markrgb="0.8 0.8 0.8",
            width="300",
            height="300",
        )
        element(
            asset,
            "material",
            name="checker",
            texture="checker",
            texuniform="true",
            texrepeat="5 5",
            reflectance="0.2",
        )
        pose = from_parts(rotation_from_rpy(ground.rpy), np.array(ground.xyz))
        element(
            world,
            "geom",
            name="floor",
            type="plane",
            size=f"{spaced(np.array(ground.size) / 2)} 0.05",
            friction=spaced(ground.friction),
            material="checker",
            **placement(pose),
        )
    return to_bytes(root)
