"""The engine's copy of the model moves as the scene does, and fits an older MuJoCo."""

import gzip
import json

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.configuration.mujoco_section import CompilerSection, FlagsSection, OptionSection
from linkwright.stages.formats.xml import parse, to_text
from linkwright.stages.mujoco.mjcf_schema import listed
from linkwright.stages.show.live import pack
from linkwright.stages.show.live.compiled import compile_live
from linkwright.stages.show.live.engine import assets as engine_assets
from linkwright.stages.show.live.engine.copy import NoCopy, engine_copy
from linkwright.stages.show.live.engine.version import VERSION, remove_newer, schema
from linkwright.stages.show.live.scene import pack_of
from tests.support.live_robots import INCLUDED, LINKAGE, LOOPS, SCENE, write
from tests.support.places import PROJECT
from tests.support.robots import robot_with

ROBOT = robot_with(())

SAME = (
    "body_parentid", "body_pos", "body_quat", "body_mass", "body_inertia", "body_ipos", "body_iquat",
    "jnt_type", "jnt_bodyid", "jnt_pos", "jnt_axis", "jnt_range", "jnt_limited", "jnt_stiffness",
    "dof_damping", "dof_armature", "dof_frictionloss", "qpos0", "qpos_spring", "eq_type", "eq_obj1id",
    "eq_obj2id", "eq_data", "eq_solref", "eq_solimp", "eq_active0", "actuator_trnid", "actuator_gaintype",
    "actuator_gainprm", "actuator_biasprm", "actuator_dynprm", "actuator_gear", "actuator_ctrlrange",
    "actuator_ctrllimited", "actuator_forcerange", "key_qpos", "key_ctrl", "key_qvel", "exclude_signature",
    "site_pos", "site_quat", "tendon_range",
)  # fmt: skip
"""Arrays of a model that decide how it moves."""


def copy_of(folder):
    return engine_copy(compile_live(folder, "scene.xml"), folder)


def models(folder, copy=None):
    """The model of the scene, as MuJoCo reads its file, and that of the copy."""
    copy = copy or copy_of(folder)
    scene = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    return scene, mujoco.MjModel.from_xml_string(copy.text, dict(copy.files))


def colliding(model):
    """What decides about contacts of each geom that may have any, by body."""
    chosen = (model.geom_contype | model.geom_conaffinity) != 0
    names = ("bodyid", "type", "contype", "conaffinity", "friction", "solref", "margin", "condim")
    return [getattr(model, f"geom_{name}")[chosen] for name in names]


@pytest.fixture
def folder(tmp_path):
    return write(tmp_path)


def require_the_same(folder, steps=500):
    scene, copy = models(folder)
    for name in SAME:
        np.testing.assert_array_equal(getattr(scene, name), getattr(copy, name), err_msg=name)
    for first, other in zip(colliding(scene), colliding(copy), strict=True):
        np.testing.assert_array_equal(first, other)
    states = []
    for model in (scene, copy):
        data = mujoco.MjData(model)
        if model.nkey:
            mujoco.mj_resetDataKeyframe(model, data, model.nkey - 1)
        for step in range(steps):
            data.ctrl[:] = 0.3 * np.sin(0.01 * step + np.arange(model.nu))
            mujoco.mj_step(model, data)
        states.append(np.concatenate([data.qpos, data.qvel]))
        contacts = data.ncon
    np.testing.assert_allclose(*states, rtol=0, atol=1e-9)
    return contacts


def test_copy_moves_as_the_scene_does(folder):
    assert require_the_same(folder) > 0, "without a contact, colliders would not matter"


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_copy_of_a_robot_with_loops_moves_as_the_scene_does(loop, tmp_path):
    require_the_same(write(tmp_path, scene=LINKAGE.format(loop=loop)))


ACTUATORS = """<mujoco><compiler autolimits="true"/><worldbody>{bodies}</worldbody>
<actuator>
  <position joint="a" kp="9" kv="1" inheritrange="1"/>
  <velocity joint="b" kv="2" forcerange="-3 3"/>
  <motor joint="c" gear="3" ctrlrange="-1 1"/>
  <damper joint="d" kv="2" ctrlrange="0 1"/>
  <intvelocity joint="e" kp="5" actrange="-1 1"/>
  <general joint="f" dyntype="filter" dynprm="0.1" gainprm="2" biastype="affine" biasprm="0 -2 -1"/>
  {newer}
</actuator></mujoco>"""

SINCE_3_7 = """<pid joint="g" kp="9" kv="1" ki="2" imax="1"/>
  <dcmotor joint="h" motorconst="0.1" resistance="2"/>
  <position joint="i" kp="3" delay="0.01" nsample="8"/>"""


def test_actuators_of_every_type_move_as_in_the_scene(tmp_path):
    bodies = "".join(
        f'<body pos="{place} 0 1"><joint name="{name}" axis="0 1 0" range="-1 1"/>'
        '<geom size="0.05 0.1" type="capsule" pos="0 0 0.1"/></body>'
        for place, name in enumerate("abcdefghi")
    )
    newer = SINCE_3_7 if ("actuator", "pid") in map(tuple, listed()) else ""
    require_the_same(write(tmp_path, scene=ACTUATORS.format(bodies=bodies, newer=newer)))


def test_visuals_are_not_in_the_copy(folder):
    copy = copy_of(folder)
    for tag in ("texture", "material", "light", "camera", "visual", "sensor"):
        assert f"<{tag}" not in copy.text
    assert "material=" not in copy.text
    assert list(copy.files.values()) == [(folder / "assets" / "hull.stl").read_bytes()]
    assert copy.lacks == []
    assert "linkwright" not in copy.text, "names given on the way are not left"


