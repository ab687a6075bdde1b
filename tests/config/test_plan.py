# ruff: noqa: E501
"""The plan judges every key: what it says, and that it says everything at once."""

from typing import get_args

import pytest
from pydantic import ValidationError

from linkwright.pipeline.config.messages import diagnostics
from linkwright.pipeline.config.plan import SECTIONS, Plan, section
from linkwright.stages.fetch.bundle.sample.section import SampleSourceSection
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.optional_section import OptionalSection
from linkwright.stages.robot.section import Section, not_yet
from linkwright.stages.targets.section import TargetSections

SAMPLE = {"kind": "sample"}


def problem(**data):
    """The only problem of a plan: code, place, message, hint."""
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"source": SAMPLE, **data})
    (only,) = caught.value.problems
    return only.code, only.where, only.message, only.hint


def of_url(value):
    return problem(source={"kind": "onshape", "url": value})


@pytest.mark.parametrize(("data", "where", "message", "hint"), [
    ({"jonts": {}}, "jonts", "unknown key (given {})", "did you mean joints?"),
    ({"tolerance": 3}, "tolerance", "unknown key (given 3)", "did you mean scene.option.tolerance or mesh.tolerance?"),
    ({"xyzzy": 3}, "xyzzy", "unknown key (given 3)", "linkwright --help lists the keys"),
    ({"ground": {"colour": "red"}}, "ground.colour", "unknown key (given 'red')", "keys there: kind, size, xyz, rpy, friction, material"),
    ({"export": {"mjcf": {"x": 1}}}, "export.mjcf.x", "unknown key (given 1)", "keys there: fixed_joints"),
    ({"mass": {"links": {"tip": {"0": {"mass": 1}}}}}, "mass.links.tip.0", "unknown key (given {'mass': 1})", 'a name with a dot is quoted: mass.links["tip.0"]'),
    ({"joints": {"left.knee": {"dampng": 1}}}, 'joints["left.knee"].dampng', "unknown key (given 1)", 'did you mean joints["left.knee"].damping?'),
    ({"robot": {"name": "arm"}}, "robot", "the keys of the robot's file are under `robot`", "the first line of a robot's file must be: # @package _global_"),
    ({"source": {"kind": "sample", "url": "x"}}, "source.url", "source=sample has no such key (given 'x')", "it belongs to source=onshape"),
])  # fmt: skip
def test_an_unknown_key_is_named_with_what_may_be_meant(data, where, message, hint):
    assert problem(**data) == ("E-KEY", where, message, hint)


GALLERY = ", ".join(get_args(SampleSourceSection.model_fields["robot"].annotation))
CHOOSE = "choose one: source=onshape, source=urdf, source=mjcf, source=bundle, source=sample"


@pytest.mark.parametrize(("source", "shown"), [
    (None, ("E-MISSING", "source", "the robot has no source", CHOOSE)),
    ({}, ("E-MISSING", "source", "the robot has no source", CHOOSE)),
    ("arm.zip", ("E-VALUE", "source", "must be a mapping (given 'arm.zip')", CHOOSE)),
    ({"url": "u"}, ("E-MISSING", "source.kind", "missing (given {'url': 'u'})", CHOOSE)),
    ({"kind": "onshap"}, ("E-VALUE", "source.kind", "'onshap' is not allowed", CHOOSE)),
    ({"kind": "sample", "robot": "quadriped"}, ("E-VALUE", "source.robot", "'quadriped' is not allowed", f"did you mean quadruped? allowed: {GALLERY}")),
    ({"kind": "onshape"}, ("E-MISSING", "source.url", "missing", " ".join(OnshapeSourceSection.meanings()["url"].split()))),
])  # fmt: skip
def test_an_invalid_source_is_reported(source, shown):
    assert problem(source=source) == shown


@pytest.mark.parametrize(("data", "key", "message"), [
    ({"loops": {"solref": "x"}}, "loops.solref", "must be a list of 2 numbers (given 'x')"),
    ({"ground": {"size": "big"}}, "ground.size", "must be a list of 2 numbers (given 'big')"),
    ({"frames": {"include": "tool"}}, "frames.include", "must be a list (given 'tool')"),
    ({"loops": {"solref": [0.1, -1]}}, "loops.solref", "must be [time constant, damping ratio] above 0, or [-stiffness, -damping] (given [0.1, -1])"),
    ({"loops": {"solref": [1]}}, "loops.solref", "must be a list of 2 numbers (given [1])"),
    ({"ground": {"xyz": [1, 2, 3, 4]}}, "ground.xyz", "must be a list of 3 numbers (given [1, 2, 3, 4])"),
    ({"ground": {"rpy": [0, 0, float("nan")]}}, "ground.rpy[2]", "must be finite (given nan)"),
    ({"ground": {"rpy": [0, 0, True]}}, "ground.rpy[2]", "must be a number (given true)"),
    ({"ground": {"size": [1, -1]}}, "ground.size[1]", "must be greater than 0 (given -1)"),
    ({"joints": {"a": {"damping": "1"}}}, "joints.a.damping", "must be a number (given '1')"),
    ({"joints": {"a": {"friction": -1}}}, "joints.a.friction", "must be greater than or equal to 0 (given -1)"),
    ({"joints": {"a": {"limits": [1, 1]}}}, "joints.a.limits", "must be [lower, upper] with lower < upper (given [1, 1])"),
    ({"joints": {"a": {"limits": [0]}}}, "joints.a.limits", "must be a list of 2 numbers (given [0])"),
    ({"joints": {"a": {"limits": 1}}}, "joints.a.limits", "must be a list of 2 numbers (given 1)"),
    ({"joints": 3}, "joints", "must be a mapping (given 3)"),
    *(
        ({"variants": {"ranges": {"*.mass": share}}}, 'variants.ranges["*.mass"]', f"must be a number from 0, less than 1, or auto (given {share!r})")
        for share in (1, 1.5, -0.1, "5%", [0.1], float("nan"))
    ),
    ({"variants": 0.5}, "variants", "must be a mapping (given 0.5)"),
    ({"variants": "many"}, "variants", "must be a mapping (given 'many')"),
    ({"variants": [16]}, "variants", "must be a mapping (given [16])"),
    ({"output": ""}, "output", "must not be empty (given '')"),
    ({"export": {}}, "export", "no format is chosen; allowed: urdf, mjcf, sdf, ros2, usd, python, [urdf, mjcf, sdf, ros2, usd, python] (given {})"),
])  # fmt: skip
def test_wrong_value_is_reported_with_what_is_allowed(data, key, message):
    assert problem(**data) == ("E-VALUE", key, message, "")


