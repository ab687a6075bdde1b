"""Faults to plant in a finished build: `KINDS`, by the file in which they are."""

from tests.support.mutations import (
    assets,
    mjcf_joints,
    mjcf_shapes,
    mjcf_world,
    model_config,
    python,
    ros2,
    scene,
    sdf,
    srdf,
    urdf_joints,
    urdf_links,
    usd,
)

KINDS = [
    *urdf_joints.KINDS,
    *urdf_links.KINDS,
    *mjcf_joints.KINDS,
    *mjcf_world.KINDS,
    *mjcf_shapes.KINDS,
    *scene.KINDS,
    *assets.KINDS,
    *sdf.KINDS,
    *srdf.KINDS,
    *usd.KINDS,
    *model_config.KINDS,
    *ros2.KINDS,
    *python.KINDS,
]
