"""What the README shows is what a user gets: its YAML, its commands, the sample's tree and picture.

To make the picture: `linkwright until=graph`; outputs/sample.graph/graph.svg is
tests/fake_onshape/sample.svg.
"""

import re
import shlex
from functools import cache
from pathlib import Path
from textwrap import dedent

import mujoco
import pytest
import yaml

from linkwright.pipeline.cli import parse
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.export import export
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.section import Section
from linkwright.stages.show.graph_view.outline import outline
from linkwright.stages.show.graph_view.picture import draw
from tests.fake_onshape.sample import sample_document
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.places import PROJECT
from tests.support.users import GLOBAL, URL, put, write

README = (PROJECT / "README.md").read_text().replace("https://cad.onshape.com/documents/.../w/.../e/...", URL)
BLOCK = re.compile(r"(?:^ *<!-- (\w+) -->\n)?^( *)```(\w*)\n(.*?)^ *```$", re.DOTALL | re.MULTILINE)
ROBOT = """<robot name="so101">
  <link name="base"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
# Without colliders, which take most of the time of a build.
FROM_SAMPLE = f"{GLOBAL}defaults: [{{override /source: sample}}, {{override /mesh: visual}}]\n"


def blocks(language):
    """(mark, text) of each block in this language, without the indentation of a list."""
    return [
        (mark, re.sub(f"^{indent}", "", text, flags=re.MULTILINE))
        for mark, indent, fence, text in BLOCK.findall(README)
        if fence == language
    ]


def marked(mark):
    return next(
        text for language in ("", "yaml", "python") for fence, text in blocks(language) if fence == mark
    )


def composed(folder, text):
    if "override /robot:" in text:
        put(folder, {"experiment/wide.yaml": text})
        return compose_plan(["experiment=wide"], (), write(folder, my_arm=FROM_SAMPLE))
    robot = text if text.startswith(GLOBAL) else FROM_SAMPLE + text
    return compose_plan(["robot=my_arm"], (), write(folder, my_arm=robot))


@cache
def the_sample():
    return robot_of(sample_document(), plan_of(name="sample"))


def commands():
    """Arguments of each single build that the README shows."""
    lines = [line for _, text in blocks("sh") for line in text.splitlines()]
    typed_lines = [shlex.split(line, comments=True)[1:] for line in lines if line.startswith("linkwright ")]
    return [words for words in typed_lines if words[0] not in (*VERBS, "-m", "--install-completion")]


def test_the_environment_is_active_before_the_first_command_in_it():
    lines = [line for _, text in blocks("sh") for line in text.splitlines()]
    bare = [number for number, line in enumerate(lines) if line.startswith(("linkwright", "python -m"))]
    assert lines.index(". .venv/bin/activate") < min(bare)


@pytest.mark.parametrize("number", range(len(blocks("yaml"))))
def test_each_yaml_block_composes(tmp_path, number):
    _, text = blocks("yaml")[number]
    assert composed(tmp_path, text).robot == "my_arm"


@pytest.mark.parametrize("words", commands(), ids=" ".join)
def test_each_command_composes(tmp_path, words):
    folder = write(tmp_path, my_arm=FROM_SAMPLE)
    put(folder, {"experiment/wide.yaml": GLOBAL})
    command = parse([word.replace("~/robots", str(folder)) for word in words])
    compose_plan(command.overrides, command.config_dirs, folder)


def test_the_yaml_of_the_changelog_brings_the_defaults_of_before_back(tmp_path):
    text = (PROJECT / "CHANGELOG.md").read_text()
    (lines,) = [block for mark, _, _, block in BLOCK.findall(text) if mark == "as_before"]
    robot = dedent(lines).replace("defaults:\n", "defaults:\n  - override /source: sample\n")
    arguments = [f"cache.dir={tmp_path}/cache", "robot=my_arm", "until=export"]
    plan = compose_plan(arguments, (), write(tmp_path, my_arm=GLOBAL + robot)).plan
    files = build_files(plan, in_memory=True).files
    meshes = {Path(name).name: data for name, data in files.items() if name.startswith("assets/")}
    model = mujoco.MjModel.from_xml_string(files["my_arm.xml"].decode(), meshes)
    collide = [geom for geom in range(model.ngeom) if model.geom_contype[geom]]
    assert sorted(model.geom_bodyid[collide]) == list(range(1, 12))
    assert max(model.mesh_vertnum[model.geom_dataid[collide]]) > 64
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    assert data.ncon == 0
    assert model.body("base_plate").pos.tolist() == [0, 0, 0]


def test_the_keys_of_the_kinematics_make_a_robot_of_the_sample(tmp_path):
    robot = robot_of(sample_document(), composed(tmp_path, marked("sample")).plan)
    assert {"base_footprint", "payload"} <= {link.name for link in robot.links}
    assert "elbow_pitch" in {joint.name for joint in robot.joints}
    assert not robot.base.fixed


def test_the_motor_of_the_actuators_has_its_values_beside_the_properties_of_all_joints(tmp_path):
    """The snippet of `joints` gives damping, armature, effort and velocity to every joint; that of
    `actuators` names a motor for one of them, here for the sample's elbow."""
    texts = [text for _, text in blocks("yaml")]
    (joints,) = [text for text in texts if text.startswith("joints:\n") and "effort" in text]
    (driven,) = [text for text in texts if text.startswith("actuators:") and "motor: " in text]
    entry = yaml.safe_load(driven)["actuators"]["hip"]
    text = f"{joints}actuators: {{'*': position, elbow: {entry}}}\n"
    plan = composed(tmp_path, text).plan
    robot = robot_of(sample_document(), plan)
    files = export(robot, NO_MESHES, plan).files
    model = mujoco.MjModel.from_xml_string(files[f"{robot.name}.xml"].decode())
    joint, servo = model.joint("elbow"), model.actuator("elbow")
    assert joint.armature[0] == 0.0284
    assert joint.damping[0] == pytest.approx(0.05909 + 0.5486)
    assert joint.frictionloss[0] == 0.05239
    assert list(model.jnt_actfrcrange[joint.id]) == [-3.35, 3.35]
    assert servo.gainprm[0] == 17.8
    assert model.joint("shoulder").armature[0] == 0.01


