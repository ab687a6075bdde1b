"""The plan judges every key: what it says, and that it says everything at once."""

import pytest
from pydantic import ValidationError

from linkwright.pipeline.config.messages import diagnostics
from linkwright.pipeline.config.plan import SECTIONS, Plan, section
from linkwright.pipeline.config.schema import annotation_at, is_section, leaves, names
from linkwright.stages.fetch.onshape.section import OnshapeSourceSection
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.optional_section import OptionalSection
from linkwright.stages.robot.section import Section, not_yet
from tests.support.users import URL

SAMPLE = {"kind": "sample"}
ONSHAPE = {"kind": "onshape", "url": URL}


def problems(**data):
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"source": SAMPLE, **data})
    return [(one.code, one.where, one.message, one.hint) for one in caught.value.problems]


def problem(**data):
    (only,) = problems(**data)
    return only


def test_two_errors_are_reported_in_one_message():
    with pytest.raises(ConfigError) as caught:
        Plan.parse({"source": SAMPLE, "mesh": {"tolerence": 1}, "until": "grph"})
    assert str(caught.value) == (
        "the configuration has 2 problems\n"
        "  E-KEY mesh.tolerence: unknown key (given 1)\n"
        "      did you mean mesh.tolerance?\n"
        "  E-VALUE until: 'grph' is not allowed\n"
        "      did you mean graph? allowed: fetch, graph, mesh, export, validate"
    )


@pytest.mark.parametrize(
    ("data", "shown"),
    [
        ({"jonts": {}}, ("E-KEY", "jonts", "unknown key (given {})", "did you mean joints?")),
        (
            {"tolerance": 3},
            (
                "E-KEY",
                "tolerance",
                "unknown key (given 3)",
                "did you mean scene.option.tolerance or mesh.tolerance?",
            ),
        ),
        ({"xyzzy": 3}, ("E-KEY", "xyzzy", "unknown key (given 3)", "linkwright --help lists the keys")),
        (
            {"ground": {"colour": "red"}},
            (
                "E-KEY",
                "ground.colour",
                "unknown key (given 'red')",
                "keys there: kind, size, xyz, rpy, friction, material",
            ),
        ),
        (
            {"export": {"mjcf": {"x": 1}}},
            ("E-KEY", "export.mjcf.x", "unknown key (given 1)", "keys there: fixed_joints"),
        ),
        (
            {"mass": {"links": {"tip": {"0": {"mass": 1}}}}},
            (
                "E-KEY",
                "mass.links.tip.0",
                "unknown key (given {'mass': 1})",
                'a name with a dot is quoted: mass.links["tip.0"]',
            ),
        ),
        (
            {"joints": {"left.knee": {"dampng": 1}}},
            (
                "E-KEY",
                'joints["left.knee"].dampng',
                "unknown key (given 1)",
                'did you mean joints["left.knee"].damping?',
            ),
        ),
        (
            {"robot": {"name": "arm"}},
            (
                "E-KEY",
                "robot",
                "the keys of the robot's file lie under `robot`",
                "the first line of a robot's file must be: # @package _global_",
            ),
        ),
        (
            {"source": {"kind": "sample", "url": "x"}},
            (
                "E-KEY",
                "source.url",
                "source=sample has no such key (given 'x')",
                "it belongs to source=onshape",
            ),
        ),
    ],
)
def test_an_unknown_key_is_named_with_what_may_be_meant(data, shown):
    assert problem(**data) == shown


KINDS = ("onshape", "urdf", "mjcf", "bundle", "sample")
CHOOSE = f"choose one: {', '.join(f'source={kind}' for kind in KINDS)}"


