"""Texts for users: legal and unique names, globs that match nothing, characters that are shown, errors."""

import inspect
import json
import random
import re
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkwright.pipeline import errors
from linkwright.stages.formats import xml
from linkwright.stages.robot import errors as tree
from linkwright.stages.robot.text.globs import no_match_hint
from linkwright.stages.robot.text.names import legal_name, shortest_unique
from linkwright.stages.robot.text.printable import printable, printable_lines


@pytest.mark.parametrize(("typed", "name"), [
    ("Upper arm <1>", "upper_arm"), ("Upper arm <2>", "upper_arm_2"), ("Revolute 1", "revolute_1"),
    ("  KD-D-102L (copy) <1>", "kd_d_102l_copy"), ("Ärmel & Öse", "armel_ose"), ("dof_a&b", "dof_a_b"),
    ("腕 <1>", ""), ("Left arm", "left_arm"),
])  # fmt: skip
def test_typed_name_becomes_legal(typed, name):
    assert legal_name(typed) == name


def test_shortest_tail_that_is_unique_names_it():
    paths = {"a": ("leg <1>", "foot <1>"), "b": ("leg <2>", "foot <1>"), "c": ("body <1>",)}
    assert shortest_unique(paths) == {"a": "leg_foot", "b": "leg_2_foot", "c": "body"}
    assert sorted(shortest_unique({"a": ("腕",), "b": ("!",)}).values()) == ["unnamed", "unnamed_2"]
    # Reserved and taken names are avoided.
    assert shortest_unique({"a": ("World <1>",), "b": ("arm",)}, {"arm"}) == {"a": "world_2", "b": "arm_2"}


words = st.text(alphabet="ab <1>2é_", min_size=0, max_size=6)
paths = st.dictionaries(
    st.text("xyz", min_size=1, max_size=3), st.lists(words, min_size=1, max_size=3), max_size=8
)


@given(paths, st.integers(0, 1000))
def test_names_are_unique_legal_and_blind_to_order(by_object, seed):
    names = shortest_unique(by_object)
    shuffled = list(by_object.items())
    random.Random(seed).shuffle(shuffled)
    assert shortest_unique(dict(shuffled)) == names
    assert len(set(names.values())) == len(by_object)
    assert all(re.fullmatch("[A-Za-z0-9_]+", name) for name in names.values())


def test_message_names_what_is_near_and_all_there_is():
    assert no_match_hint("sholder", {"joints": ["wrist", "shoulder"]}) == (
        "did you mean shoulder? joints are: shoulder, wrist"
    )
    names = {"links": ["base"], "parts": ["Bracket", "Block"]}
    assert (
        no_match_hint("Braket", names) == "did you mean Bracket? links are: base; parts are: Block, Bracket"
    )
    assert no_match_hint("wheel*", {"frames": []}) == "frames are: none"


@pytest.mark.parametrize(("text", "shown"), [
    ("\x1b[31mred\x1b[0m", r"\u001b[31mred\u001b[0m"), ("\x1b]0;title\x07", r"\u001b]0;title\u0007"),
    ("\x9b2J\x9d0;t\x9c", r"\u009b2J\u009d0;t\u009c"), ("fine\rforged", r"fine\u000dforged"),
    ("a\bb\x0bc\x0cd\x7f\x00", r"a\u0008b\u000bc\u000cd\u007f\u0000"),
    ("\u202egpj.mra\u202c \u2066x\u2069 \u200f\u061c", r"\u202egpj.mra\u202c \u2066x\u2069 \u200f\u061c"),
    ("ar\u200bm \ufeff\u2060", r"ar\u200bm \ufeff\u2060"),
    ("a\u2028b\u2029c\x85d", r"a\u2028b\u2029c\u0085d"), ("tag \U000e0041", r"tag \udb40\udc41"),
    ("\ud800 \uffff", r"\ud800 \uffff"),
])  # fmt: skip
def test_control_characters_are_shown_as_escapes(text, shown):
    assert printable(text) == printable_lines(text) == shown


@pytest.mark.parametrize(
    "text",
    ["Größe 中文 Ω ½ ²", "👩‍🔧 👍🏽 🇨🇭 ❤️", "می‌خواهم क्‍ष", "e\u0301 x\u00a0y", "", "C:\\new [b] <1> & 'x'"],
)
def test_text_that_people_write_stays(text):
    assert printable(text) == printable_lines(text) == text


def test_line_is_one_and_lines_are_several():
    assert printable("a\nb\tc") == "a\\nb c"
    assert printable_lines("a\nb\tc") == "a\nb\tc"


def test_every_character_can_be_printed_and_be_in_xml():
    everything = "".join(map(chr, range(sys.maxunicode + 1)))
    shown = printable_lines(everything)
    shown.encode()
    root = xml.element(None, "a", b=shown)
    root.text = shown
    assert xml.parse(xml.to_bytes(root)).text == shown


def test_json_stays_the_same_json():
    data = {"na\x9bme": ["\x1b[0m\u202e", "\U000e0041", 'é "中" \\u202e']}
    text = printable_lines(json.dumps(data, ensure_ascii=False))
    assert "\x9b" not in text
    assert json.loads(text) == data


@pytest.mark.parametrize(("error", "status"), [
    (errors.ConfigError("x"), 2), (errors.AuthError("x"), 1), (errors.AssemblyError("x"), 1),
    (errors.OutputError("x"), 1), (errors.CacheError("x"), 1), (errors.ValidationFailed("x"), 3),
    (KeyboardInterrupt(), 130), (ZeroDivisionError("x"), 1),
], ids=lambda value: type(value).__name__)  # fmt: skip
def test_exit_status_of(error, status):
    assert errors.exit_status(error) == status


def test_message_says_where_what_and_what_to_do():
    error = errors.NotFound("there is no such element", where="source.url", hint="check the address")
    assert errors.render(error) == ("error: source.url: there is no such element\n  → check the address")


def test_fault_of_the_program_says_where_its_traceback_is():
    text = errors.render(ZeroDivisionError("division by zero"))
    assert "bug in linkwright" in text
    assert "ZeroDivisionError: division by zero" in text
    assert "build.log" in text


def test_whole_tree_can_be_had_here():
    classes = {name for name, value in vars(tree).items() if inspect.isclass(value)}
    assert classes - {"Iterable"} <= set(errors.__all__)
