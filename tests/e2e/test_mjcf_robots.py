"""MJCFs through the installed command: a real arm, a bundle, and files that no one can read."""

import json
import shutil
from pathlib import Path

import mujoco
import numpy as np
import pytest

from tests.support.cases import mostly_slow
from tests.support.command import called, linkwright, robot_files, tree
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
def test_a_real_arm_passes_every_check_and_moves_as_it_did(tmp_path: Path, name: str) -> None:
    done = linkwright(
        tmp_path, "source=mjcf", f"source.path={SO101 / name}", "output=out", "mesh=hull", PLACE, *AS_IT_IS
    )
    assert done.returncode == 0, done.stdout + done.stderr
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    assert report["checks"]
    assert [one for one in report["checks"] if not one["passed"] and one["level"] == "error"] == []
    texts = [
        p for p in (tmp_path / "out").iterdir() if p.is_file() and p.name not in ("config.yaml", "build.log")
    ]
    assert not [path.name for path in texts if str(SO101) in path.read_text(errors="ignore")]
    (ours,) = [one for one in (tmp_path / "out").glob("*.xml") if one.name != "scene.xml"]
    original, again = (mujoco.MjModel.from_xml_path(str(path)) for path in (SO101 / name, ours))
    was, now = mujoco.MjData(original), mujoco.MjData(again)
    assert (again.nv, again.nbody) == (original.nv, original.nbody)
    random = np.random.default_rng(1)
    for _ in range(3):
        was.qpos[:] = now.qpos[:] = random.uniform(-1.5, 1.5, original.nq)
        was.qvel[:] = now.qvel[:] = random.uniform(-1, 1, original.nv)
        for compiled, data in ((original, was), (again, now)):
            mujoco.mj_forward(compiled, data)
        np.testing.assert_allclose(now.xpos, was.xpos, atol=1e-9)
        np.testing.assert_allclose(now.xipos, was.xipos, atol=1e-9)
        np.testing.assert_allclose(now.qfrc_bias, was.qfrc_bias, atol=1e-9)
        np.testing.assert_allclose(now.qfrc_passive, was.qfrc_passive, atol=1e-9)
        np.testing.assert_allclose(full(again, now), full(original, was), atol=1e-9)
    np.testing.assert_allclose(again.jnt_range, original.jnt_range, atol=1e-9)


@pytest.mark.slow
@REAL
def test_a_real_arm_keeps_its_keyframes(tmp_path: Path) -> None:
    """The file has none, so some are added to a copy of it, as typed: four digits, within the limits."""
    shutil.copytree(SO101, tmp_path / "arm")
    source = tmp_path / "arm" / "keyed.xml"
    text = (SO101 / "so101_new_calib.xml").read_text()
    low, high = mujoco.MjModel.from_xml_path(str(SO101 / "so101_new_calib.xml")).jnt_range.T
    poses = {"home": 0.3, "ready": 0.5, "tucked": 0.8}
    rows = {
        name: " ".join(f"{value:.4f}" for value in low + share * (high - low))
        for name, share in poses.items()
    }
    keys = "".join(f'<key name="{name}" qpos="{row}"/>' for name, row in rows.items())
    source.write_text(text.replace("</mujoco>", f"<keyframe>{keys}</keyframe></mujoco>"))
    done = linkwright(tmp_path, "source=mjcf", f"source.path={source}", "output=out", "mesh=hull")
    assert done.returncode == 0, done.stdout + done.stderr
    (ours,) = [one for one in (tmp_path / "out").glob("*.xml") if one.name != "scene.xml"]
    original, again = (mujoco.MjModel.from_xml_path(str(path)) for path in (source, ours))
    for name in poses:
        joints = [again.joint(index).name for index in range(again.njnt)]
        was = [original.key(name).qpos[original.joint(joint).qposadr[0]] for joint in joints]
        assert again.key(name).qpos.tolist() == was


def full(compiled: mujoco.MjModel, data: mujoco.MjData) -> np.ndarray:
    """The mass matrix."""
    matrix = np.zeros((compiled.nv, compiled.nv))
    for column, unit in zip(matrix, np.eye(compiled.nv), strict=True):
        mujoco.mj_mulM(compiled, data, column, unit)
    return matrix


