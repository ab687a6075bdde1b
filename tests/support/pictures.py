"""Pictures in tests: their pixels, what in them is the robot, and MuJoCo's own by a graphics driver."""

import json
import os
import struct
import subprocess
import sys
import zlib

import numpy as np

from linkwright.stages.formats import png

_BY_DRIVER = """
import json, sys
import mujoco, numpy as np
asked = json.load(sys.stdin)
spec = mujoco.MjSpec.from_string(asked["xml"]) if "xml" in asked else mujoco.MjSpec.from_file(asked["path"])
spec.worldbody.add_camera(name="here", pos=asked["position"], quat=asked["quat"], fovy=asked["fovy"])
getattr(spec.visual, "global").offwidth, getattr(spec.visual, "global").offheight = asked["size"]
model = spec.compile()
data = mujoco.MjData(model)
home = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, "home")
if home >= 0:
    mujoco.mj_resetDataKeyframe(model, data, home)
mujoco.mj_forward(model, data)
options = mujoco.MjvOption()
options.geomgroup[:] = [group in asked["groups"] for group in range(6)]
options.sitegroup[:] = 0
renderer = mujoco.Renderer(model, asked["size"][1], asked["size"][0])
renderer.enable_segmentation_rendering()
renderer.update_scene(data, "here", scene_option=options)
seen = renderer.render()
is_geom = seen[:, :, 1] == int(mujoco.mjtObj.mjOBJ_GEOM)
plane = [g for g in range(model.ngeom) if int(model.geom_type[g]) == int(mujoco.mjtGeom.mjGEOM_PLANE)]
np.save(asked["to"], is_geom & ~np.isin(seen[:, :, 0], plane))
"""


def pixels_of(data):
    """(height, width, 3) of a PNG of ours, whose rows are differences from those above."""
    assert png.problem(data) == ""
    width, height = struct.unpack_from(">II", data, 16)
    (length,) = struct.unpack_from(">I", data, 33)
    rows = np.frombuffer(zlib.decompress(data[41 : 41 + length]), np.uint8).reshape(height, 1 + 3 * width)
    return np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(height, width, 3)


def robot_in(pixels):
    """(height, width): where a picture is coloured, which neither its ground nor a shadow is; for robots of
    strong colours."""
    values = pixels.astype(int)
    return values.max(axis=2) - values.min(axis=2) > 25


def silhouette_by_driver(to, position, quat, fovy, size, **model):
    """(height, width): where MuJoCo sees the robot of `xml` or `path`, by a camera; None without a working
    graphics driver."""
    asked = {
        "position": list(map(float, position)),
        "quat": list(map(float, quat)),
        "fovy": fovy,
        "size": size,
        "to": str(to / "silhouette.npy"),
        "groups": [0, 1, 2],
        **model,
    }
    done = subprocess.run(
        [sys.executable, "-c", _BY_DRIVER],
        input=json.dumps(asked),
        env={**os.environ, "MUJOCO_GL": os.environ.get("MUJOCO_GL", "egl")},
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
        cwd=to,
    )
    return np.load(asked["to"]) if done.returncode == 0 else None
