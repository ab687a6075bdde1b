"""What a pack says of a robot, compared with MuJoCo by a reading that knows only the pack."""

import os
import subprocess
import sys
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.show.live import pack
from linkwright.stages.show.live.scene import pack_of
from tests.support.live_robots import (
    HOSTILE,
    INCLUDED,
    LINKAGE,
    LOOPS,
    SCENE,
    bumpy,
    frames_of,
    poses,
    times,
    triangles,
    turned,
    write,
)
from tests.support.places import PROJECT
from tests.support.robots import robot_with
from tests.unit.pipeline.test_live import ARM

ROBOT = robot_with(())


@pytest.fixture
def whole(tmp_path):
    write(tmp_path)
    header, content = pack.read_pack(pack_of(tmp_path, "scene.xml", ROBOT, (), 200_000))
    return header, content, mujoco.MjModel.from_xml_path(str(tmp_path / "scene.xml"))


def header_of(folder, scene, **more):
    write(folder, scene=scene, **more)
    return pack.read_pack(pack_of(folder, "scene.xml", ROBOT, (), 200_000))[0]


def model_of(folder):
    return mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))


def random_pose(model, draw):
    qpos = draw.normal(size=model.nq)
    data = mujoco.MjData(model)
    data.qpos[:] = qpos
    mujoco.mj_normalizeQuat(model, data.qpos)
    mujoco.mj_kinematics(model, data)
    return qpos, data


def test_bodies_are_where_mujoco_has_them_at_any_pose(whole):
    header, _, model = whole
    draw = np.random.default_rng(0)
    for _ in range(20):
        qpos, data = random_pose(model, draw)
        for (place, turn), expected, quat in zip(poses(header, qpos), data.xpos, data.xquat, strict=True):
            np.testing.assert_allclose(place, expected, atol=1e-9)
            np.testing.assert_allclose(turn * np.sign(turn @ quat), quat, atol=1e-9)


def test_frames_and_masses_are_on_their_bodies(whole):
    header, _, model = whole
    qpos, data = random_pose(model, np.random.default_rng(1))
    where = poses(header, qpos)
    for frame in header["frames"]:
        place, turn = where[frame["body"]]
        index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, frame["name"])
        point = place + turned(turn, np.array(frame["pos"]))
        np.testing.assert_allclose(point, data.site_xpos[index], atol=1e-9)
    mujoco.mj_comPos(model, data)
    for index, body in enumerate(header["bodies"]):
        place, turn = where[index]
        np.testing.assert_allclose(place + turned(turn, np.array(body["com"])), data.xipos[index], atol=1e-9)
        frame = times(turn, np.array(body["inertia"]["quat"]))
        matrix = np.array([turned(frame, axis) for axis in np.eye(3)]).T
        np.testing.assert_allclose(matrix, data.ximat[index].reshape(3, 3), atol=1e-9)
        np.testing.assert_allclose(body["mass"], model.body_mass[index], rtol=1e-9)
        np.testing.assert_allclose(body["inertia"]["diagonal"], model.body_inertia[index], rtol=1e-9)


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_frames_of_a_loop_coincide_only_where_it_is_closed(loop, tmp_path):
    header = header_of(tmp_path, LINKAGE.format(loop=loop))
    model = model_of(tmp_path)
    names = [(entry["name"], entry["type"]) for entry in header["loops"]]
    assert names == [("loop", loop[1:].partition(" ")[0]), ("carried", "weld")]
    # Welded, the parallelogram stands still.
    for angle in (0.0,) if loop.startswith("<weld") else (0.0, 0.7):
        data = mujoco.MjData(model)
        # A parallelogram: the bar keeps its orientation.
        data.qpos[:3] = angle, -angle, angle
        mujoco.mj_kinematics(model, data)
        copied = np.array([np.cos(angle / 2), 0, 0, np.sin(angle / 2)])
        data.qpos[3:] = [*turned(copied, np.array([0, 0, 0.4])), *copied]
        for loop in header["loops"]:
            np.testing.assert_allclose(*ends(header, loop, data.qpos), atol=1e-9)
    data.qpos[2] += 0.1
    first, second = ends(header, header["loops"][0], data.qpos)
    assert np.linalg.norm(first[:3] - second[:3]) == pytest.approx(2 * 0.3 * np.sin(0.05))


