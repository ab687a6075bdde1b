"""The generated reference is that of the schema, whole, and its examples are valid."""

import functools
import json
import re
from collections.abc import Iterator
from typing import Annotated

import jsonschema
import pytest
import yaml
from pydantic import TypeAdapter

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.config.schema import is_section
from linkwright.pipeline.help_text import whole
from linkwright.pipeline.reference import SCHEMA
from linkwright.pipeline.reference.codes import explanations
from linkwright.pipeline.reference.environment import VARIABLES
from linkwright.pipeline.reference.key_entries import entries
from linkwright.pipeline.verbs import VERBS
from linkwright.pipeline.verbs.explain import explained, names
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.robot.section import Section
from tests.config import reference
from tests.config.regenerate import GOLDEN, REFERENCE
from tests.support.places import PROJECT
from tests.support.users import URL

KEYS = [entry for entry in reference.entries() if not entry.later and not entry.is_section]


@pytest.mark.parametrize("path", REFERENCE, ids=lambda path: path.name)
def test_a_generated_file_is_that_of_the_schema(path):
    assert path.read_text(encoding="utf-8") == REFERENCE[path](), "python -m tests.config.regenerate"


@pytest.mark.parametrize("entry", KEYS, ids=lambda entry: f"{entry.source}.{entry.key}")
def test_each_key_has_all_that_a_user_needs(entry):
    assert entry.type
    assert entry.default
    assert entry.example
    assert entry.meaning.endswith(".")
    assert "[m]" not in entry.meaning or not entry.unit


def given(section: type[Section], path: tuple[str, ...] = ()) -> Iterator[tuple[str, object, object]]:
    """Key, annotation and example of each key that gives one of its own."""
    for name, field in reference.fields(section):
        below, _ = reference._section_of(field.annotation)
        if field.examples:
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            yield ".".join((*path, name)), annotation, field.examples[0]
        if below is not None and is_section(below):
            yield from given(below, (*path, name))


EXAMPLES = [
    *given(Plan), *(one for kind, keys in SOURCES.items() for one in given(keys, (kind,)))
]  # fmt: skip


@pytest.mark.parametrize(("key", "annotation", "value"), EXAMPLES, ids=[one[0] for one in EXAMPLES])
def test_an_example_is_valid(key, annotation, value):
    TypeAdapter(annotation).validate_python(URL if key == "onshape.url" else value)


@pytest.mark.parametrize("entry", KEYS, ids=lambda entry: f"{entry.source}.{entry.key}")
def test_the_schema_takes_each_example(entry):
    validator().validate(yaml.safe_load(entry.example))


@functools.cache
def validator():
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("name", ["robot.sample", "robot.bare", "build"])
def test_the_schema_takes_a_whole_configuration(name):
    validator().validate(yaml.safe_load((GOLDEN / f"{name}.yaml").read_text(encoding="utf-8")))


@pytest.mark.parametrize(
    "text",
    [
        "defaults: [{override /source: onshape}]\nsource: {url: x}",
        "joints: {lift: {limits: [0, '${vars.reach}'], damping: '${oc.env:DAMPING,0.1}'}}",
        "links: {load: {parent: tool, joint: revolute}}",
    ],
)
def test_the_schema_accepts_every_valid_robot(text):
    validator().validate(yaml.safe_load(text))


@pytest.mark.parametrize(
    "text",
    ["jionts: {}", "joints: {a: {dampin: 1}}", "root: {base: fix}", "sensors: {a: sonar}", "name: 1"],
)
def test_the_schema_refuses_what_the_configuration_does(text):
    with pytest.raises(jsonschema.ValidationError):
        validator().validate(yaml.safe_load(text))


def test_the_help_lists_every_key_and_variable():
    text = whole()
    words = set(re.findall(r"[A-Za-z_]+", text))
    assert {entry.names[-1] for entry in KEYS} - {"kind"} <= words
    assert {one.name for one in VARIABLES} <= words
    assert set(VERBS) <= words


def test_every_variable_of_ours_is_in_the_reference():
    found = set()
    for package in ("pipeline", "stages"):
        for file in (PROJECT / package).rglob("*.py"):
            found |= set(re.findall(r'"((?:LINKWRIGHT|ONSHAPE)_[A-Z_]+)"', file.read_text()))
    older = {"ONSHAPE_SECRET_BEARER"}  # another name for a token, kept for the files that have it
    assert found - older <= {one.name for one in VARIABLES}


def test_the_readme_leads_to_the_reference():
    text = (PROJECT / "README.md").read_text()
    assert "pipeline/reference/KEYS.md" in text
    assert "# yaml-language-server: $schema=" in text


@pytest.mark.parametrize("name", [*names()])
def test_everything_can_be_explained(name):
    assert name in explained(name)


@pytest.mark.parametrize(
    ("asked", "shown"),
    [
        ("w-limit", "W-LIMIT (warning, reported by graph)"),
        ("joints.elbow.damping", "joints.<glob>.damping"),
        ("source.path", "source.path (of source=mjcf)"),
        ("mass.", "mass.missing"),
        ("validate.checks", "Checks of your own."),
        ("sensors.imu.noise", "sensors.<name>.noise"),
        ("onshape_auth", "ONSHAPE_AUTH"),
    ],
)
def test_an_entry_is_found_as_a_user_types_it(asked, shown, capsys):
    assert run(["explain", asked]) == 0
    assert shown in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "near"),
    [("E-LIMT", "did you mean E-LIMIT"), ("joint", "did you mean joints"), ("qqq", "--help")],
)
def test_for_an_unknown_one_the_nearest_is_suggested(asked, near, capsys):
    assert run(["explain", asked]) == 2
    assert near in capsys.readouterr().err


def test_the_path_of_the_schema_can_be_asked_for(capsys):
    assert run(["explain", "--schema"]) == 0
    assert capsys.readouterr().out.strip() == str(SCHEMA)


def test_the_checked_in_entries_read_back():
    assert entries() == reference.entries()
    assert explanations()
