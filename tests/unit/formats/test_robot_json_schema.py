"""The JSON Schema of robot.json, by a reader that is not ours, takes what is written and has all of it."""

import functools
import json

import jsonschema
import pytest

from linkwright.pipeline.reference import ROBOT_JSON_SCHEMA
from linkwright.stages.export import export
from linkwright.stages.export.robot_json import describe
from linkwright.stages.formats.robot_json.codec import entries_of
from linkwright.stages.formats.written import Written
from tests.config.robot_json import meanings, records
from tests.e2e.test_mjcf_motion import CASES
from tests.fake_onshape.sample import sample_document
from tests.property.test_described import BALL
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.mjcfs import built, model, written
from tests.support.robots import joint, robot_with
from tests.unit.export.test_srdf_source import robot as robot_with_srdf
from tests.unit.formats.test_described import text, whole

EVERY_FORMAT = {name: {} for name in ("urdf", "mjcf", "sdf", "usd", "ros2", "python")}

ADDED = {
    "sensors": {"imu": {"frame": "tool", "type": "imu"}, "eye": {"frame": "tool", "type": "camera"}},
    "actuators": {"*": {"type": "position", "encoder": True}},
    "keyframes": {"up": {"lift": 0.03}},
    "elements": {"ball": {"into": {"tag": "worldbody"}, "formats": ["mjcf"], "xml": BALL}},
    "export": EVERY_FORMAT,
}


@functools.cache
def validator():
    """The validator of the schema, for which a key that the schema does not have is an error, too."""
    schema = json.loads(ROBOT_JSON_SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    for table in (schema, *schema["$defs"].values()):
        table["additionalProperties"] = False
    return jsonschema.Draft202012Validator(schema)


def holds(data):
    table = json.loads(data)
    validator().validate(table)
    return table


@pytest.mark.parametrize("keys", [{}, ADDED], ids=["plain", "everything"])
def test_sample_is_as_the_schema_says(keys):
    plan = plan_of(**keys)
    outcome = export(robot_of(sample_document(), plan), NO_MESHES, plan)
    holds(outcome.files["robot.json"])


def test_other_robots_are_as_the_schema_says():
    """Every joint and loop, a build that ends early, a ball that a USD turns, and a robot with an SRDF."""
    holds(text(whole(0)))
    holds(describe(Written(whole(1))))
    robot = robot_with([joint("ball", "base", "arm", [(0.8, 0.0, 0.6, 0.0)])])
    table = holds(export(robot, NO_MESHES, plan_of(export={"usd": {}, "sdf": {}})).files["robot.json"])
    assert table["usd"]["zeros"]
    assert holds(describe(Written(robot_with_srdf())))["semantics"]["groups"]


@pytest.mark.parametrize("case", ["tendons", "loose", "ellipsoids"])
def test_robot_of_an_mjcf_is_as_the_schema_says(case, tmp_path):
    built(written(tmp_path, model(*CASES[case])), tmp_path / "out")
    assert holds((tmp_path / "out/robot.json").read_bytes())["mjcf"]["bodies"]


@pytest.mark.slow
@pytest.mark.parametrize(("change", "place"), [
    (lambda t: t["links"][0].pop("mass"), ["links", 0]),
    (lambda t: t["joints"][0].update(type="hinge"), ["joints", 0, "type"]),
    (lambda t: t["links"][0].update(com=[0, 0]), ["links", 0, "com"]),
    (lambda t: t["root_pose"].update(quat="x"), ["root_pose", "quat"]),
    (lambda t: t.update(surprise=1), []),
])  # fmt: skip
def test_table_that_breaks_the_schema_is_refused(change, place):
    table = json.loads(text(whole(0)))
    change(table)
    (error,) = validator().iter_errors(table)
    assert list(error.absolute_path) == place


def test_each_key_has_a_meaning_and_nothing_else_has():
    for kind in records().values():
        keys = {entry.key for entry in entries_of(kind) if not entry.inline}
        assert meanings(kind).keys() == keys, kind
