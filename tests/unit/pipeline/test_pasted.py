"""Text to paste: whatever a name holds, the shell hands it over as it is and runs nothing of it."""

import shutil
import subprocess
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.config.files.trust import forbidden_targets
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.terminal import pasted

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
def test_a_shell_runs_nothing_of_a_word_and_an_override_comes_through_it(text, tmp_path, monkeypatch):
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
    (problem,) = forbidden_targets(tree, "linkwright")
    line = problem.hint.partition("linkwright ")[2]
    assert said(line) == "plugins=[a'; touch X; ']"


@pytest.mark.parametrize("name", ["a'; touch X; '", "a b", "1a", "a.", ".a", "a-b", ""])
def test_a_plugin_has_the_name_of_a_module(name):
    with pytest.raises(ConfigError, match="plugins"):
        Plan.parse({"name": "arm", "source": {"kind": "sample"}, "plugins": [name]})
