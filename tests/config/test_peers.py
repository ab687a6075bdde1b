"""Every verb of the original Robot class and every option of onshape-to-robot has a row, and each row does
what it says."""

import re
import shlex
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import mujoco
import pytest
import yaml

from linkwright.pipeline.api.building import Build
from linkwright.pipeline.cli import parse
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.formats.xml import Element
from linkwright.stages.formats.xml import parse as parse_xml
from tests.config.peers import ONSHAPE_TO_ROBOT, ROBOT_CLASS
from tests.support.places import PROJECT, SHARED
from tests.support.users import SAMPLE, URL, write

VERB_NAMES = """
Robot.from_url Robot.from_urdf Robot(name) Client env max_depth use_user_defined_root set_variables
add_link add_joint Inertia mass Box Cylinder Sphere JointLimits JointDynamics JointMimic
set_robot_position set_ground_position add_ground_plane set_compiler_attributes set_option_attributes
add_light Camera add_actuator add_encoder add_force_sensor add_sensor IMU Gyro add_custom_element_by_tag
add_custom_element_by_name add_custom_element load_element set_element_attributes to_urdf to_mjcf
RobotType save file_path mesh_dir download_assets show_tree show_graph plot_graph get_xml_string
Robot.graph parts mates relations estimate_api_calls record_session
"""

OPTION_NAMES = """
url document_id version_id workspace_id element_id assembly_name output_format output_filename
assets_directory robot_name configuration ignore_limits ignore draw_frames color no_dynamics
include_configuration_suffix round_decimals joint_properties geom_properties post_import_commands
processors ball_to_euler ball_to_euler_order use_scads pure_shape_dilatation merge_stls simplify_stls
max_stl_size use_fixed_links add_dummy_base_link convex_decomposition rainbow_colors no_collision_meshes
collisions_as_visual package_name additional_xml set_zero_mass_to_fixed equalities default effort
max_effort max_velocity friction frictionloss damping armature stiffness limits actuated type kp kv
dampratio forcerange range class dof_NAME _inv _inverted wheel continuous closing_NAME frame_NAME
link_NAME fix_NAME Fix --retrieve --convert --save-pickle --safe onshape-to-robot-bullet
onshape-to-robot-mujoco onshape-to-robot-clear-cache onshape-to-robot-edit-shape
onshape-to-robot-pure-sketch
"""

ROWS = (*ROBOT_CLASS, *ONSHAPE_TO_ROBOT)


def named(rows):
    return [name for row in rows for name in row.theirs]


@pytest.mark.parametrize(("rows", "names", "more"), [
    (ROBOT_CLASS, VERB_NAMES, []),
    (ONSHAPE_TO_ROBOT, OPTION_NAMES, ["gear relation", "onshape-to-robot DIR", "the saved pose is zero"]),
], ids=["the original Robot class", "onshape-to-robot"])  # fmt: skip
def test_every_name_is_in_a_single_row(rows, names, more):
    assert sorted(named(rows)) == sorted([*names.split(), *more])


def test_a_row_says_a_single_thing_that_exists():
    for row in ROWS:
        assert sum(map(bool, (row.yaml, row.command, row.python))) == 1 or (row.note and not row.yaml), row
        assert "|" not in f"{row.yaml}{row.note}", row
    names = {row.python.rpartition(".")[2] for row in ROWS if row.python}
    assert names <= {*vars(Build), *Build.__annotations__}
    assert "pipeline/reference/PEERS.md" in (PROJECT / "README.md").read_text(encoding="utf-8")


