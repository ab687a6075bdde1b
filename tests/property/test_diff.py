"""`linkwright diff` of any two robots: it ends without an error, and says what differs."""

import copy
import json
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import strategies as st

from linkwright.pipeline.changes.compare import compare
from linkwright.pipeline.changes.pairs import match_names
from linkwright.pipeline.changes.read import SavedRobot
from linkwright.pipeline.changes.show import as_document, as_markdown, as_text
from tests.fake_onshape.document import Document
from tests.fake_onshape.random_document import documents
from tests.support.building import write
from tests.support.drawn import PLACES, drawn, each

pytestmark = pytest.mark.e2e

BODY = "<body name='{}' pos='3 0 1'>{}<geom name='{}' size='.1'/></body>"

ELEMENTS = (
    {},
    {"cube": {"into": {"tag": "worldbody"}, "xml": BODY.format("cube", "<freejoint/>", "cube")}},
    {"ball": {"into": {"tag": "worldbody"}, "xml": BODY.format("ball", "<joint type='ball'/>", "ball")}},
    {"post": {"into": {"tag": "worldbody"}, "xml": BODY.format("post", "", "post")}},
    {"lamp": {"into": {"tag": "worldbody", "file": "scene"}, "xml": "<light pos='0 1 2' dir='0 -1 -2'/>"}},
)
"""Values of the key `elements`: bodies with a free joint, a ball or no joint, and a light of the scene."""

Drawn = tuple[Document, int, int, dict[str, Any]]

ROBOTS = st.tuples(
    st.booleans().flatmap(lambda loops: documents(max_bodies=6, loops=loops)),
    PLACES,
    PLACES,
    st.sampled_from(ELEMENTS),
)


def described(choice):
    """The robot.json of a drawn robot with its element."""
    document, root, seed, elements = choice
    servos = {"*": "position"} if seed % 3 == 0 else {}
    robot, plan = drawn(document, root, seed, elements=elements, actuators=servos)
    with tempfile.TemporaryDirectory() as folder:
        write(robot, Path(folder), plan)
        return json.loads((Path(folder) / "robot.json").read_text())


def differs_as_it_should(first, second):
    before, after = described(first), described(second)
    assert compare(before, copy.deepcopy(before)) == ()
    changes = compare(before, after)
    for shown in (as_text, as_document, as_markdown):
        assert shown(SavedRobot("before", before), SavedRobot("after", after), changes)
    names = match_names(before, after).links
    old = {names.get(link["name"], link["name"]) for link in before["links"]}
    new = {link["name"] for link in after["links"]}
    links = [change for change in changes if change.section == "links"]
    assert {change.name for change in links if change.kind == "added"} == new - old
    assert {names.get(change.name, change.name) for change in links if change.kind == "removed"} == old - new
    paths = {change.field.partition(".")[0] for change in changes if change.section == "robot"}
    assert ("amendments" in paths) == (before.get("amendments") != after.get("amendments"))
    assert ("base" in paths) >= (before["base"]["fixed"] != after["base"]["fixed"])


@pytest.mark.parametrize("count", [6, pytest.param(60, marks=pytest.mark.slow)])
def test_pairs_of_robots_differ_as_they_should(count):
    each(differs_as_it_should, count, ROBOTS, ROBOTS)


@pytest.mark.parametrize("elements", ELEMENTS)
def test_an_added_element_is_the_difference(elements):
    def check(document, seed):
        plain, amended = (described((document, 0, seed, choice)) for choice in ({}, elements))
        changes = compare(plain, amended)
        assert {change.section for change in changes} <= {"robot", "surplus", "keyframes", "order"}
        assert bool(changes) == bool(elements)

    each(check, 2, documents(max_bodies=4), PLACES)
