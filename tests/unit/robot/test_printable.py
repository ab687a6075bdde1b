"""Control characters of a document: seen as escapes, obeyed by nothing."""

import json
import sys

import pytest

from linkwright.stages.formats import xml
from linkwright.stages.robot.text.printable import printable, printable_lines


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("\x1b[31mred\x1b[0m", r"\u001b[31mred\u001b[0m"),
        ("\x1b]0;title\x07", r"\u001b]0;title\u0007"),
        ("\x9b2J\x9d0;t\x9c", r"\u009b2J\u009d0;t\u009c"),
        ("fine\rforged", r"fine\u000dforged"),
        ("a\bb\x0bc\x0cd\x7f\x00", r"a\u0008b\u000bc\u000cd\u007f\u0000"),
        ("\u202egpj.mra\u202c \u2066x\u2069 \u200f\u061c", r"\u202egpj.mra\u202c \u2066x\u2069 \u200f\u061c"),
        ("ar\u200bm \ufeff\u2060", r"ar\u200bm \ufeff\u2060"),
        ("a\u2028b\u2029c\x85d", r"a\u2028b\u2029c\u0085d"),
        ("tag \U000e0041", r"tag \udb40\udc41"),
        ("\ud800 \uffff", r"\ud800 \uffff"),
    ],
)
def test_what_a_terminal_obeys_is_shown_as_its_escape(text, shown):
    assert printable(text) == printable_lines(text) == shown


@pytest.mark.parametrize(
    "text",
    ["Größe 中文 Ω ½ ²", "👩‍🔧 👍🏽 🇨🇭 ❤️", "می‌خواهم क्‍ष", "e\u0301 x\u00a0y", "", "C:\\new [b] <1> & 'x'"],
)
def test_what_people_write_stays(text):
    assert printable(text) == printable_lines(text) == text


def test_a_line_is_one_and_lines_are_several():
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
