"""Lines of messages, wrapped to the width of a terminal."""

import re
import shlex

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline.terminal.wrapping import wrapped
from linkwright.stages.robot.text.printable import columns

WORDS = st.lists(st.text("abc中_'\"{}:,→", min_size=1, max_size=12), min_size=1, max_size=40)


@given(WORDS, st.integers(0, 8), st.integers(30, 90))
def test_no_word_is_lost_or_broken_and_no_line_too_wide(words, indent, width):
    text = " " * indent + " ".join(words)
    lines = wrapped(text, width).split("\n")
    assert " ".join(line.strip() for line in lines).split() == text.split()
    assert all(columns(line) <= width for line in lines)


def test_lines_that_fit_stay_as_they_are():
    text = "a  b\n\n    table   of   cells\n"
    assert wrapped(text, 40) == text


def test_what_is_wrapped_is_further_in_than_what_comes_next():
    assert wrapped("  E-KEY here: an unknown key\n      did you mean that one?", 22).split("\n") == [
        "  E-KEY here: an", "    unknown key", "      did you mean", "        that one?",
    ]  # fmt: skip


def test_a_word_that_is_too_long_is_whole():
    url = "https://cad.onshape.com/documents/" + "e" * 60
    assert wrapped(f"source: {url} there", 40) == f"source:\n  {url}\n  there"


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


def test_a_sentence_about_the_command_is_none():
    text = "  → linkwright --help lists the options; linkwright cache info shows the calls of each key"
    assert "\\" not in wrapped(text, 40)


def test_yaml_in_braces_is_the_same_yaml():
    text = "joints: {" + ", ".join(f"joint_{n}: {{limits: [{n}, {n + 1}]}}" for n in range(9)) + "}  # rad"
    lines = wrapped(f"    → set them: {text}", 50)
    assert max(map(len, lines.split("\n"))) <= 50
    assert yaml.safe_load(lines[lines.index("joints") :]) == yaml.safe_load(text)
    assert not re.search(r"\S\n\S", lines)