def ends(header, loop, qpos):
    """The two frames of a loop in the world; of a connect only the points."""
    frames = frames_of(header, qpos, loop)
    if loop["type"] == "connect":
        return [point for point, _ in frames]
    return [np.array([*point, *(quat * np.sign(quat[0]))]) for point, quat in frames]


def test_relation_is_zero_where_mujocos_constraint_is(whole):
    header, _, model = whole
    names = [joint["name"] for joint in header["joints"]]
    geared, stuck = header["relations"]
    assert [names[dof] for dof in (geared["follower"], geared["driver"])] == ["gear", "turn"]
    assert (names[stuck["follower"]], stuck["driver"]) == ("pass", None)
    data = mujoco.MjData(model)
    for value in (-0.5, 0.4, 1.1):
        for relation in header["relations"]:
            joint, driver = header["joints"][relation["follower"]], relation["driver"]
            way = 0.0
            if driver is not None:
                data.qpos[header["joints"][driver]["qpos"]] = value
                way = value - header["joints"][driver]["ref"]
            data.qpos[joint["qpos"]] = joint["ref"] + np.polyval(relation["polynomial"][::-1], way)
        mujoco.mj_forward(model, data)
        rows = data.efc_type[: data.nefc] == mujoco.mjtConstraint.mjCNSTR_EQUALITY
        assert rows.sum() == 2
        np.testing.assert_allclose(data.efc_pos[: data.nefc][rows], 0, atol=1e-9)


def test_joints_keyframes_and_actuators_are_those_of_the_file(whole):
    header, _, _ = whole
    keys = "name", "type", "range", "unit", "ref"
    assert [tuple(joint[key] for key in keys) for joint in header["joints"]] == [
        ("", "free", None, "", 0.0),
        ("slide", "slide", [-0.1, 0.2], "m", 0.05),
        ("turn", "hinge", [-1.0, 2.0], "rad", 0.4),
        ("globe", "ball", None, "", 0.0),
        ("gear", "hinge", None, "rad", 0.2),
        ("wrist", "hinge", None, "rad", 0.0),
        ("pass", "hinge", None, "rad", 0.0),
    ]
    assert header["joints"][0]["label"] == "base (free)"
    assert [keyframe["name"] for keyframe in header["keyframes"]] == ["home", "first"]
    assert header["keyframes"][0]["ctrl"] == [0.4, 0.0, 0.0, 0.0]
    keys = "name", "kind", "range", "unit"
    assert [tuple(actuator[key] for key in keys) for actuator in header["actuators"]] == [
        ("drive", "position", [-1.0, 2.0], "rad"),
        ("push", "motor", None, "N"),
        ("spin", "velocity", None, "rad/s"),
        ("lift", "general", [-1.0, 1.0], ""),
    ]


SERVOS = """
<mujoco><worldbody><body><joint name="a" axis="0 1 0" ref=".1"/><geom size=".1"/></body></worldbody>
<actuator>
  <position name="geared" joint="a" kp="10" kv="1" gear="3"/>
  <position name="filtered" joint="a" kp="10" timeconst=".1"/>
  <intvelocity name="carried" joint="a" kp="7" gear="2" actrange="-9 9"/>
  <general name="biased" joint="a" gainprm="4" biastype="affine" biasprm=".5 -2 -.1"/>
  <velocity name="turning" joint="a" kv="3"/>
  <motor name="pushed" joint="a"/>
  <damper name="damped" joint="a" kv="2" ctrlrange="0 1"/>
  PID
</actuator>
<keyframe><key name="home" qpos=".3" ctrl="1 2 0 0 0 0 0 PIDS" act=".4 .6 ACTS"/></keyframe></mujoco>"""
PID = (
    '<pid name="summed" joint="a" kp="5" ki="2"/><pid name="slewed" joint="a" kp="5" gear="2" slewmax="1"/>',
    "0 0 0 0",
    "0 .7",
)


