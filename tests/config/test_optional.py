"""Globs of presets may match nothing, so that robots can share them; the robot's own must match."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from linkwright.pipeline.config.compose import compose_plan
from linkwright.stages.export import export
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.robot.errors import ConfigError, LinkwrightError
from linkwright.stages.robot.optional_section import GLOB_KEYS, all_globs
from tests.fake_onshape.sample import sample_document
from tests.support.building import bundle_of
from tests.support.touching import no_memo
from tests.support.users import write

HEAD = "# @package _global_\n"
SAMPLE = f"{HEAD}defaults:\n  - override /source: sample\n  - override /mesh: visual\n"

LAB: dict[str, Any] = {
    "actuators": {"*wheel*": {"type": "velocity"}},
    "contact": {"exclude": [["*wheel*", "*fender*"]]},
    "depth": {"rigid": ["*motor*"], "flexible": ["*leg*"]},
    "frames": {"include": ["*imu*"]},
    "geoms": {"*sole*": {"collision": {"priority": 1}}},
    "ignore": {"visual": ["*cable*"], "collision": ["*sticker*"]},
    "joints": {"*ankle*": {"damping": 1}},
    "keyframes": {"crouch": {"*knee*": 0.3}},
    "loops": {"cut": ["*tie rod*"]},
    "mass": {"parts": {"Battery*": {"mass": 0.4}}, "links": {"*hull*": {"mass": 1}}},
    "mesh": {"colliders": {"*sole*": "box"}},
    "mirrors": {"*mirror*": {"normal": [0, 1, 0]}},
    "names": {"links": {"Torso*": "torso"}, "joints": {"Hip*": "hip"}},
    "relations": {"*differential*": {"invert": True}},
    "sensors": {
        "knees": {"type": "joint", "joints": "*knee*"},
        "drives": {"type": "actuator", "actuators": "*w*l"},
    },
}
"""A preset of a lab: for each key that holds globs one that nothing in the sample matches."""


def preset(folder: Path, path: str, content: Any) -> None:
    file = folder / f"{path}.yaml"
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(HEAD + yaml.safe_dump(content, sort_keys=False))


def codes(folder: Path, *arguments: str) -> list[tuple[str, str]]:
    """Code and place of all that the stages say about globs."""
    plan = compose_plan(arguments, cwd=folder).plan
    bundle = bundle_of(sample_document())
    found: list[Any] = []
    try:
        robot = build_robot(bundle, plan)
        found += robot.diagnostics
        geometry = make_geometry(robot, bundle, plan, no_memo)
        found += geometry.diagnostics
        found += export(robot, geometry, plan).diagnostics
    except LinkwrightError as error:
        found += error.problems
    return [(one.code, one.where) for one in found if one.code in ("I-GLOB", "E-GLOB", "E-RENAME")]


def test_the_lab_has_every_key_that_holds_globs() -> None:
    assert all_globs(LAB).keys() == set(GLOB_KEYS)


def test_globs_of_a_preset_match_nothing_with_a_word_and_no_error(tmp_path: Path) -> None:
    write(tmp_path, arm=SAMPLE)
    preset(tmp_path, "actuators/lab", LAB)
    said = codes(tmp_path, "robot=arm", "actuators=lab")
    assert {code for code, _ in said} == {"I-GLOB"}
    places = {
        where.partition(".")[0] if "." in where and where.split(".")[0] in ("sensors", "keyframes") else where
        for _, where in said
    }
    assert places == set(GLOB_KEYS)


@pytest.mark.slow
@pytest.mark.parametrize(
    "key", ["joints", "mass.parts", "geoms", "contact.exclude", "actuators", "sensors", "names.links"]
)
def test_the_same_globs_in_the_robots_file_are_errors(tmp_path: Path, key: str) -> None:
    head = key.partition(".")[0]
    write(tmp_path, arm=SAMPLE + yaml.safe_dump({head: LAB[head]}))
    assert {code for code, _ in codes(tmp_path, "robot=arm")} <= {"E-GLOB", "E-RENAME"}
    assert compose_plan(["robot=arm"], cwd=tmp_path).plan.optional == {}


def test_presets_are_of_any_group_but_the_robot_and_the_experiment(tmp_path: Path) -> None:
    write(
        tmp_path, base=SAMPLE + "geoms: {'*b': {}}\n", arm=f"{HEAD}defaults: [base]\ngeoms: {{'*a': {{}}}}\n"
    )
    for path, glob in (
        ("experiment/e", "*e"),
        ("variants/v", "*v"),
        ("ground/g", "*g"),
        ("root/deep/r", "*r"),
    ):
        preset(tmp_path, path, {"geoms": {glob: {}}})
    typed = [
        "robot=arm",
        "experiment=e",
        "+variants=v",
        "ground=g",
        "root=deep/r",
        "geoms.*t.collision.priority=1",
    ]
    plan = compose_plan(typed, cwd=tmp_path).plan
    assert set(plan.geoms) == {"*a", "*b", "*e", "*v", "*g", "*r", "*t"}
    assert {key: set(globs) for key, globs in plan.optional.items()} == {"geoms": {"*v", "*g", "*r"}}


def test_a_robot_for_legs_needs_no_feet(tmp_path: Path) -> None:
    feet = {"geoms": ("*[Ff]oot*",)}
    write(tmp_path, dog=f"{HEAD}defaults: [/robot/legged, override /source: sample]\n")
    for robot in ("dog", "legged"):
        assert compose_plan([f"robot={robot}", "source=sample"], cwd=tmp_path).plan.optional == feet
    assert compose_plan(["robot=sample"], cwd=tmp_path).plan.optional == {}


def test_the_place_of_a_preset_in_the_tree_counts(tmp_path: Path) -> None:
    write(tmp_path, arm=SAMPLE)
    (tmp_path / "mesh").mkdir()
    (tmp_path / "mesh" / "lab.yaml").write_text("collider: hull\ncolliders: {'*sole*': box}\n")
    assert compose_plan(["robot=arm", "mesh=lab"], cwd=tmp_path).plan.optional == {
        "mesh.colliders": ("*sole*",)
    }


def test_globs_that_a_robot_replaces_are_no_longer_optional(tmp_path: Path) -> None:
    write(
        tmp_path,
        arm=SAMPLE
        + "frames: {include: ['*tool*']}\noptional: {joints: ['*mine*']}\njoints: {'*mine*': {}}\n",
    )
    preset(tmp_path, "root/lab", {"frames": {"include": ["*imu*"]}})
    assert compose_plan(["robot=arm", "root=lab"], cwd=tmp_path).plan.optional == {"joints": ("*mine*",)}


def test_an_optional_glob_that_is_not_there_is_refused(tmp_path: Path) -> None:
    write(tmp_path, arm=SAMPLE + "optional: {joints: ['*ankel*']}\njoints: {'*ankle*': {damping: 1}}\n")
    with pytest.raises(ConfigError, match=r"optional.joints: joints has no glob '\*ankel\*'"):
        compose_plan(["robot=arm"], cwd=tmp_path)
    with pytest.raises(ConfigError, match="optional: masses holds no globs"):
        compose_plan(["source=sample", "optional.masses=[a]"], cwd=tmp_path)