@pytest.mark.parametrize("name", ["../x", "a/b", "a b", "", ".", "é", "a\n", "scene", "Scene", "SCENE"])
def test_a_name_that_is_no_file_name_or_the_scenes_is_refused(name):
    code, where, message, _ = problem(name=name)
    assert (code, where) == ("E-VALUE", "name")
    expected = "scene.xml" if name.lower() == "scene" else "letters, digits, _ and - only"
    assert expected in message or (not name and message == "must not be empty (given '')")


@pytest.mark.parametrize(
    "url", ["arm", "https://example.com/robot", "http://cad.onshape.com/documents/x", "https://u:hidden@x/y"]
)
def test_address_of_no_assembly_is_reported_without_its_key(url):
    code, where, message, hint = of_url(url)
    assert (code, where) == ("E-VALUE", "source.url")
    assert "address" in message
    assert hint
    assert "hidden" not in message + hint


@pytest.mark.parametrize("value", [6.123456789012345e31, 96374504495306324343, True])
def test_a_number_in_place_of_text_is_to_be_quoted(value):
    code, where, message, hint = of_url(value)
    assert (code, where) == ("E-VALUE", "source.url")
    assert message.startswith("must be text (given ")
    assert hint == """quote it: url: "..." in YAML, "source.url='...'" on the command line"""


@pytest.mark.parametrize(("data", "shown"), [
    ({"depth": {"rigid": ["*", 3]}}, ("depth.rigid[1]", "must be text (given 3)", 'quote it: ["..."]')),
    ({"mesh": None}, ("mesh", "has no value", "give it keys below, or remove the line")),
    ({"variants": 16}, ("variants", "must be a mapping (given 16)", "its keys are set by name, as variants.n=16")),
    ({"joints": {3: {}}}, ("joints", "names must be text (given 3)", 'put the name in quotes: "3": ...')),
])  # fmt: skip
def test_hint_about_a_number_shows_how_it_is_written(data, shown):
    assert problem(**data)[1:] == shown


class Later(Section):
    """A section with a key that is decided and has no function."""

    soon: tuple[str, ...] = not_yet(())


def test_key_without_function_is_refused_unless_default():
    Later.model_validate({"soon": []})
    with pytest.raises(ValidationError) as caught:
        Later.model_validate({"soon": ["mine"]})
    (only,) = diagnostics(caught.value, Later)
    hint = "leave it out: only its default works so far, []"
    assert (only.code, only.where, only.message, only.hint) == (
        "E-LATER", "soon", "not supported yet (given ['mine'])", hint,
    )  # fmt: skip


def test_each_key_belongs_to_one_stage():
    shared = OptionalSection.model_fields.keys() | TargetSections.model_fields.keys()
    owned = [*shared, *(name for keys in SECTIONS for name in keys.model_fields.keys() - shared)]
    assert len(owned) == len(set(owned))
    of_the_run = {"page", "objective", "cache", "vars", "plugins", "output", "overwrite", "until"}
    assert Plan.model_fields.keys() - set(owned) == of_the_run


def test_part_of_a_stage_has_that_stage_alone():
    plan = Plan.parse({"source": SAMPLE, "joints": {"b": {"damping": 1}, "a": {}}})
    assert list(section(plan, GraphSections)["joints"]) == ["b", "a"]
    assert set(section(plan, MeshSections)) == {"mesh", "geoms", "contact", "ignore", "optional", "target"}
    assert section(plan, MeshSections)["contact"] == {"exclude": [], "self": "auto"}
    null = Plan.parse({"source": SAMPLE, "joints": {"b": {"damping": 1}, "a": {"damping": None}}})
    assert section(null, GraphSections) == section(plan, GraphSections)


def test_the_folder_is_named_by_output_else_by_the_name():
    assert str(Plan.parse({"source": SAMPLE, "name": "arm"}).folder) == "outputs/arm"
    assert str(Plan.parse({"source": SAMPLE, "output": "there"}).folder) == "there"