def test_visual_geom_that_something_names_stays(folder, tmp_path):
    pair = '<contact><pair geom1="lid" geom2="floor"/></contact></mujoco>'
    robot = INCLUDED.replace('<geom class="seen" type="box"', '<geom name="lid" class="seen" type="box"')
    other = write(tmp_path / "other", scene=SCENE.replace("</mujoco>", pair), robot=robot)
    scene, copy = models(other)
    assert copy.npair == scene.npair == 1
    assert copy.ngeom == models(folder)[1].ngeom + 1


def test_inertias_are_of_all_geoms_where_the_file_says_so(tmp_path):
    ignoring = '<compiler angle="radian" inertiafromgeom="true" '
    robot = INCLUDED.replace('<compiler angle="radian" ', ignoring).replace('density="0"', 'density="300"')
    folder = write(tmp_path, robot=robot)
    scene, copy = models(folder)
    assert scene.body_mass[1] != pytest.approx(3)
    np.testing.assert_allclose(copy.body_mass, scene.body_mass, rtol=1e-12)
    np.testing.assert_allclose(copy.body_inertia, scene.body_inertia, rtol=1e-12)
    np.testing.assert_allclose(copy.body_ipos, scene.body_ipos, atol=1e-12)


def test_large_meshes_are_their_hulls_in_place(folder, monkeypatch):
    monkeypatch.setattr(engine_assets, "MAX_MESH_BYTES", 100)
    copy = copy_of(folder)
    assert [lack["instead"] for lack in copy.lacks] == ["the convex hulls, by which MuJoCo collides"]
    assert all(name.endswith(".msh") for name in copy.files)
    points = []
    for model in models(folder, copy):
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        (geom,) = np.flatnonzero((model.geom_type == mujoco.mjtGeom.mjGEOM_MESH) & (model.geom_group == 3))
        mesh = model.geom_dataid[geom]
        vertices = model.mesh_vert[model.mesh_vertadr[mesh] :][: model.mesh_vertnum[mesh]]
        points.append(vertices @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    # How far each of them reaches in many directions.
    directions = np.random.default_rng(0).normal(size=(500, 3))
    np.testing.assert_allclose(*((place @ directions.T).max(axis=0) for place in points), atol=1e-6)


def test_replicated_bodies_are_in_the_copy_too(tmp_path):
    copied = '<replicate count="2" offset="0 0 1"><body><joint/><geom size=".1"/></body></replicate>'
    scene = LINKAGE.format(loop=LOOPS["sites"]).replace("</worldbody>", f"{copied}</worldbody>")
    require_the_same(write(tmp_path, scene=scene))


def test_elements_that_a_copy_cannot_have_leave_the_sliders(tmp_path):
    more = "<extension><plugin plugin='mujoco.pid'/></extension></mujoco>"
    write(tmp_path, scene=SCENE.replace("</mujoco>", more))
    with pytest.raises(NoCopy, match="cannot have <extension>, <plugin>"):
        copy_of(tmp_path)
    header, _ = pack.read_pack(pack_of(tmp_path, "scene.xml", ROBOT, (), 1000))
    assert header["engine"] is None
    assert "<plugin>" in header["no_engine"]
    assert len(header["bodies"]) == 6


NEWER = """<mujoco>
  <option><flag speculative="enable"/></option>
  <default><default class="soft"><joint springyield="1" damping="2"/></default></default>
  <worldbody><body><joint name="a" springyield="0.5" stiffness="3"/>
    <geom size="0.1" castshadow="false"/><glow name="new"/></body></worldbody>
  <tendon><fixed name="t" springyield="1"><joint joint="a" coef="1"/></fixed></tendon>
</mujoco>"""


def test_elements_newer_than_the_pages_mujoco_are_left_out():
    root = parse(NEWER.encode())
    assert [(entry["what"], entry["place"]) for entry in remove_newer(root)] == [
        ("the attribute speculative", "flag"),
        ("the attribute springyield", "joint"),
        ("the attribute springyield", "joint a"),
        ("the element <glow>", "glow new"),
        ("the attribute springyield", "fixed t"),
    ]
    text = to_text(root)
    assert not [word for word in ("speculative", "springyield", "castshadow", "glow") if word in text]
    assert all(word in text for word in ("damping", "stiffness", "<flag", 'coef="1"'))
    # What is left compiles, in the page's own version where that is the installed one.
    mujoco.MjModel.from_xml_string(text)


@pytest.mark.skipif(mujoco.__version__ != VERSION, reason=f"MuJoCo {VERSION} is not the installed one")
def test_list_of_what_the_pages_mujoco_knows_is_its_own():
    file = PROJECT / "pipeline" / "live" / "viewer" / "engine" / f"mjcf-{VERSION}.json.gz"
    kept = json.loads(gzip.decompress(file.read_bytes()))
    assert kept["mujoco"] == VERSION
    assert kept["elements"] == {"/".join(way): sorted(names) for way, names in listed().items()}


def test_few_keys_of_users_are_unknown_to_the_pages_mujoco():
    sections = {("option",): OptionSection, ("option", "flag"): FlagsSection, ("compiler",): CompilerSection}
    newer = set()
    for path, section in sections.items():
        allowed, children = schema().allowed(("mujoco", *path))
        newer |= set(section.model_fields) - allowed - children
    later = {"speculative", "savecanonical", "savecompiled", "passthrough"}
    no_longer_there = {"apirate", "passive"}
    assert newer == later | no_longer_there
