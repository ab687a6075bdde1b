"""Names: legal, unique, and independent of order."""

import random
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from linkwright.stages.robot.text.names import legal, shortest_unique


@pytest.mark.parametrize(
    ("typed", "name"),
    [
        ("Upper arm <1>", "upper_arm"),
        ("Upper arm <2>", "upper_arm_2"),
        ("Revolute 1", "revolute_1"),
        ("  KD-D-102L (copy) <1>", "kd_d_102l_copy"),
        ("Ärmel & Öse", "armel_ose"),
        ("dof_a&b", "dof_a_b"),
        ("腕 <1>", ""),
        ("Left arm", "left_arm"),
    ],
)
def test_what_a_designer_types_becomes_a_legal_name(typed: str, name: str) -> None:
    assert legal(typed) == name


def test_the_shortest_tail_that_is_unique_names_it() -> None:
    paths = {"a": ("leg <1>", "foot <1>"), "b": ("leg <2>", "foot <1>"), "c": ("body <1>",)}
    assert shortest_unique(paths) == {"a": "leg_foot", "b": "leg_2_foot", "c": "body"}


def test_reserved_and_taken_names_are_avoided() -> None:
    assert shortest_unique({"a": ("World <1>",), "b": ("arm",)}, {"arm"}) == {"a": "world_2", "b": "arm_2"}


def test_names_of_nothing_are_still_names() -> None:
    assert sorted(shortest_unique({"a": ("腕",), "b": ("!",)}).values()) == ["unnamed", "unnamed_2"]


words = st.text(alphabet="ab <1>2é_", min_size=0, max_size=6)
paths = st.dictionaries(
    st.text("xyz", min_size=1, max_size=3), st.lists(words, min_size=1, max_size=3), max_size=8
)


@given(paths, st.integers(0, 1000))
def test_names_are_unique_legal_and_blind_to_order(given: dict, seed: int) -> None:
    names = shortest_unique(given)
    shuffled = list(given.items())
    random.Random(seed).shuffle(shuffled)
    assert shortest_unique(dict(shuffled)) == names
    assert len(set(names.values())) == len(given)
    assert all(re.fullmatch("[A-Za-z0-9_]+", name) for name in names.values())
