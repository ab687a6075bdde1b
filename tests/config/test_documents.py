"""What the documents show of the sample is what a user gets, beyond their blocks, which tests/docs runs.

To make the picture: `linkwright until=graph`; outputs/sample.graph/graph.svg is docs/pictures/graph.svg.
"""

import re
from functools import cache
from pathlib import Path
from textwrap import dedent

import mujoco
import pytest
import yaml

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build_files
from linkwright.stages.export import export
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.robot.section import Section
from linkwright.stages.show.graph_view.picture import draw
from tests.fake_onshape.sample import sample_document
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.pages import code
from tests.support.places import PROJECT
from tests.support.users import GLOBAL, write

FROM_SAMPLE = f"{GLOBAL}defaults: [{{override /source: sample}}, {{override /mesh: visual}}]\n"
"""Without colliders, which take most of the time of a build."""


def block(page, *words):
    """The YAML block of a page that has these words."""
    return next(dedent(text) for text in code(page, "yaml") if all(word in text for word in words))


def composed(folder, text):
    return compose_plan(["robot=my_arm"], (), write(folder, my_arm=FROM_SAMPLE + text))


@cache
def the_sample():
    return robot_of(sample_document(), plan_of(name="sample"))


def test_yaml_of_the_changelog_restores_earlier_defaults(tmp_path):
    text = (PROJECT / "CHANGELOG.md").read_text()
    (lines,) = re.findall(r"^ *<!-- as_before -->\n *```yaml\n(.*?)^ *```$", text, re.DOTALL | re.MULTILINE)
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


def test_motor_adds_its_values_to_those_of_all_joints(tmp_path):
    """The snippet of `joints` gives damping, armature, effort and velocity to every joint; that of
    `actuators` names a motor for the elbow."""
    joints = yaml.safe_load(block("docs/guide/joints.md", "joints:", "effort"))["joints"]
    text = yaml.safe_dump({"joints": {"*": joints["*"]}}) + block("docs/guide/actuators.md", "motor: sts3215")
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


def test_every_key_of_the_kinematics_is_in_the_guide():
    printed = set()
    for page in (PROJECT / "docs" / "guide").glob("*.md"):
        for line in page.read_text(encoding="utf-8").splitlines():
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


def test_the_picture_is_that_of_the_sample():
    noise = re.compile(r"[\d.]+e-\d+")  # a residual, which is all rounding
    ours = (PROJECT / "docs" / "pictures" / "graph.svg").read_text()
    assert noise.sub("0", ours) == noise.sub("0", draw(the_sample()).decode())
