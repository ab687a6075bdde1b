"""The user's own XML: several elements in a text, and the format that they belong to."""

import pytest

from linkwright.stages.formats.own_xml import MJCF_TAGS, SECTION_TAGS, language_of, unknown_tag
from linkwright.stages.formats.xml import Malformed, fragment, to_text
from tests.support.mujoco_schema import schema


@pytest.mark.parametrize(("text", "elements"), [
    ("<a x='1'/>", ['<a x="1"/>']),
    ("<!-- one --><a/> <!-- <b> -->\n<b>t</b>\n", ["<a/>", "<b>t</b>"]),
    ("\ufeff<?xml version='1.0' encoding='utf-8'?>\n<a/>", ["<a/>"]),
    ("<g:a/>", ["<g:a/>"]),
    ("<a x='&lt;&#233;'/>", ['<a x="&lt;é"/>']),
])  # fmt: skip
def test_fragment_is_its_elements(text, elements):
    assert [to_text(element) for element in fragment(text)] == elements


@pytest.mark.parametrize(("text", "place"), [
    ("", "there is no element"),
    ("<!-- nothing -->", "there is no element"),
    ("<a>", "line 1, column 4: <a> of line 1 is not closed"),
    ("<a>\n", "line 2, column 1: <a> of line 1 is not closed"),
    ("<a>\n  <b></a>", "line 2, column 10: </a> does not close <b> of line 2"),
    ("</a>", "line 1, column 5: </a> closes nothing"),
    ("<a/>\n  <b x=3/>", "line 2, column 8:"),
    ("word <a/>", "line 1: text outside of an element: 'word'"),
    ("<a/>\n<b/> word", "line 2: text outside of an element: 'word'"),
    ("<!DOCTYPE a [<!ENTITY x 'y'>]><a>&x;</a>", "line 1, column 2:"),
    ("<a>&x;</a>", "line 1, column 7: Entity 'x' not defined"),
    ("<a/></linkwright.fragment><linkwright.fragment>", "line 1, column"),
])  # fmt: skip
def test_fault_of_a_text_is_named_with_line_and_column(text, place):
    with pytest.raises(Malformed) as caught:
        fragment(text)
    assert caught.value.quoted_place.startswith(place)
    assert "linkwright" not in caught.value.quoted_place


@pytest.mark.parametrize(("text", "place"), [
    ("<secret>", "line 1, column 9: an element of line 1 is not closed"),
    ("<a>\n  <secret></a>", "line 2, column 15: an end tag does not close the element of line 2"),
    ("</secret>", "line 1, column 10: an end tag closes nothing"),
    ("secret <a/>", "line 1: text outside of an element"),
    ("<a>&secret;</a>", "line 1, column 12: an entity is not defined"),
    ("<a secret='1' secret='2'/>", "line 1, column 25: an element has an attribute twice"),
    ("<a secret>", "line 1, column 10: an attribute has no value"),
    ("<a secret\x01='1'/>", "line 1"),
    ("<?secret", "line 1"),
])  # fmt: skip
def test_fault_is_described_without_a_word_of_the_text(text, place):
    with pytest.raises(Malformed) as caught:
        fragment(text)
    assert caught.value.place.startswith(place)
    assert "ecret" not in f"{caught.value.place}{caught.value}"


def test_every_element_of_mujoco_is_known():
    places = {where for where, _ in schema() if where}
    assert {tag for where in places for tag in where} <= MJCF_TAGS
    assert {where[0] for where in places} - {"body"} <= SECTION_TAGS
    assert {"sensor", "worldbody"} <= SECTION_TAGS


@pytest.mark.parametrize(("text", "language"), [
    ("<site name='a'/>", "mjcf"),
    ("<body><freejoint/><geom size='1'/></body>", "mjcf"),
    ("<inertial pos='0 0 0' mass='1'/>", "mjcf"),
    ("<inertial><mass value='1'/></inertial>", "urdf"),
    ("<gazebo reference='arm'><kp>1</kp></gazebo>", "urdf"),
    ("<link name='a'/><joint name='b' type='fixed'><parent link='a'/><child link='c'/></joint>", "urdf"),
    ("<visual><geometry><sphere radius='1'/></geometry></visual>", "urdf"),
    ("<ros2_control name='a'/>", "urdf"),
    ("<drake:joint/>", "urdf"),
    ("<sitee/>", None),
    ("<site/><gazebo_/>", None),
])  # fmt: skip
def test_format_is_told_from_the_elements(text, language):
    elements = fragment(text)
    assert language_of(elements) == language
    assert (unknown_tag(elements) != "") == (language is None or ":" in text)
