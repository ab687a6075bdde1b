"""robot.json alone: what is read from it is the robot that was written, whose files pass every check
against it."""

import tempfile
from pathlib import Path

import pytest

from linkwright.stages.formats.described import read_robot_json
from linkwright.stages.robot.dynamics.driven import with_actuation
from linkwright.stages.validate import validate
from tests.fake_onshape.sample import sample_document
from tests.support.building import write
from tests.support.drawn import PLACES, any_document, drawn, each
from tests.support.truth import differences

pytestmark = pytest.mark.e2e

NEAR = 1e-11

NOT_IN_IT = {
    "mesh": "the triangles of a part",
    "diagnostics": "what a build told",
    "controls": "the source's own words",
    "actuators": "those of the source",
    "sensors": "those of the source",
    "joint": "the name of the base's joint, which is chosen where the source has none",
    "named": "whose entry gave a value: only motors ask",
    "given": "of a ball's limits it is not told apart what the configuration gave",
}

BALL = "<body name='ball' pos='3 0 1'><freejoint name='ball'/><geom name='ball' size='.1'/></body>"

KEYS = {
    "actuators": {"*": "position"},
    "joints": {"*": {"damping": 0.25, "friction": 0.125, "effort": 5}},
    "export": {"urdf": {"fixed_joints": "merge"}, "mjcf": {"fixed_joints": "merge"}, "sdf": {}},
}


def comes_back(document, root, seed, **keys):
    """The robot and its actuation, and the verdict on its files."""
    robot, plan = drawn(document, root, seed, **keys)
    with tempfile.TemporaryDirectory() as folder:
        exported = write(robot, Path(folder), plan)
        truth = read_robot_json((Path(folder) / "robot.json").read_bytes())
        checks = validate(Path(folder), truth.written, plan)
        before = validate(Path(folder), exported.written, plan)
    written, read = exported.written, truth.written
    assert differences(written.robot, with_actuation(robot, written.actuation), 0.0, {}) == []
    assert differences(written.robot, read.robot, NEAR, NOT_IN_IT) == []
    # Where links on fixed joints are merged and there are none, nothing is.
    assert differences(written.urdf_form, read.urdf_form, 1e-5, {"merged": ""}) == []
    assert differences(written.as_urdf.robot, read.as_urdf.robot, NEAR, NOT_IN_IT) == []
    assert differences(written.mjcf_form, read.mjcf_form, 0.0, {}) == []
    assert differences(written.sensing, read.sensing, NEAR, {}) == []
    rounded = {"load": "", "home_load": "", "supplied": "", "overridden": ""}
    assert differences(written.actuation, read.actuation, NEAR, rounded) == []
    assert [check for check in checks if check.fails] == []
    assert [check.name for check in checks] == [check.name for check in before]


@pytest.mark.parametrize(
    ("everything", "count"), [(False, 4), pytest.param(None, 20, marks=pytest.mark.slow)]
)
def test_documents_come_back(everything, count):
    def check(document, root, seed):
        comes_back(document, root, seed, **(KEYS if seed % 2 else {}))

    each(check, count, any_document(everything), PLACES, PLACES)


def test_the_sample_comes_back_with_what_the_user_adds():
    more = {
        "sensors": {"imu": {"frame": "tool", "type": "imu"}, "eye": {"frame": "tool", "type": "camera"}},
        "keyframes": {"up": {"lift": 0.03}},
        "elements": {"ball": {"into": {"tag": "worldbody"}, "formats": ["mjcf"], "xml": BALL}},
    }
    comes_back(sample_document(), 0, 1, **more, **KEYS)
