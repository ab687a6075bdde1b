"""The engine's copy of the model moves as the scene does, and fits an older MuJoCo."""

import gzip
import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from linkwright.stages.export.configuration.mujoco_section import CompilerSection, FlagsSection, OptionSection
from linkwright.stages.formats.xml import parse, to_text
from linkwright.stages.show.live import pack
from linkwright.stages.show.live.compiled import compiled
from linkwright.stages.show.live.engine import assets as engine_assets
from linkwright.stages.show.live.engine.copy import EngineCopy, NoCopy, engine_copy
from linkwright.stages.show.live.engine.version import VERSION, schema, without_newer
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


def copy_of(folder: Path) -> EngineCopy:
    return engine_copy(compiled(folder, "scene.xml"), folder)


def models(folder: Path):
    """The model of the scene, as MuJoCo reads its file, and that of the copy."""
    copy = copy_of(folder)
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
    for one, other in zip(colliding(scene), colliding(copy), strict=True):
        np.testing.assert_array_equal(one, other)
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


def test_the_copy_moves_as_the_scene_does(folder):
    assert require_the_same(folder) > 0, "without a contact, colliders would not matter"


@pytest.mark.parametrize("loop", LOOPS.values(), ids=LOOPS)
def test_so_does_that_of_a_robot_with_loops(loop, tmp_path):
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


def test_so_do_actuators_of_every_type(tmp_path):
    bodies = "".join(
        f'<body pos="{place} 0 1"><joint name="{name}" axis="0 1 0" range="-1 1"/>'
        '<geom size="0.05 0.1" type="capsule" pos="0 0 0.1"/></body>'
        for place, name in enumerate("abcdefghi")
    )
    listed = [tuple(way.split("/")) for way in _listed_by_the_installed()]
    newer = SINCE_3_7 if ("actuator", "pid") in listed else ""
    require_the_same(write(tmp_path, scene=ACTUATORS.format(bodies=bodies, newer=newer)))


def _listed_by_the_installed():
    from linkwright.stages.mujoco.mjcf_schema import listed

    return ["/".join(way) for way in listed()]


def test_what_is_only_seen_is_not_in_the_copy(folder):
    copy = copy_of(folder)
    for tag in ("texture", "material", "light", "camera", "visual", "sensor"):
        assert f"<{tag}" not in copy.text
    assert "material=" not in copy.text
    assert list(copy.files.values()) == [(folder / "assets" / "hull.stl").read_bytes()]
    assert copy.lacks == []
    assert "linkwright" not in copy.text, "names given on the way are not left"


def test_a_visual_geom_that_something_names_stays(folder, tmp_path):
    pair = '<contact><pair geom1="lid" geom2="floor"/></contact></mujoco>'
    robot = INCLUDED.replace('<geom class="seen" type="box"', '<geom name="lid" class="seen" type="box"')
    other = write(tmp_path / "other", scene=SCENE.replace("</mujoco>", pair), robot=robot)
    scene, copy = models(other)
    assert copy.npair == scene.npair == 1
    assert copy.ngeom == models(folder)[1].ngeom + 1


def test_inertias_are_those_of_all_geoms_also_where_the_compiler_ignores_what_is_given(tmp_path):
    ignoring = '<compiler angle="radian" inertiafromgeom="true" '
    robot = INCLUDED.replace('<compiler angle="radian" ', ignoring).replace('density="0"', 'density="300"')
    folder = write(tmp_path, robot=robot)
    scene, copy = models(folder)
    assert scene.body_mass[1] != pytest.approx(3)
    np.testing.assert_allclose(copy.body_mass, scene.body_mass, rtol=1e-12)
    np.testing.assert_allclose(copy.body_inertia, scene.body_inertia, rtol=1e-12)
    np.testing.assert_allclose(copy.body_ipos, scene.body_ipos, atol=1e-12)