@pytest.mark.parametrize(
    ("source", "shown"),
    [
        (None, ("E-MISSING", "source", "the robot has no source", CHOOSE)),
        ({}, ("E-MISSING", "source", "the robot has no source", CHOOSE)),
        ("arm.zip", ("E-VALUE", "source", "must be a mapping (given 'arm.zip')", CHOOSE)),
        ({"url": "u"}, ("E-MISSING", "source.kind", "missing (given {'url': 'u'})", CHOOSE)),
        ({"kind": "onshap"}, ("E-VALUE", "source.kind", "'onshap' is not allowed", CHOOSE)),
        (
            {"kind": "onshape"},
            ("E-MISSING", "source.url", "missing", " ".join(OnshapeSourceSection.meanings()["url"].split())),
        ),
    ],
)
def test_a_source_that_is_invalid_is_reported(source, shown):
    assert problem(source=source) == shown


def test_a_plan_without_source_is_no_plan():
    with pytest.raises(ConfigError, match="the robot has no source"):
        Plan.parse({})


@pytest.mark.parametrize(
    ("data", "key", "message"),
    [
        ({"loops": {"solref": "x"}}, "loops.solref", "must be a list of 2 numbers (given 'x')"),
        ({"ground": {"size": "big"}}, "ground.size", "must be a list of 2 numbers (given 'big')"),
        ({"frames": {"include": "tool"}}, "frames.include", "must be a list (given 'tool')"),
        (
            {"loops": {"solref": [0.1, -1]}},
            "loops.solref",
            "must be [time constant, damping ratio] above 0, or [-stiffness, -damping] (given [0.1, -1])",
        ),
        ({"loops": {"solref": [1]}}, "loops.solref", "must be a list of 2 numbers (given [1])"),
        ({"ground": {"xyz": [1, 2, 3, 4]}}, "ground.xyz", "must be a list of 3 numbers (given [1, 2, 3, 4])"),
        ({"ground": {"rpy": [0, 0, float("nan")]}}, "ground.rpy[2]", "must be finite (given nan)"),
        ({"ground": {"rpy": [0, 0, True]}}, "ground.rpy[2]", "must be a number (given true)"),
        ({"ground": {"size": [1, -1]}}, "ground.size[1]", "must be greater than 0 (given -1)"),
        ({"joints": {"a": {"damping": "1"}}}, "joints.a.damping", "must be a number (given '1')"),
        (
            {"joints": {"a": {"friction": -1}}},
            "joints.a.friction",
            "must be greater than or equal to 0 (given -1)",
        ),
        (
            {"joints": {"a": {"limits": [1, 1]}}},
            "joints.a.limits",
            "must be [lower, upper] with lower < upper (given [1, 1])",
        ),
        ({"joints": {"a": {"limits": [0]}}}, "joints.a.limits", "must be a list of 2 numbers (given [0])"),
        ({"joints": {"a": {"limits": 1}}}, "joints.a.limits", "must be a list of 2 numbers (given 1)"),
        ({"joints": 3}, "joints", "must be a mapping (given 3)"),
        ({"mesh": None}, "mesh", "must be a mapping (given null)"),
        ({"output": ""}, "output", "must not be empty (given '')"),
        (
            {"export": {}},
            "export",
            "no format is chosen; allowed: urdf, mjcf, sdf, ros2, usd, python, "
            "[urdf, mjcf, sdf, ros2, usd, python] (given {})",
        ),
    ],
)
def test_a_wrong_value_is_reported_with_the_value_and_what_is_allowed(data, key, message):
    assert problem(**data) == ("E-VALUE", key, message, "")


@pytest.mark.parametrize("name", ["../x", "a/b", "a b", "", ".", "é", "a\n"])
def test_a_name_that_is_no_file_name_is_refused(name):
    code, where, message, _ = problem(name=name)
    assert (code, where) == ("E-VALUE", "name")
    assert "letters, digits, _ and - only" in message or message == "must not be empty (given '')"


@pytest.mark.parametrize("name", ["scene", "Scene", "SCENE"])
def test_a_name_whose_file_would_take_the_place_of_the_scene_is_refused(name):
    code, where, message, _ = problem(name=name)
    assert (code, where) == ("E-VALUE", "name")
    assert "scene.xml" in message


