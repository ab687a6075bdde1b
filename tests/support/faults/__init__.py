"""The table of the faults that tests plant, `kind, plant, expects`, by the file in which they are.

`BUILD`: those of a finished build, which its checks know; `BARE`: those of a URDF or MJCF that comes alone.
"""

from tests.support.faults import assets, bare, mjcf, mjcf_world, python, ros2, scene, sdf, srdf, urdf, usd

BUILD = [
    *urdf.FAULTS,
    *mjcf.BODIES,
    *mjcf_world.FAULTS,
    *mjcf.SHAPES,
    *scene.FAULTS,
    *assets.FAULTS,
    *sdf.SHAPES,
    *srdf.FAULTS,
    *usd.FAULTS,
    *sdf.CONFIG,
    *ros2.FAULTS,
    *python.FAULTS,
]

BARE = bare.FAULTS
