"""Text for a terminal: wrapped to its width, and safe to paste whatever a name holds."""

import re
import shlex
import shutil
import subprocess
import sys

import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.files.trust import forbidden_target_problems
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.terminal import pasted
from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import columns

WORDS = st.lists(st.text("abc中_'\"{}:,→", min_size=1, max_size=12), min_size=1, max_size=40)


@given(WORDS, st.integers(0, 8), st.integers(30, 90))
def test_no_word_is_lost_or_broken_and_no_line_too_wide(words, indent, width):
    text = " " * indent + " ".join(words)
    lines = wrapped(text, width).split("\n")
    assert " ".join(line.strip() for line in lines).split() == text.split()
    assert all(columns(line) <= width for line in lines)


ADDRESS = "https://cad.onshape.com/documents/" + "e" * 60


@pytest.mark.parametrize(("text", "width", "lines"), [
    pytest.param("a  b\n\n    table   of   cells", 40, ["a  b", "", "    table   of   cells"], id="fits"),
    pytest.param("  E-KEY here: an unknown key\n      did you mean that one?", 22,
        ["  E-KEY here: an", "    unknown key", "      did you mean", "        that one?"], id="further in"),
    pytest.param(f"source: {ADDRESS} there", 40, ["source:", f"  {ADDRESS}", "  there"], id="a long word"),
    pytest.param("  → linkwright --help lists the options; linkwright cache info shows the calls", 50,
        ["  → linkwright --help lists the options;", "    linkwright cache info shows the calls"],
        id="a sentence about the command"),
])  # fmt: skip
def test_lines_are_wrapped_between_words(text, width, lines):
    assert wrapped(text, width).split("\n") == lines


@pytest.mark.parametrize("before", ["", "  → ", "    → if you trust it: "])
def test_a_command_to_paste_is_the_same_command(before):
    command = (
        "linkwright robot=t 'plugins=[my checks]' \"source.url='https://x/y?a=b'\" until=graph a=1 b=2 c=3"
    )
    lines = wrapped(before + command, 40).split("\n")
    assert max(map(len, lines)) <= 40
    first = next(number for number, line in enumerate(lines) if "linkwright" in line)
    pasted = "\n".join(lines[first:]).removeprefix(before if not first else "")
    assert shlex.split(pasted.replace("\\\n", "")) == shlex.split(command)


def test_yaml_in_braces_is_the_same_yaml():
    text = "joints: {" + ", ".join(f"joint_{n}: {{limits: [{n}, {n + 1}]}}" for n in range(9)) + "}  # rad"
    lines = wrapped(f"    → set them: {text}", 50)
    assert max(map(len, lines.split("\n"))) <= 50
    assert yaml.safe_load(lines[lines.index("joints") :]) == yaml.safe_load(text)
    assert not re.search(r"\S\n\S", lines)


TEXTS = st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"]), min_size=1, max_size=12)
HOSTILE = [
    "'; touch X; '", "$(touch X)", "`touch X`", 'a"; touch X; "', "a b", "~", "*", "!!", "a\\", "\\'", "#x",
]  # fmt: skip


def said(line):
    """What the shell gives a program as its only argument."""
    code = "import sys; sys.stdout.write(repr(sys.argv[1:]))"
    words = [shutil.which("sh") or "sh", "-c", f"{pasted.word(sys.executable)} -c {pasted.word(code)} {line}"]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    (argument,) = eval(done.stdout)
    return str(argument)


@pytest.mark.parametrize("text", HOSTILE)
def test_word_for_a_shell_comes_through_it(text, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert said(pasted.word(text)) == text
    assert said(pasted.line([text])) == text
    argument = said(pasted.override("vars.x", text))
    assert compose_plan(["source=sample", argument]).plan.vars["x"] == text.strip("'\"")
    assert list(tmp_path.iterdir()) == []


@settings(max_examples=200)
@given(TEXTS)
def test_a_word_of_powershell_is_one_literal(text):
    word = pasted.word(text, windows=True)
    if word == text:
        assert not set(text) & set("'\"`$;&|()<>{}@# \t\r\n" if text[0] == "@" else "'\"`$;&|()<>{}# \t\r\n")
        return
    inner = word[1:-1]
    for quote in "'\u2018\u2019\u201a\u201b":
        assert inner.count(quote) == 2 * text.count(quote)
        inner = inner.replace(2 * quote, quote)
    assert inner == text


def test_the_hint_of_a_module_that_is_not_trusted_can_be_pasted():
    tree = {"validate": {"checks": [{"_target_": "a'; touch X; '.light"}]}}
    (problem,) = forbidden_target_problems(tree, "linkwright")
    line = problem.hint.partition("linkwright ")[2]
    assert said(line) == "plugins=[a'; touch X; ']"


@pytest.mark.parametrize("name", ["a'; touch X; '", "a b", "1a", "a.", ".a", "a-b", ""])
def test_a_plugin_has_the_name_of_a_module(name):
    with pytest.raises(ConfigError, match="plugins"):
        Plan.parse({"name": "arm", "source": {"kind": "sample"}, "plugins": [name]})