@pytest.mark.skipif(not (SHARED / "reference").is_dir(), reason="without the survey of the other tools")
def test_no_key_of_the_survey_is_missing():
    text = (SHARED / "reference" / "peers-onshape-to-robot.md").read_text(encoding="utf-8")
    tables = text.partition("### 1.2")[2].partition("### 1.5")[0]
    rows = [
        line.split("|") for line in tables.splitlines() if line.startswith("| `") or re.match(r"\| \d", line)
    ]
    cells = [cells[3] if cells[1].strip().isdigit() else cells[1] for cells in rows]
    keys = {key for cell in cells for key in re.findall(r"`([a-z_]+)`", cell)}
    assert len(keys) > 30
    assert keys - {"xyz", "true", "false", "visual", "collision"} <= set(named(ONSHAPE_TO_ROBOT))
    text = (SHARED / "reference" / "peers-toolkit.md").read_text(encoding="utf-8")
    section = text.partition("### 1.5")[2].partition("### 1.6")[0]
    verbs = set(re.findall(r"\b((?:add|set|show|to|from|get)_[a-z_]+|save|load_element)\(?", section))
    verbs -= {"set_joint_from_xml", "from_file", "from_color"}  # of its values, not of the robot
    defined = {name.rpartition(".")[2] for name in named(ROBOT_CLASS)}
    assert verbs - defined == set()


def holds(tree, wanted):
    """Whether a configuration has all that some YAML gives."""
    if isinstance(wanted, dict):
        return isinstance(tree, dict) and all(holds(tree.get(key), value) for key, value in wanted.items())
    if isinstance(tree, dict) and isinstance(wanted, str):
        return wanted in tree.values()
    return list(tree) == wanted if isinstance(wanted, list) else tree == wanted


@pytest.mark.parametrize("row", [row for row in ROWS if row.command], ids=lambda row: row.theirs[0])
def test_the_command_of_a_row_is_valid(tmp_path, row):
    words = shlex.split(row.command)
    if words[0] in VERBS:
        assert words[0] in ("bundle", "cache", "new")
        return
    command = parse(words)
    more = [] if any(word.startswith(("source=", "robot=")) for word in words) else ["source=sample"]
    if "source.offline=true" in words:
        more = ["source=onshape", f"source.url='{URL}'"]
    folder = write(tmp_path, my_arm=SAMPLE)
    plan = compose_plan([*more, *command.overrides], (), folder).plan
    assert plan.until == next((word.removeprefix("until=") for word in words if "until=" in word), "validate")
    if words[0].startswith("export="):
        assert set(plan.export.chosen) == set(words[0].removeprefix("export=").strip("[]").split(","))
    if words[0].startswith("mesh="):
        assert plan.mesh.collider == words[0].removeprefix("mesh=")


class Made(NamedTuple):
    """The files of a robot that a row made, the compiled scene, and the URDF."""

    files: Mapping[str, bytes]
    model: mujoco.MjModel
    urdf: Element


def composed(folder, text, *overrides):
    url = "source: {url" in text or "source: {configuration" in text or "source: {variables" in text
    source = "onshape" if url or "source: {max_calls" in text else "sample"
    if source == "onshape" and "url:" not in text:
        text = text.replace("source: {", f"source: {{url: '{URL}', ")
    if "file: mark.xml" in text:
        (folder / "mark.xml").write_text("<site name='mark'/>", encoding="utf-8")
        text = text.replace("file: mark.xml", f"file: {folder}/mark.xml") if overrides else text
    robot = (
        f"# @package _global_\ndefaults: [{{override /source: {source}}}, {{override /mesh: hull}}]\n{text}\n"
    )
    name = [] if "name:" in text.partition(" ")[0] else ["name=arm"]
    return compose_plan(["robot=row", *name, *overrides], (), write(folder, row=robot)).plan


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


def equalities(model):
    return {model.equality(number).name for number in range(model.neq)}