@pytest.mark.parametrize(
    "url", ["arm", "https://example.com/robot", "http://cad.onshape.com/documents/x", "https://u:hidden@x/y"]
)
def test_an_address_that_can_be_no_assembly_is_reported_without_what_it_may_hide(url):
    code, where, message, hint = problem(source={"kind": "onshape", "url": url})
    assert (code, where) == ("E-VALUE", "source.url")
    assert "address" in message
    assert hint
    assert "hidden" not in message + hint


@pytest.mark.parametrize("value", [6.123456789012345e31, 96374504495306324343, True])
def test_a_number_where_text_is_expected_is_reported_to_be_quoted(value):
    code, where, message, hint = problem(source={"kind": "onshape", "url": value})
    assert (code, where) == ("E-VALUE", "source.url")
    assert message.startswith("must be text (given ")
    assert hint == """quote it: url: "..." in YAML, "source.url='...'" on the command line"""
    assert problem(depth={"rigid": ["*", 3]})[1:] == (
        "depth.rigid[1]",
        "must be text (given 3)",
        'quote it: ["..."]',
    )


def test_a_number_as_the_name_of_a_joint_is_reported_to_be_quoted():
    assert problem(joints={3: {}}) == (
        "E-VALUE",
        "joints",
        "names must be text (given 3)",
        'put the name in quotes: "3": ...',
    )


class Later(Section):
    """A section with a key that is decided and has no function."""

    soon: tuple[str, ...] = not_yet(())


def test_a_key_without_function_is_refused_by_name_unless_at_its_default():
    Later.model_validate({"soon": []})
    with pytest.raises(ValidationError) as caught:
        Later.model_validate({"soon": ["mine"]})
    (found,) = diagnostics(caught.value, Later)
    assert (found.code, found.where, found.message, found.hint) == (
        "E-LATER",
        "soon",
        "not supported yet (given ['mine'])",
        "leave it out: only its default works so far, []",
    )


def test_every_key_of_the_tree_is_documented():
    undocumented = [
        f"{owner.__name__}.{name}"
        for owner in _sections(Plan)
        for name in set(names(owner)) - set(owner.meanings())
    ]
    assert undocumented == []


def _sections(root):
    yield root
    yield from SOURCES.values()
    for name in names(root):
        below = annotation_at(root, (name,))
        if is_section(below):
            yield from _sections(below)


def test_each_key_belongs_to_one_stage():
    own = (
        OptionalSection.model_fields,
        *(keys.model_fields.keys() - OptionalSection.model_fields for keys in SECTIONS),
    )
    owned = [name for names in own for name in names]
    assert len(owned) == len(set(owned))
    assert {name for name in Plan.model_fields if name not in owned} == {
        "page",
        "cache",
        "vars",
        "plugins",
        "output",
        "overwrite",
        "until",
    }


def test_the_part_of_a_stage_holds_that_stage_alone_and_keeps_the_order_of_mappings():
    plan = Plan.parse({"source": SAMPLE, "joints": {"b": {"damping": 1}, "a": {}}})
    assert list(section(plan, GraphSections)["joints"]) == ["b", "a"]
    assert set(section(plan, MeshSections)) == {"mesh", "geoms", "contact", "ignore", "optional"}
    assert section(plan, MeshSections)["contact"] == {"exclude": [], "self": "auto"}


def test_a_property_of_a_joint_that_is_left_out_is_the_same_as_one_that_is_null():
    left_out, null = ({"source": SAMPLE, "joints": {"wrist": keys}} for keys in ({}, {"damping": None}))
    assert section(Plan.parse(left_out), GraphSections) == section(Plan.parse(null), GraphSections)


def test_the_folder_is_named_by_output_else_by_the_name():
    assert str(Plan.parse({"source": SAMPLE, "name": "arm"}).folder) == "outputs/arm"
    assert str(Plan.parse({"source": SAMPLE, "output": "there"}).folder) == "there"


def test_the_tree_has_the_keys_of_every_section():
    keys = set(leaves(Plan))
    assert {"name", "source.url", "source.path", "mesh.visual.merge", "contact.self", "loops.solref"} <= keys
