"""MJCFs through the installed command: a real arm, a bundle, and files that no one can read."""

import shutil

import mujoco
import numpy as np
import pytest

from tests.support.cases import mostly_slow
from tests.support.command import called, linkwright, report_of, robot_files, tree
from tests.support.mjcfs import body, model, written
from tests.support.other_robots import AS_IT_IS
from tests.support.places import SHARED

SO101 = SHARED / "data/robots/so101/Simulation/SO101"
PLACE = "scene.pose={xyz: [0, 0, 0]}"
"""The robot where the file has it, not standing on the ground."""

REAL = pytest.mark.skipif(not SO101.exists(), reason="needs the real robots in ../shared")


@pytest.mark.slow
@REAL
@pytest.mark.parametrize("name", ["scene.xml", "so101_old_calib.xml"])
def test_a_real_arm_passes_every_check_and_moves_as_it_did(tmp_path, name):
    out, path = tmp_path / "out", SO101 / name
    linkwright(tmp_path, *from_file(path), "output=out", "mesh=hull", PLACE, *AS_IT_IS, status=0)
    checks = report_of(out)["checks"]
    assert checks
    assert [check for check in checks if not check["passed"] and check["level"] == "error"] == []
    files = [
        path for path in out.iterdir() if path.is_file() and path.name not in ("config.yaml", "build.log")
    ]
    assert not [path.name for path in files if str(SO101) in path.read_text(errors="ignore")]
    original, again = (mujoco.MjModel.from_xml_path(str(file)) for file in (path, mjcf_in(out)))
    was, now = mujoco.MjData(original), mujoco.MjData(again)
    assert (again.nv, again.nbody) == (original.nv, original.nbody)
    random = np.random.default_rng(1)
    for _ in range(3):
        was.qpos[:] = now.qpos[:] = random.uniform(-1.5, 1.5, original.nq)
        was.qvel[:] = now.qvel[:] = random.uniform(-1, 1, original.nv)
        for compiled, data in ((original, was), (again, now)):
            mujoco.mj_forward(compiled, data)
        for field in ("xpos", "xipos", "qfrc_bias", "qfrc_passive"):
            np.testing.assert_allclose(getattr(now, field), getattr(was, field), atol=1e-9, err_msg=field)
        np.testing.assert_allclose(full(again, now), full(original, was), atol=1e-9)
    np.testing.assert_allclose(again.jnt_range, original.jnt_range, atol=1e-9)


@pytest.mark.slow
@REAL
def test_a_real_arm_keeps_its_keyframes(tmp_path):
    """The file has none, so some are added to a copy of it, as typed: four digits, within the limits."""
    shutil.copytree(SO101, tmp_path / "arm")
    source = tmp_path / "arm" / "keyed.xml"
    text = (SO101 / "so101_new_calib.xml").read_text()
    low, high = mujoco.MjModel.from_xml_path(str(SO101 / "so101_new_calib.xml")).jnt_range.T
    poses = {"home": 0.3, "ready": 0.5, "tucked": 0.8}
    rows = {name: low + share * (high - low) for name, share in poses.items()}
    keys = "".join(
        f'<key name="{name}" qpos="{" ".join(f"{v:.4f}" for v in row)}"/>' for name, row in rows.items()
    )
    source.write_text(text.replace("</mujoco>", f"<keyframe>{keys}</keyframe></mujoco>"))
    linkwright(tmp_path, *from_file(source), "output=out", "mesh=hull", status=0)
    files = (source, mjcf_in(tmp_path / "out"))
    original, again = (mujoco.MjModel.from_xml_path(str(path)) for path in files)
    joints = [again.joint(index).name for index in range(again.njnt)]
    for name in poses:
        was = [original.key(name).qpos[original.joint(joint).qposadr[0]] for joint in joints]
        assert again.key(name).qpos.tolist() == was


def from_file(path):
    return "source=mjcf", f"source.path={path}"


def mjcf_in(folder):
    (path,) = [path for path in folder.glob("*.xml") if path.name != "scene.xml"]
    return path


def full(compiled, data):
    """The mass matrix."""
    matrix = np.zeros((compiled.nv, compiled.nv))
    for column, unit in zip(matrix, np.eye(compiled.nv), strict=True):
        mujoco.mj_mulM(compiled, data, column, unit)
    return matrix


BALL = '<geom size=".1" rgba=".2 .4 .6 1"/>'
ARM = model(body("base", BALL + body("arm", BALL + '<joint name="elbow" range="-1 1"/>', pos="0 0 .5")))


@pytest.mark.slow
def test_bundle_of_an_mjcf_builds_the_same_bytes_elsewhere(tmp_path):
    (tmp_path / "mine").mkdir()
    written(tmp_path / "mine", ARM, "arm.xml")
    linkwright(tmp_path, *from_file("mine/arm.xml"), status=0)
    first = robot_files(tmp_path / "outputs" / "arm")
    linkwright(tmp_path, *from_file("mine/arm.xml"), status=0)
    assert all(stage["cached"] for stage in report_of(tmp_path / "outputs" / "arm")["stages"])
    linkwright(tmp_path, "bundle", "arm", "arm.zip", status=0)
    (tmp_path / "away").mkdir()
    (tmp_path / "arm.zip").rename(tmp_path / "away" / "arm.zip")
    linkwright(tmp_path / "away", "source=bundle", "source.path=arm.zip", status=0)
    assert robot_files(tmp_path / "away" / "outputs" / "arm") == first


def test_scene_is_named_after_its_folder_and_read_when_changed(tmp_path):
    (tmp_path / "gripper").mkdir()
    for text in (ARM, ARM.replace("-1 1", "-2 1")):
        written(tmp_path / "gripper", text, "scene.xml")
        called(tmp_path, *from_file("gripper/scene.xml"), "until=graph", status=0)
        assert not report_of(tmp_path / "outputs" / "gripper.graph")["stages"][0]["cached"]


ENTITIES = ARM.replace("<mujoco", '<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><mujoco')
UNREADABLE = {
    "absent": (None, 2, "does not exist"),
    "not XML": ("hello", 1, "not XML"),
    "no mesh": (
        ARM.replace("<worldbody>", '<asset><mesh file="gone.stl"/></asset><worldbody>'),
        1,
        "gone.stl",
    ),
    "circle": ('<mujoco><include file="arm.xml"/></mujoco>', 1, "already included"),
    "nan": (model(body("a", pos="nan 0 0")), 1, "NaN"),
    "deep": ("<mujoco>" + "<worldbody>" * 10_000, 1, "too deep"),
    "long": ('<mujoco model="' + "a" * 50_000_000 + '"/>', 1, "longer than 32 MB"),
    "entities": (ENTITIES.replace("made up", "&b;"), 0, ""),
}


@pytest.mark.parametrize("name", mostly_slow(UNREADABLE, keep=3))
def test_an_unreadable_mjcf_is_one_message_at_once(tmp_path, name):
    text, status, words = UNREADABLE[name]
    if text is not None:
        written(tmp_path, text, "arm.xml")
    done = called(tmp_path, *from_file("arm.xml"), "until=graph", status=status)
    assert words in done.stderr
    assert not [word for word in ("Traceback", str(tmp_path)) if word in done.stderr]
    assert done.stderr.count("error:") == (status > 0)
    assert "MUJOCO_LOG.TXT" not in tree(tmp_path)
