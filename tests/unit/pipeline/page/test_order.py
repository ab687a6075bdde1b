"""The order of joints, actuators and sensors in report.html and report.json."""

import json
from dataclasses import replace

from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.order import order
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.secrets import Secrets
from tests.support.building import plan_of
from tests.support.page_reader import Reader
from tests.unit.pipeline.page.test_document import REPORT

TABLES = {
    "mjcf": {
        "joints": [
            {
                "name": "ball",
                "kind": "ball",
                "unit": "quaternion (w, x, y, z)",
                "qpos": [7, 4],
                "dof": [6, 3],
                "urdf": ["ball_x", "ball_y", "ball_z"],
                "cad": "Ball <1>",
            },
            {
                "name": "elbow",
                "kind": "turn",
                "unit": "rad",
                "qpos": [12, 1],
                "dof": [10, 1],
                "urdf": ["elbow"],
                "cad": None,
            },
            {
                "name": "lift",
                "kind": "slide",
                "unit": "m",
                "qpos": [11, 1],
                "dof": [9, 1],
                "urdf": [],
                "cad": None,
            },
        ],
        "actuators": [
            {
                "name": "push",
                "ctrl": [3, 2],
                "type": "motor",
                "joint": "lift",
                "unit": "N",
                "range": [-5.0, 5.0],
                "cad": None,
            }
        ],
        "sensors": [
            {
                "name": "imu",
                "index": 0,
                "type": "gyro",
                "on": "tip",
                "address": 2,
                "dim": 3,
                "unit": "rad/s",
                "cad": None,
            },
            {
                "name": "odd",
                "index": 1,
                "type": "plugin",
                "on": None,
                "address": 5,
                "dim": None,
                "unit": None,
                "cad": None,
            },
        ],
    },
    "urdf": {
        "joints": [
            {
                "name": "lift",
                "index": 4,
                "tree": 6,
                "type": "prismatic",
                "unit": "m",
                "follows": "ball_x",
                "dof": "lift",
                "cad": None,
            }
        ]
    },
}


def test_the_page_has_a_table_of_each() -> None:
    read = Reader(page(replace(REPORT, details={"order": TABLES}), {}, {"arm.urdf": 1}, Secrets({})))
    for words in (
        "Joints in the order of MuJoCo",
        "hinge",
        "7 to 10",
        "6 to 8",
        "ball_x, ball_y, ball_z",
        "Ball <1>",
        "Actuators in the order of ctrl",
        "-5 to 5",
        "3 to 4",
        "Sensors in the order of sensordata",
        "2 to 4",
        "Joints in the order of the URDF",
        "prismatic",
    ):
        assert words in read.text
    assert "None" not in read.text


def test_it_has_none_where_nothing_is_there() -> None:
    assert order({}) == ""
    assert "sensordata" not in order({"mjcf": {**TABLES["mjcf"], "sensors": []}})


def test_the_report_of_a_build_has_the_tables_of_robot_json_also_from_the_cache(tmp_path) -> None:
    plan = plan_of(cache={"dir": str(tmp_path)}, until="export", sensors={"all": "joint"})
    first, second = (build_files(plan, in_memory=True) for _ in range(2))
    expected = json.loads(first.files["robot.json"])["order"]
    assert len(expected["mjcf"]["sensors"]) == 2 * len(expected["urdf"]["joints"])
    assert first.report.details["order"] == second.report.details["order"] == expected