EFFECTS = {
    "add_link": lambda made: made.model.body("payload").mass[0] == 0.2 and made.model.joint("lid").id >= 0,
    "JointLimits": lambda made: made.model.joint("elbow").range.tolist() == [-1, 1]
    and made.urdf.find("joint[@name='elbow']/limit").get("effort") == "12",
    "JointDynamics": lambda made: made.model.joint("elbow").damping[0] == 0.1,
    "Inertia": lambda made: made.model.body("palm").mass[0] == pytest.approx(0.2),
    "Box": lambda made: made.model.geom("ball_collision").size[0] == 0.02,
    "JointMimic": lambda made: made.model.equality("finger_gears").data[1] == 1,
    "gear relation": lambda made: "finger_gears" not in equalities(made.model),
    "set_robot_position": lambda made: made.model.body("base_plate").pos.tolist() == [0, 0, 0.5],
    "set_ground_position": lambda made: made.model.geom("floor").pos.tolist() == [0, 0, -0.1],
    "set_option_attributes": lambda made: (made.model.opt.timestep, made.model.opt.iterations) == (0.001, 50),
    "add_light": lambda made: made.model.light("lamp").pos.tolist() == [0, 0, 2],
    "Camera": lambda made: made.model.camera("eye").fovy[0] == 60,
    "add_actuator": lambda made: made.model.actuator("elbow").gear[0] == 5,
    "add_encoder": lambda made: made.model.nsensor == 3 and made.model.sensor("elbow_force").id >= 0,
    "add_sensor": lambda made: made.model.sensor("imu_gyro").noise[0] == 0.01,
    "add_custom_element_by_tag": lambda made: made.model.light("lamp2").pos.tolist() == [0, 0, 2],
    "add_custom_element_by_name": lambda made: made.model.site("mark").pos.tolist() == [0, 0, 0.1],
    "load_element": lambda made: made.model.site("mark").id >= 0,
    "set_element_attributes": lambda made: made.model.geom("floor").friction.tolist() == [1, 0.5, 0.5],
    "download_assets": lambda made: not made.model.nmesh,
    "ignore_limits": lambda made: not any(made.model.jnt_limited),
    "ignore": lambda made: not made.model.body("palm").geomnum[0] and made.model.body("palm").mass[0] > 0,
    "joint_properties": lambda made: made.model.joint("elbow").armature[0] == 0.01
    and made.model.joint("lift").damping[0] == 0.1,
    "stiffness": lambda made: made.model.joint("elbow").stiffness[0] == 2,
    "actuated": lambda made: made.model.actuator("elbow").gainprm[0] == 30
    and mujoco.mj_name2id(made.model, mujoco.mjtObj.mjOBJ_ACTUATOR, "wrist_roll") < 0,
    "geom_properties": lambda made: made.model.geom("palm_collision").friction[0] == 1.2,
    "equalities": lambda made: made.model.equality("rod_upper_pivot").solref.tolist() == [0.01, 1],
    "_inv": lambda made: made.model.joint("elbow").axis.tolist() == [0, 0, -1]
    and made.model.joint("elbow").range.tolist() == [-1.3, 0.6],
    "the saved pose is zero": lambda made: not made.model.key("cad").qpos.any(),
    "additional_xml": lambda made: made.urdf.find("gazebo").get("reference") == "palm",
    "package_name": lambda made: made.urdf.find(".//mesh").get("filename").startswith("package://my_description/"),
    "add_dummy_base_link": lambda made: made.urdf.find("link").get("name") == "base_footprint",
    "use_scads": lambda made: made.model.geom("palm_collision").size.tolist() == [0.025, 0.025, 0.01],
}  # fmt: skip
"""First name of a row → whether a robot with its YAML is as it says."""


@pytest.mark.parametrize(
    "row",
    [row for row in ROWS if row.yaml and row.theirs[0] not in EFFECTS],
    ids=lambda row: row.theirs[0],
)
def test_the_yaml_of_a_row_is_taken(tmp_path, row):
    assert holds(composed(tmp_path, row.yaml).tree(), yaml.safe_load(row.yaml))


@pytest.mark.slow
@pytest.mark.parametrize("name", EFFECTS)
def test_a_row_has_the_effect_that_it_claims(tmp_path, cache, name):
    (row,) = (row for row in ROWS if row.theirs[0] == name)
    plan = composed(tmp_path, row.yaml, f"cache.dir={cache}", "until=export")
    files = build_files(plan, in_memory=True).files
    model = mujoco.MjModel.from_xml_string(
        files["scene.xml"].decode(), {Path(path).name: data for path, data in files.items()}
    )
    assert EFFECTS[name](Made(files, model, parse_xml(files["arm.urdf"])))
