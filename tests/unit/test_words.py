"""Words that a reader stumbles over become fewer: `python -m tests.support.words` records each fall."""

import pytest

from tests.support.words import OPENING, STUMBLES, counts, limits


@pytest.fixture(scope="module")
def now():
    return counts()


@pytest.mark.parametrize("kind", ["one", "names", "openings", "stumbles"])
def test_no_room_has_more_of_them(kind, now):
    allowed = limits()[kind]
    grown = {room: count for room, count in now[kind].items() if count > allowed.get(room, 0)}
    assert grown == {}


@pytest.mark.parametrize(
    "text", ["Of a link.", "So many jobs.", "What is left.", "None without actuators.", "For who calls it."]
)
def test_opening_is_seen(text):
    assert OPENING.match(text)
    assert not OPENING.match(f"The links. {text}")


def test_stumble_is_seen():
    assert len(STUMBLES.findall("A force is none; parts, of which so many stay, but for screws.")) == 4