BALL = '<geom size=".1" rgba=".2 .4 .6 1"/>'
ARM = model(body("base", BALL + body("arm", BALL + '<joint name="elbow" range="-1 1"/>', pos="0 0 .5")))


@pytest.mark.slow
def test_a_bundle_of_an_mjcf_builds_the_same_bytes_elsewhere_and_again(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    written(tmp_path / "mine", ARM, "arm.xml")
    assert linkwright(tmp_path, "source=mjcf", "source.path=mine/arm.xml").returncode == 0
    first = robot_files(tmp_path / "outputs" / "arm")
    again = linkwright(tmp_path, "source=mjcf", "source.path=mine/arm.xml")
    assert again.returncode == 0
    assert all(stage["cached"] for stage in stages(tmp_path / "outputs" / "arm"))
    done = linkwright(tmp_path, "bundle", "arm", "arm.zip")
    assert done.returncode == 0, done.stderr
    (tmp_path / "away").mkdir()
    (tmp_path / "arm.zip").rename(tmp_path / "away" / "arm.zip")
    done = linkwright(tmp_path / "away", "source=bundle", "source.path=arm.zip")
    assert done.returncode == 0, done.stderr
    assert robot_files(tmp_path / "away" / "outputs" / "arm") == first


def stages(folder: Path) -> list[dict]:
    return json.loads((folder / "report.json").read_text())["stages"]


@pytest.mark.slow
def test_a_changed_file_is_read_again(tmp_path: Path) -> None:
    written(tmp_path, ARM, "arm.xml")
    assert linkwright(tmp_path, "source=mjcf", "source.path=arm.xml", "until=graph").returncode == 0
    written(tmp_path, ARM.replace("-1 1", "-2 1"), "arm.xml")
    assert linkwright(tmp_path, "source=mjcf", "source.path=arm.xml", "until=graph").returncode == 0
    assert not stages(tmp_path / "outputs" / "arm.graph")[0]["cached"]


def test_a_scene_is_called_as_the_folder_it_is_in(tmp_path: Path) -> None:
    (tmp_path / "gripper").mkdir()
    written(tmp_path / "gripper", ARM, "scene.xml")
    done = called(tmp_path, "source=mjcf", "source.path=gripper/scene.xml", "until=graph")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "outputs" / "gripper.graph").is_dir()


@pytest.mark.parametrize(
    ("text", "status", "output_text"),
    mostly_slow(
        [
            (None, 2, "does not exist"),
            ("hello", 1, "not XML"),
            (ARM.replace("<worldbody>", '<asset><mesh file="gone.stl"/></asset><worldbody>'), 1, "gone.stl"),
            ('<mujoco><include file="arm.xml"/></mujoco>', 1, "already included"),
            (model(body("a", pos="nan 0 0")), 1, "NaN"),
            ("<mujoco>" + "<worldbody>" * 10_000, 1, "too deep"),
            ('<mujoco model="' + "a" * 50_000_000 + '"/>', 1, "longer than 32 MB"),
            (
                ARM.replace(
                    "<mujoco", '<!DOCTYPE m [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><mujoco'
                ).replace("made up", "&b;"),
                0,
                "",
            ),
        ],
        keep=3,
    ),
    ids=["absent", "not XML", "no mesh", "circle", "nan", "deep", "long", "entities"],
)
def test_what_cannot_be_read_is_one_message_at_once(
    tmp_path: Path, text: str | None, status: int, output_text: str
) -> None:
    if text is not None:
        written(tmp_path, text, "arm.xml")
    done = called(tmp_path, "source=mjcf", "source.path=arm.xml", "until=graph")
    assert done.returncode == status, done.stdout + done.stderr
    assert output_text in done.stderr
    assert "Traceback" not in done.stderr
    assert done.stderr.count("error:") == (status > 0)
    assert str(tmp_path) not in done.stderr
    assert "MUJOCO_LOG.TXT" not in tree(tmp_path)