def test_at_its_target_a_servo_rests_where_its_joint_is(tmp_path):
    pid = PID if hasattr(mujoco.mjtGain, "mjGAIN_PID") else ("", "", "")
    scene = SERVOS
    for word, text in zip(("PIDS", "PID", "ACTS"), (pid[1], pid[0], pid[2]), strict=True):
        scene = scene.replace(word, text)
    header = header_of(tmp_path, scene)
    model = model_of(tmp_path)
    data = mujoco.MjData(model)
    data.qpos[0] = 0.8
    for ctrl, entry in enumerate(header["actuators"]):
        target = entry["target"]
        if target is None:
            continue
        value = target["slope"] * data.qpos[0] + target["offset"]
        if target["ctrl"]:
            data.ctrl[ctrl] = value
        if target["act"] is not None:
            data.act[target["act"]] = value
    mujoco.mj_forward(model, data)
    names = ["geared", "filtered", "carried", "biased", *(["summed", "slewed"] if pid[0] else [])]
    held = [actuator["name"] for actuator in header["actuators"] if actuator["target"]]
    assert {name.removesuffix(" position") for name in held} == set(names)
    for name in names:
        assert data.actuator(name).force == pytest.approx(0, abs=1e-9), name
    assert header["keyframes"][0]["act"] == model.key_act[0].tolist()
    assert header["activations"] == model.na
    assert [actuator["unit"] for actuator in header["actuators"]][2] == "rad/s"


def test_visuals_colliders_and_the_ground_have_their_roles(whole):
    header, _, _ = whole
    roles = [(geom["name"], geom["type"], geom["role"]) for geom in header["geoms"]]
    # What collides and has no group of colliders, as the hand and the capsule, is seen too.
    assert roles == [
        ("floor", "plane", "ground"),
        ("", "mesh", "visual"),
        ("", "mesh", "collision"),
        ("", "box", "visual"),
        ("heavy", "capsule", "visual"),
        ("heavy", "capsule", "collision"),
        ("", "sphere", "collision"),
        ("", "cylinder", "collision"),
        ("", "ellipsoid", "visual"),
        ("", "ellipsoid", "collision"),
    ]
    colours = [geom["rgba"] for geom in header["geoms"]]
    np.testing.assert_allclose(colours[0], [0.5, 0.5, 0.5, 1], atol=0.01)  # the mean of the tiles
    # Its material's colour times its texture's.
    np.testing.assert_allclose(colours[1], [0.4, 0.2, 0.2, 1], atol=0.01)
    assert colours[3] == [1, 0, 0, 1]
    assert header["camera"] == {"center": [0, 0, 1], "extent": 0.8, "azimuth": 150, "elevation": -25}


def test_textures_without_a_colour_leave_the_colour_of_a_geom(tmp_path):
    images = "".join(
        f'<texture name="{name}" type="2d" builtin="flat" rgb1="{colour}" width="8" height="8"/>'
        for name, colour in (("rgb", "1 .5 0"), ("normal", ".5 .5 1"), ("orm", "0 1 0"))
    )
    layers = "".join(f'<layer role="{name}" texture="{name}"/>' for name in ("rgb", "normal", "orm"))
    scene = (
        f'<mujoco><asset>{images}<material name="m">{layers}</material></asset>'
        '<worldbody><body><joint/><geom size="0.1" material="m"/></body></worldbody></mujoco>'
    )
    (colour,) = {tuple(geom["rgba"]) for geom in header_of(tmp_path, scene)["geoms"]}
    np.testing.assert_allclose(colour, [1, 0.5, 0, 1], atol=0.01)


def test_without_visual_geoms_the_colliders_are_seen(tmp_path):
    scene = '<mujoco><worldbody><body><joint/><geom group="3" size="0.1"/></body></worldbody></mujoco>'
    assert [geom["role"] for geom in header_of(tmp_path, scene)["geoms"]] == ["collision", "visual"]


