"""Robots that collide with themselves, in MuJoCo: at `home` and in a thousand random poses nothing touches
that is neither excluded with a reason nor free to touch."""

import re

import mujoco
import numpy as np
import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.stages.robot import codec
from linkwright.stages.robot.motion.pose_samples import sampled_poses
from linkwright.stages.robot.motion.start_pose import home
from tests.support import kept_colliders
from tests.support.other_robots import AS_IT_IS
from tests.support.places import SHARED
from tests.support.touching import geoms_in_mujoco, in_mujoco

ROBOTS = SHARED / "data" / "robots"
SO101 = ROBOTS / "so101/Simulation/SO101/so101_new_calib.urdf"
DUCK = ROBOTS / "open_duck_mini_bdx/mini_bdx/robots/bdx/robot.urdf"
REACHY = ROBOTS / "reachy2/reachy2_mujoco/description/mjcf/reachy2.xml"

FOUND = {
    "sample": [("base_plate", "lift_column", "Adjacent"), ("parallel_rod", "elbow_plate", "Adjacent")],
    "ladder": [("left_finger_jaw", "right_finger_jaw", "Always")],
    "so101": [("base_link", "shoulder_link", "Adjacent")],
    "duck": [("head_link", "head_assembly", "Always")],
    "reachy": [],
}
"""By robot: some of the pairs that it must have."""

COMPARED = 100
"""In so many of the poses all contacts are looked for: of hulls deep in each other that takes long."""

WHERE = {"so101": ("urdf", SO101), "duck": ("urdf", DUCK), "reachy": ("mjcf", REACHY)}


def built(name: str, folder):
    """The robot, its report, and its model; and a model with every contact, whatever is excluded. `ladder`:
    the sample, with the colliders that the ladder makes; else each link has its hull."""
    kept_colliders.seed(folder / "cache")
    told = [f"cache.dir={folder}/cache", f"output={folder}/out", "until=export"]
    told.append("mesh=ladder" if name == "ladder" else "mesh=hull")
    if name in ("sample", "ladder"):
        told.append("robot=sample")
    else:
        kind, path = WHERE[name]
        if not path.exists():
            pytest.skip("needs the robots of others")
        told += [f"source={kind}", f"source.path={path}", *AS_IT_IS]
    made = build_files(compose_plan(told, cwd=folder).plan, in_memory=True)
    files = {path: data for path, data in made.files.items() if path.startswith("assets/")}
    (file,) = [path for path in made.files if path.endswith(".xml") and path != "scene.xml"]
    text = made.files[file].decode()
    free = re.sub(r"<contact>.*?</contact>", "", text, flags=re.DOTALL)
    free = free.replace("<option ", "<option><flag filterparent='disable'/></option><option ")
    free = re.sub(r'contype="[1-9]\d*" conaffinity="[1-9]\d*"', 'contype="1" conaffinity="1"', free)
    meshes = {path.removeprefix("assets/"): data for path, data in files.items()}
    models = [mujoco.MjSpec.from_string(one, assets=assets(one, meshes)).compile() for one in (text, free)]
    return codec.decode_robot(made.robot), made.report, *models


def assets(text: str, meshes):
    return {f"assets/{name}": data for name, data in meshes.items()} | dict(meshes)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["sample", "ladder", *WHERE])
def test_nothing_touches_that_is_neither_excluded_nor_free_to(name, tmp_path):
    robot, report, model, free = built(name, tmp_path)
    rows = {tuple(one["links"]): one for one in report.details.get("excludes", [])}
    excludes = {pair: row["reason"] for pair, row in rows.items()}

    def excluded(one, other):
        row = rows.get((one[0], other[0]))
        return row is not None and (not row["geoms"] or [one[1], other[1]] in row["geoms"])

    for one, other, reason in FOUND[name]:
        assert excludes[one, other] == reason
    start = home(robot)
    values = sampled_poses(robot, 1000, 0.3, start)
    poses = [{n: float(v[i]) if v.ndim == 1 else tuple(v[i]) for n, v in values.items()} for i in range(1000)]
    rigid = {pair for pair, reason in excludes.items() if reason == "Adjacent"}
    seen = dict.fromkeys(excludes, 0)
    for q in poses:
        assert not [pair for pair in geoms_in_mujoco(model, robot, q) if excluded(*pair)]
    for q in poses[:COMPARED]:
        raw = geoms_in_mujoco(free, robot, q)
        assert geoms_in_mujoco(model, robot, q) == {pair for pair in raw if not excluded(*pair)}
        for pair in {(one[0], other[0]) for one, other in raw if excluded(one, other)}:
            seen[pair] += 1
    for pair, reason in excludes.items():
        assert reason != "Always" or seen[pair] >= 0.99 * COMPARED, pair
    told = " ".join(one.message for one in report.diagnostics if one.code == "W-SELF-CONTACT")
    for one, other in in_mujoco(model, robot, start):
        assert f"{one} and {other} (" in told
        assert [one, other] in [row["links"] for row in report.details["touching"]]
    # An MJCF says itself what collides: here the trunk, the wrists and a finger, all with each other.
    assert rigid or not robot.joints or robot.mjcf is not None
    assert np.isfinite(model.key_qpos).all()
