"""YAML files are judged before anything is made of them: aliases, nesting, size, and interpolations."""

import itertools
import os

import pytest
import yaml

from linkwright.pipeline.config import plain
from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.files import yaml_file
from linkwright.pipeline.config.hydra import files as hydra_files
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.output.packing import _configured_cache
from tests.support.users import write

HEAD = "# @package _global_\ndefaults:\n  - override /source: sample\n"
LETTERS = "abcdefghij"


def laughing(each):
    """Ten lines, each of which names the one before ten times."""
    pairs = itertools.pairwise(LETTERS)
    lines = [f"  {anchor}: &{anchor} [{', '.join([each.format(before)] * 10)}]" for before, anchor in pairs]
    return "\n".join(["vars:", "  a: &a [1, 1]", *lines, ""])


def shown(folder, text):
    with pytest.raises(ConfigError) as caught:
        compose_plan(["robot=bad"], cwd=write(folder, bad=HEAD + text))
    return str(caught.value)


@pytest.mark.parametrize(("text", "output_text"), [
    pytest.param(laughing("*{}"), ["line 9", "more than 20000 values", "aliases"], id="laughs"),
    pytest.param("vars: &a [*a]\n", ["line 4, column 11", "*a contains itself"], id="itself"),
    pytest.param("vars: &a {b: {c: *a}}\n", ["*a contains itself"], id="below itself"),
    pytest.param(f"vars: {'[' * 5000}{']' * 5000}", ["line 4, column 38", "deeper than 32"], id="lists"),
    pytest.param(f"vars: {'{a: ' * 5000}1{'}' * 5000}", ["deeper than 32 levels"], id="mappings"),
    pytest.param(f"vars:\n  a: &a {'[' * 20}{']' * 20}\n  b: {'[' * 20}*a{']' * 20}\n",
        ["line 6", "deeper than 32 levels"], id="deep by an alias"),
    pytest.param("vars: [" + "1, " * 20_000 + "1]\n", ["more than 20000 values"], id="many"),
    pytest.param("vars: '" + "x" * (5 << 20) + "'\n", ["at most 4194304 are read"], id="large"),
])  # fmt: skip
def test_yaml_of_too_many_values_is_reported_by_its_place(tmp_path, text, output_text):
    message = shown(tmp_path, text)
    assert [words for words in ["E-YAML", "bad.yaml", *output_text] if words not in message] == []


EXPANDED = "cannot be resolved: its interpolations expand to more than is allowed"
TEXTS = laughing("${{vars.{}}}").replace("[1, 1]", "lol").translate(str.maketrans("[]", "''"))
LONG = "vars:\n  a: '" + "x" * 500_000 + "'\n  b: '" + "${vars.a}" * 2000 + "'\n"


@pytest.mark.parametrize(("text", "output_text"), [
    pytest.param(laughing('"${{vars.{}}}"'), "it holds more than 300 values", id="lists"),
    pytest.param(TEXTS, f"vars.j: {EXPANDED}", id="texts"),
    pytest.param(LONG, f"vars.b: {EXPANDED}", id="long"),
])  # fmt: skip
def test_interpolations_that_come_to_too_much_are_reported(tmp_path, monkeypatch, text, output_text):
    monkeypatch.setattr(plain, "MAX_VALUES", 300)
    monkeypatch.setattr(hydra_files, "MAX_INTERPOLATIONS", 50)
    assert output_text in shown(tmp_path, text)


@pytest.mark.slow
def test_deep_nesting_on_the_command_line_is_reported(tmp_path):
    for value in ("[" * 400 + "]" * 400, "{a:" * 400 + "1" + "}" * 400):
        with pytest.raises(ConfigError, match="nested too deeply"):
            compose_plan(["robot=sample", f"joints={value}"], cwd=tmp_path)


def test_aliases_and_merges_that_make_sense_are_read(tmp_path):
    text = HEAD + "joints:\n  '*': &all {damping: 1}\n  '*finger': {<<: *all, effort: 2}\n"
    plan = compose_plan(["robot=good"], cwd=write(tmp_path, good=text)).plan
    assert plan.joints["*finger"].damping == 1


def test_what_is_no_yaml_is_reported_by_its_parser(tmp_path):
    file = tmp_path / "x.yaml"
    for text in ("a: [1\n", "a: *nobody\n", "\t: :\n", "&a a: &a b\n"):
        yaml_file.check_limits(text, file)
    file.write_text("a: [1\n")
    with pytest.raises(yaml.YAMLError):
        yaml_file.read(file)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
def test_a_pipe_is_no_robot(tmp_path):
    folder = write(tmp_path, good=HEAD)
    os.mkfifo(folder / "robot" / "bad.yaml")
    with pytest.raises(ConfigError, match="robot=bad"):
        compose_plan(["robot=bad"], cwd=folder)
    (folder / "robot" / "bad.yaml").unlink()
    (folder / "robot" / "bad.yaml").symlink_to("/dev/zero")
    with pytest.raises(ConfigError, match="robot=bad"):
        compose_plan(["robot=bad"], cwd=folder)


def test_the_configuration_that_a_build_left_is_judged_too(tmp_path):
    for text, folder in ((laughing("*{}") + "cache: {dir: /x}\n", None), ('{"cache": {"dir": "/x"}}', "/x")):
        (tmp_path / "config.yaml").write_text(text)
        assert _configured_cache(tmp_path) == folder