def test_large_meshes_are_their_hulls_in_place(folder, monkeypatch):
    monkeypatch.setattr(engine_assets, "LARGE", 100)
    copy = copy_of(folder)
    assert [one["instead"] for one in copy.lacks] == ["the convex hulls, by which MuJoCo collides"]
    assert all(name.endswith(".msh") for name in copy.files)
    points = []
    for model in (
        mujoco.MjModel.from_xml_path(str(folder / "scene.xml")),
        mujoco.MjModel.from_xml_string(copy.text, dict(copy.files)),
    ):
        data = mujoco.MjData(model)
        mujoco.mj_kinematics(model, data)
        (geom,) = np.flatnonzero((model.geom_type == mujoco.mjtGeom.mjGEOM_MESH) & (model.geom_group == 3))
        first, count = (int(one[model.geom_dataid[geom]]) for one in (model.mesh_vertadr, model.mesh_vertnum))
        own = model.mesh_vert[first : first + count]
        points.append(own @ data.geom_xmat[geom].reshape(3, 3).T + data.geom_xpos[geom])
    # How far each of them reaches in many directions.
    ways = np.random.default_rng(0).normal(size=(500, 3))
    reach = [(one @ ways.T).max(axis=0) for one in points]
    np.testing.assert_allclose(*reach, atol=1e-6)


def test_what_mujoco_copies_is_copied_in_the_copy_too(tmp_path):
    copied = '<replicate count="2" offset="0 0 1"><body><joint/><geom size=".1"/></body></replicate>'
    scene = LINKAGE.format(loop=LOOPS["sites"]).replace("</worldbody>", f"{copied}</worldbody>")
    require_the_same(write(tmp_path, scene=scene))


def test_what_a_copy_cannot_have_leaves_the_sliders(tmp_path):
    more = "<extension><plugin plugin='mujoco.pid'/></extension></mujoco>"
    write(tmp_path, scene=SCENE.replace("</mujoco>", more))
    with pytest.raises(NoCopy, match="cannot have <extension>, <plugin>"):
        copy_of(tmp_path)
    header, _ = pack.unpacked(pack_of(tmp_path, "scene.xml", ROBOT, (), 1000))
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


def test_what_the_pages_mujoco_does_not_know_is_left_out_and_named():
    root = parse(NEWER.encode())
    found = [(one["what"], one["place"]) for one in without_newer(root)]
    assert found == [
        ("the attribute speculative", "flag"),
        ("the attribute springyield", "joint"),
        ("the attribute springyield", "joint a"),
        ("the element <glow>", "glow new"),
        ("the attribute springyield", "fixed t"),
    ]
    text = to_text(root)
    for word in ("speculative", "springyield", "castshadow", "glow"):
        assert word not in text
    for word in ("damping", "stiffness", "<flag", 'coef="1"'):
        assert word in text
    # What is left compiles, in the page's own version where that is the installed one.
    mujoco.MjModel.from_xml_string(text)


@pytest.mark.skipif(mujoco.__version__ != VERSION, reason=f"MuJoCo {VERSION} is not the installed one")
def test_the_list_of_what_the_pages_mujoco_knows_is_its_own():
    from linkwright.stages.mujoco.mjcf_schema import listed

    file = PROJECT / "pipeline" / "live" / "viewer" / "engine" / f"mjcf-{VERSION}.json.gz"
    kept = json.loads(gzip.decompress(file.read_bytes()))
    assert kept["mujoco"] == VERSION
    assert kept["elements"] == {"/".join(way): sorted(names) for way, names in listed().items()}


def test_of_what_a_user_may_set_little_is_unknown_to_it():
    asked = {
        ("option",): OptionSection,
        ("option", "flag"): FlagsSection,
        ("compiler",): CompilerSection,
    }
    newer = set()
    for way, section in asked.items():
        known, children = schema().known(("mujoco", *way))
        newer |= set(section.model_fields) - known - children
    later = {"speculative", "savecanonical", "savecompiled", "passthrough"}
    no_longer_there = {"apirate", "passive"}
    assert newer == later | no_longer_there
