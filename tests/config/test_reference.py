"""The generated reference is that of the schema, whole, and its examples are valid."""

import functools
import json
import re
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
from tests.config import reference
from tests.config.regenerate import GOLDEN, REFERENCE
from tests.support.places import PROJECT
from tests.support.users import URL

KEYS = [entry for entry in reference.entries() if not entry.later and not entry.is_section]


@pytest.mark.parametrize("path", REFERENCE, ids=lambda path: path.name)
def test_a_generated_file_is_that_of_the_schema(path):
    assert path.read_text(encoding="utf-8") == REFERENCE[path](), "python -m tests.config.regenerate"


def test_each_key_has_all_that_a_user_needs():
    assert [entry.key for entry in reference.entries() if not entry.meaning] == []
    for entry in KEYS:
        assert entry.type, entry
        assert entry.default, entry
        assert entry.example, entry
        assert entry.meaning.endswith("."), entry
        assert "[m]" not in entry.meaning or not entry.unit, entry


def key_examples(section, path=()):
    """Key, annotation and example of each key that gives its own example."""
    for name, field in reference.fields(section):
        below, _ = reference._section_of(field.annotation)
        if field.examples:
            annotation = Annotated[field.annotation, *field.metadata] if field.metadata else field.annotation
            yield ".".join((*path, name)), annotation, field.examples[0]
        if below is not None and is_section(below):
            yield from key_examples(below, (*path, name))


def test_each_example_is_valid_for_its_key_and_for_the_schema():
    kinds = (key for kind, keys in SOURCES.items() for key in key_examples(keys, (kind,)))
    for key, annotation, value in (*key_examples(Plan), *kinds):
        TypeAdapter(annotation).validate_python(URL if key == "onshape.url" else value)
    for entry in KEYS:
        validator().validate(yaml.safe_load(entry.example))


@functools.cache
def validator():
    schema = json.loads(SCHEMA.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator.check_schema(schema)
    return jsonschema.Draft202012Validator(schema)


@pytest.mark.parametrize("text", [
    *(
        (GOLDEN / f"{name}.yaml").read_text(encoding="utf-8")
        for name in ("robot.sample", "robot.bare", "build")
    ),
    "defaults: [{override /source: onshape}]\nsource: {url: x}",
    "joints: {lift: {limits: [0, '${vars.reach}'], damping: '${oc.env:DAMPING,0.1}'}}",
    "links: {load: {parent: tool, joint: revolute}}",
], ids=["robot.sample", "robot.bare", "build", "defaults", "interpolations", "short forms"])  # fmt: skip
def test_the_schema_accepts_valid_robots(text):
    validator().validate(yaml.safe_load(text))


@pytest.mark.parametrize(
    "text", ["jionts: {}", "joints: {a: {dampin: 1}}", "root: {base: fix}", "sensors: {a: sonar}", "name: 1"]
)
def test_the_schema_refuses_what_the_configuration_does(text):
    with pytest.raises(jsonschema.ValidationError):
        validator().validate(yaml.safe_load(text))


def test_the_help_lists_every_key_and_documents_lead_to_them():
    text = whole()
    words = set(re.findall(r"[A-Za-z_]+", text))
    assert {entry.names[-1] for entry in KEYS} - {"kind"} <= words
    assert {variable.name for variable in VARIABLES} <= words
    assert set(VERBS) <= words
    assert "pipeline/reference/KEYS.md" in (PROJECT / "README.md").read_text()
    assert "# yaml-language-server: $schema=" in (PROJECT / "docs/guide/configuration.md").read_text()


def test_every_variable_of_ours_is_in_the_reference():
    files = [file for room in ("pipeline", "stages") for file in (PROJECT / room).rglob("*.py")]
    pattern = re.compile(r'"((?:LINKWRIGHT|ONSHAPE)_[A-Z_]+)"')
    named_variables = {name for file in files for name in pattern.findall(file.read_text())}
    older = {"ONSHAPE_SECRET_BEARER"}  # another name for a token, kept for the files that have it
    assert named_variables - older <= {variable.name for variable in VARIABLES}


@pytest.mark.parametrize(("asked", "shown"), [
    ("w-limit", "W-LIMIT (warning, reported by graph)"),
    ("joints.elbow.damping", "joints.<glob>.damping"),
    ("source.path", "source.path (of source=mjcf)"),
    ("mass.", "mass.missing"),
    ("validate.checks", "Checks of your own."),
    ("sensors.imu.noise", "sensors.<name>.noise"),
    ("onshape_auth", "ONSHAPE_AUTH"),
    ("hydra/launcher", "hydra.launcher.n_jobs=-1   jobs that run at once; -1: one for each processor"),
    ("hydra/launcher=slurm", "hydra.launcher.account=null\n"),
    ("hydra.launcher.ray.init.address", "address=null   address of a running cluster"),
])  # fmt: skip
def test_an_entry_is_found_as_a_user_types_it(asked, shown, capsys):
    assert run(["explain", asked]) == 0
    assert shown in capsys.readouterr().out


@pytest.mark.parametrize(
    ("asked", "near"),
    [("E-LIMT", "did you mean E-LIMIT"), ("joint", "did you mean joints"), ("qqq", "--help")],
)
def test_the_nearest_name_is_suggested_for_an_unknown_name(asked, near, capsys):
    assert run(["explain", asked]) == 2
    assert near in capsys.readouterr().err


def test_path_of_the_schema_is_printed_and_entries_read_back(capsys):
    assert run(["explain", "--schema"]) == 0
    assert capsys.readouterr().out.strip() == str(SCHEMA)
    assert entries() == reference.entries()
    assert explanations()
    assert [name for name in names() if name not in explained(name)] == []