def test_every_key_of_the_kinematics_is_in_the_readme():
    printed = set()
    for line in README.splitlines():
        if line.startswith("| `"):
            first, *more = re.findall("`([^`]+)`", line.split(" | ")[0])
            printed |= {first, *(first.partition(".")[0] + key for key in more)}
    wanted = set()
    for name, field in GraphSections.model_fields.items():
        inside = field.annotation
        if isinstance(inside, type) and issubclass(inside, Section):
            wanted |= {f"{name}.{key}" for key in inside.model_fields}
        elif name != "name":
            wanted.add(name)
    assert printed >= wanted


def test_the_python_example_runs(tmp_path, monkeypatch):
    monkeypatch.chdir(write(tmp_path, my_arm=FROM_SAMPLE))
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path / "cache"))
    (tmp_path / "so101.urdf").write_text(ROBOT)
    namespace = {}
    exec(marked("python"), namespace)
    assert namespace["forearm"].shape == (4, 4)
    assert namespace["inertia"].shape == (namespace["model"].nv, namespace["model"].nv)
    assert {path.name for path in tmp_path.iterdir()} == {"cache", "robot", "so101.urdf"}


def test_the_tree_is_that_of_the_sample():
    shown = marked("outline").splitlines()
    lines = iter(outline(the_sample()).splitlines())
    assert [line for line in shown if line != "..." and line not in lines] == []


def test_the_picture_is_that_of_the_sample():
    noise = re.compile(r"[\d.]+e-\d+")  # a residual, which is all rounding
    ours = (PROJECT / "tests" / "fake_onshape" / "sample.svg").read_text()
    assert noise.sub("0", ours) == noise.sub("0", draw(the_sample()).decode())
