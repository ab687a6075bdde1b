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
from tests.support.live_robots import frames_of


@pytest.fixture(scope="module")
def sample(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sample")
    plan = plan_of(actuators={"*": {"type": "position"}})
    robot = robot_of(sample_document(), plan)
    export(robot, folder, plan)
    header, _ = pack.read_pack(pack_of(folder, "scene.xml", robot, (), 1000))
    return robot, header, mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def gaps(header, qpos):
    ends = [tuple(frames_of(header, qpos, loop)) for loop in header["loops"]]
    return [np.linalg.norm(first[0] - second[0]) for first, second in ends]


def test_loops_are_closed_at_every_keyframe_and_open_elsewhere(sample):
    _, header, _ = sample
    assert header["keyframes"][0]["name"] == "home"
    assert len(header["loops"]) == 2, "a hinge is two points"
    for keyframe in header["keyframes"]:
        qpos = np.array(keyframe["qpos"])
        assert max(gaps(header, qpos)) < 1e-6
        assert max(gaps(header, qpos + 0.1)) > 1e-3
    # The frames of a connect have one orientation at home.
    for loop in header["loops"]:
        (_, first), (_, second) = frames_of(header, np.array(header["keyframes"][0]["qpos"]), loop)
        assert abs(first @ second) == pytest.approx(1, abs=1e-9)


def test_followers_are_on_their_relations_at_home(sample):
    robot, header, _ = sample
    assert len(header["relations"]) == len(robot.relations) == 1
    qpos = np.array(header["keyframes"][0]["qpos"])
    for relation in header["relations"]:
        follower, driver = (header["joints"][relation[name]] for name in ("follower", "driver"))
        way = qpos[driver["qpos"]] - driver["ref"]
        expected = follower["ref"] + np.polyval(relation["polynomial"][::-1], way)
        assert qpos[follower["qpos"]] == pytest.approx(expected, abs=1e-9)


def test_body_is_a_link_with_its_parts_and_actuators(sample):
    robot, header, _ = sample
    links = {link.name: link for link in robot.links}
    for body in header["bodies"][1:]:
        entry = header["links"][body["link"]]
        assert entry["name"] == body["name"]
        assert body["mass"] == pytest.approx(entry["mass"])
        assert [part["name"] for part in entry["parts"]] == [part.name for part in links[body["name"]].parts]
        assert sum(part["mass"] or 0 for part in entry["parts"]) == pytest.approx(entry["mass"])
    assert header["bodies"][0]["link"] is None
    joints = [header["joints"][actuator["joint"]]["name"] for actuator in header["actuators"]]
    assert joints == [actuator["name"] for actuator in header["actuators"]]
    kinds = {(actuator["kind"], actuator["unit"]) for actuator in header["actuators"]}
    assert kinds == {("position", "rad"), ("position", "m")}
    assert len(header["keyframes"][0]["ctrl"]) == len(header["actuators"])
    assert header["engine"] is not None


def test_actuators_are_the_same_in_a_mujoco_without_input_kinds(tmp_path, monkeypatch, sample):
    monkeypatch.delattr(mujoco, "mjtCtrlInput", raising=False)
    plan = plan_of(actuators={"*": {"type": "position"}})
    robot, header, _ = sample
    export(robot, tmp_path, plan)
    other, _ = pack.read_pack(pack_of(tmp_path, "scene.xml", robot, (), 1000))
    assert other["actuators"] == header["actuators"]


@pytest.mark.parametrize("mimic", [True, False])
def test_poses_and_loops_of_a_urdf_are_those_of_the_robot(mimic, tmp_path):
    plan = plan_of(export={"urdf": {}})
    robot = robot_of(sample_document(), plan)
    export(robot, tmp_path, plan)
    if not mimic:  # as readers do that know no mimics
        text = (tmp_path / "robot.urdf").read_text()
        (tmp_path / "robot.urdf").write_text(re.sub("<mimic[^>]*>", "", text))
    header, _ = pack.read_pack(pack_of(tmp_path, "robot.urdf", robot, (), 1000))
    joints = [joint["name"] for joint in header["joints"]]
    pairs = {(joints[relation["follower"]], joints[relation["driver"]]) for relation in header["relations"]}
    assert {(relation.follower, relation.driver) for relation in robot.relations} <= pairs
    assert [keyframe["name"] for keyframe in header["keyframes"]] == ["home", "cad"]
    assert [loop["type"] for loop in header["loops"]] == ["connect", "connect"]
    qpos = np.array(header["keyframes"][0]["qpos"])
    assert max(gaps(header, qpos)) < 1e-6
    moved = [joint["qpos"] for joint in header["joints"] if joint["name"] == "rod_lower_pivot"]
    qpos[moved] += 0.1
    assert min(gaps(header, qpos)) > 1e-3


def test_urdf_in_a_ros_package_is_shown_too(tmp_path):
    plan = plan_of(export={"ros2": {}})
    robot = robot_of(sample_document(), plan)
    export(robot, tmp_path, plan)
    files = [path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()]
    source = source_of(files, robot.name)
    assert source.endswith(".urdf")
    assert "/" in source
    header, _ = pack.read_pack(pack_of(tmp_path, source, robot, (), 1000))
    links = {body["name"] for body in header["bodies"]}
    assert {link.name for link in robot.links} <= links
