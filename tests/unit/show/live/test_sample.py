"""The pack of the sample robot, as its export writes it, without meshes."""

import re

import mujoco
import numpy as np
import pytest

from linkwright.stages.show.live import pack, source_of
from linkwright.stages.show.live.scene import pack_of
from tests.fake_onshape.sample import sample_document
from tests.support.building import plan_of, robot_of
from tests.support.building import write as export
from tests.support.live_robots import poses, times, turned


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sample")
    plan = plan_of(actuators={"*": {"type": "position"}})
    robot = robot_of(sample_document(), plan)
    export(robot, folder, plan)
    header, _ = pack.unpacked(pack_of(folder, "scene.xml", robot, (), 1000))
    return robot, header, mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def test_its_bodies_stand_where_mujoco_has_them(sample):
    _, header, model = sample
    data, draw = mujoco.MjData(model), np.random.default_rng(3)
    for _ in range(5):
        data.qpos[:] = draw.uniform(-1, 1, model.nq)
        mujoco.mj_kinematics(model, data)
        found = poses(header, data.qpos)
        np.testing.assert_allclose([place for place, _ in found], data.xpos, atol=1e-9)


def test_its_loops_are_closed_at_every_keyframe_and_open_elsewhere(sample):
    _, header, _ = sample
    assert header["keyframes"][0]["name"] == "home"
    assert len(header["loops"]) == 2, "a hinge is two points"
    for keyframe in header["keyframes"]:
        qpos = np.array(keyframe["qpos"])
        assert max(gaps(header, qpos)) < 1e-6
        assert max(gaps(header, qpos + 0.1)) > 1e-3


def gaps(header, qpos):
    where, found = poses(header, qpos), []
    for loop in header["loops"]:
        ends = []
        for body, frame in zip(loop["bodies"], (loop["a_from"], loop["b_from"]), strict=True):
            place, turn = where[body]
            ends.append(place + turned(turn, np.array(frame["pos"])))
        found.append(np.linalg.norm(ends[0] - ends[1]))
    return found


def test_the_frames_of_a_connect_have_one_orientation_at_home(sample):
    _, header, _ = sample
    where = poses(header, np.array(header["keyframes"][0]["qpos"]))
    for loop in header["loops"]:
        first, second = (
            times(where[body][1], np.array(frame["quat"]))
            for body, frame in zip(loop["bodies"], (loop["a_from"], loop["b_from"]), strict=True)
        )
        assert abs(first @ second) == pytest.approx(1, abs=1e-9)


def test_followers_are_on_their_relations_at_home(sample):
    robot, header, _ = sample
    assert len(header["relations"]) == len(robot.relations) == 1
    qpos = np.array(header["keyframes"][0]["qpos"])
    for relation in header["relations"]:
        follower, driver = (header["joints"][relation[name]] for name in ("follower", "driver"))
        way = qpos[driver["qpos"]] - driver["ref"]
        wanted = follower["ref"] + np.polyval(relation["polynomial"][::-1], way)
        assert qpos[follower["qpos"]] == pytest.approx(wanted, abs=1e-9)


def test_each_body_is_a_link_with_its_parts_and_each_actuator_drives_a_joint(sample):
    robot, header, _ = sample
    links = {link.name: link for link in robot.links}
    for body in header["bodies"][1:]:
        entry = header["links"][body["link"]]
        assert entry["name"] == body["name"]
        assert body["mass"] == pytest.approx(entry["mass"])
        assert [part["name"] for part in entry["parts"]] == [part.name for part in links[body["name"]].parts]
        assert sum(part["mass"] or 0 for part in entry["parts"]) == pytest.approx(entry["mass"])
    assert header["bodies"][0]["link"] is None
    joints = [header["joints"][one["joint"]]["name"] for one in header["actuators"]]
    assert joints == [one["name"] for one in header["actuators"]]
    assert {one["kind"] for one in header["actuators"]} == {"position"}
    assert {one["unit"] for one in header["actuators"]} == {"rad", "m"}
    assert len(header["keyframes"][0]["ctrl"]) == len(header["actuators"])
    assert header["engine"] is not None


@pytest.mark.parametrize("mimic", [True, False])
def test_of_a_urdf_the_robot_gives_the_poses_and_the_loops(mimic, tmp_path):
    plan = plan_of(export={"urdf": {}})
    robot = robot_of(sample_document(), plan)
    export(robot, tmp_path, plan)
    if not mimic:  # as readers do that know no mimics
        text = (tmp_path / "robot.urdf").read_text()
        (tmp_path / "robot.urdf").write_text(re.sub("<mimic[^>]*>", "", text))
    header, _ = pack.unpacked(pack_of(tmp_path, "robot.urdf", robot, (), 1000))
    joints = [joint["name"] for joint in header["joints"]]
    pairs = {(joints[one["follower"]], joints[one["driver"]]) for one in header["relations"]}
    assert {(one.follower, one.driver) for one in robot.relations} <= pairs
    assert [one["name"] for one in header["keyframes"]] == ["home", "cad"]
    assert [one["type"] for one in header["loops"]] == ["connect", "connect"]
    qpos = np.array(header["keyframes"][0]["qpos"])
    assert max(gaps(header, qpos)) < 1e-6
    moved = [joint["qpos"] for joint in header["joints"] if joint["name"] == "rod_lower_pivot"]
    qpos[moved] += 0.1
    assert min(gaps(header, qpos)) > 1e-3


def test_a_urdf_in_a_ros_package_is_shown_too(tmp_path):
    plan = plan_of(export={"ros2": {}})
    robot = robot_of(sample_document(), plan)
    export(robot, tmp_path, plan)
    files = [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()]
    source = source_of(files, robot.name)
    assert source.endswith(".urdf")
    assert "/" in source
    header, _ = pack.unpacked(pack_of(tmp_path, source, robot, (), 1000))
    links = {body["name"] for body in header["bodies"]}
    assert {link.name for link in robot.links} <= links