def test_positions_are_within_half_a_step_of_the_file(whole):
    header, content, model = whole
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    for geom in (record for record in header["geoms"] if record["type"] == "mesh"):
        corners = triangles(header, content, geom["mesh"])
        entry = header["meshes"][geom["mesh"]]
        assert entry["faces"] == entry["of_faces"] == len(corners)
        turns = [turned(np.array(geom["quat"]), point) for point in corners.reshape(-1, 3)]
        placed = np.array(geom["pos"]) + turns
        exact = (bumpy() if geom["role"] == "visual" else 0.5 * bumpy(1, 0.2, 1)).reshape(-1, 3)
        far = np.linalg.norm(exact[:, None] - placed[None], axis=2)
        step = np.linalg.norm(entry["positions"]["step"])
        assert far.min(axis=0).max() < step
        assert far.min(axis=1).max() < step


def test_files_of_one_content_are_one_mesh(tmp_path):
    twice = INCLUDED.replace('<mesh name="shell" ', '<mesh name="twin" file="shell.stl"/><mesh name="shell" ')
    seen = '<geom class="seen" type="mesh" mesh="twin"/>'
    header = header_of(tmp_path, SCENE, robot=twice.replace("<geom class", f"{seen}<geom class", 1))
    assert [geom["mesh"] for geom in header["geoms"] if geom["type"] == "mesh"] == [0, 0, 1]


def test_hostile_name_is_only_in_the_compressed_header(tmp_path):
    name = HOSTILE.replace("<", "&lt;").replace('"', "&quot;")
    write(tmp_path, robot=INCLUDED.replace('name="turn"', f'name="{name}"').replace('="turn"', f'="{name}"'))
    made = pack_of(tmp_path, "scene.xml", ROBOT, (), 200_000)
    header, _ = pack.read_pack(made)
    assert header["joints"][2]["name"] == HOSTILE
    assert b"<script" not in made
    assert header["engine"] is not None


def test_file_outside_of_the_build_is_not_read(tmp_path):
    (tmp_path / "secret.xml").write_text("<mujoco/>")
    for path in ("../secret.xml", str(tmp_path / "secret.xml"), "scene.xml"):
        with pytest.raises(ValueError, match="from outside of the build, or in a circle"):
            header_of(tmp_path / "build", f'<mujoco><include file="{path}"/></mujoco>')


CODE = """
import sys
from pathlib import Path
from linkwright.stages.show.live.scene import pack_of
from tests.unit.show.live.test_scene import ROBOT
sys.stdout.buffer.write(pack_of(Path(sys.argv[1]), "scene.xml", ROBOT, (), 300))
"""


def test_bytes_do_not_depend_on_the_seed_of_hashes(tmp_path):
    write(tmp_path)
    command, packs = [sys.executable, "-c", CODE, str(tmp_path)], set()
    for seed in ("1", "2"):
        environ = {**os.environ, "PYTHONHASHSEED": seed}
        run = subprocess.run(command, env=environ, cwd=PROJECT, check=True, capture_output=True)
        packs.add(run.stdout)
    (made,) = packs
    assert len(made) > 1000


def test_urdf_has_a_view_without_an_engine(tmp_path):
    compiler = '<mujoco><compiler fusestatic="false" discardvisual="false"/></mujoco></robot>'
    (tmp_path / "arm.urdf").write_text(ARM.replace("</robot>", compiler))
    header, _ = pack.read_pack(pack_of(Path(tmp_path), "arm.urdf", ROBOT, (), 1000))
    assert header["engine"] is None
    assert "export=mjcf" in header["no_engine"]
    assert {geom["type"] for geom in header["geoms"]} == {"box"}
    # The groups of a URDF are MuJoCo's.
    assert [geom["role"] for geom in header["geoms"]] == ["visual", "collision", "visual"]
    assert [body["name"] for body in header["bodies"]] == ["world", "base", "upper"]
