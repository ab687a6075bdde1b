"""The order of joints, actuators and sensors in report.html and report.json."""

import json
from dataclasses import replace

import pytest

from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.order import order
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.secrets import Secrets
from tests.support.building import plan_of
from tests.support.page_reader import Reader
from tests.unit.pipeline.page.test_document import REPORT


def rows(keys, *values):
    return [dict(zip(keys.split(), row, strict=True)) for row in values]


TABLES = {
    "mjcf": {
        "joints": rows(
            "name kind unit qpos dof urdf cad",
            ("ball", "ball", "quaternion (w, x, y, z)", [7, 4], [6, 3], ["ball_x", "ball_y", "ball_z"],
             "Ball <1>"),
            ("elbow", "turn", "rad", [12, 1], [10, 1], ["elbow"], None),
            ("lift", "slide", "m", [11, 1], [9, 1], [], None),
        ),
        "actuators": rows("name ctrl type joint unit range cad", (
            "push", [3, 2], "motor", "lift", "N", [-5.0, 5.0], None,
        )),
        "sensors": rows(
            "name index type on address dim unit cad",
            ("imu", 0, "gyro", "tip", 2, 3, "rad/s", None),
            ("odd", 1, "plugin", None, 5, None, None, None),
        ),
    },
    "urdf": {
        "joints": rows("name index tree type unit follows dof cad", (
            "lift", 4, 6, "prismatic", "m", "ball_x", "lift", None,
        )),
    },
}  # fmt: skip


def test_the_page_has_a_table_of_each_that_is_there():
    read = Reader(page(replace(REPORT, details={"order": TABLES}), {}, {"arm.urdf": 1}, Secrets({})))
    assert not read.lacking(
        "Joints in the order of MuJoCo", "hinge", "7 to 10", "6 to 8", "ball_x, ball_y, ball_z", "Ball <1>",
        "Actuators in the order of ctrl", "-5 to 5", "3 to 4", "Sensors in the order of sensordata", "2 to 4",
        "Joints in the order of the URDF", "prismatic",
    )  # fmt: skip
    assert "None" not in read.text
    assert order({}) == ""
    assert "sensordata" not in order({"mjcf": {**TABLES["mjcf"], "sensors": []}})


@pytest.mark.e2e
def test_the_report_of_a_build_has_the_tables_of_robot_json_also_from_the_cache(tmp_path):
    plan = plan_of(
        cache={"dir": str(tmp_path)}, until="export", mesh__collider="visual", sensors={"all": "joint"}
    )
    first, second = (build_files(plan, in_memory=True) for _ in range(2))
    expected = json.loads(first.files["robot.json"])["order"]
    assert len(expected["mjcf"]["sensors"]) == 2 * len(expected["urdf"]["joints"])
    assert first.report.details["order"] == second.report.details["order"] == expected
