"""The guest that checks files: its verdict is that of this process, and its failures are errors."""

import json
from unittest.mock import patch

import pytest

from linkwright.pipeline.checking import ask, wire
from linkwright.pipeline.checking.run import checked
from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.errors import OutputError
from linkwright.stages.robot.check import Check, Finding
from linkwright.stages.robot.system import guest

MODEL = '<mujoco><worldbody><body name="b"><joint/><geom size=".1"/></body></worldbody></mujoco>'


@pytest.fixture
def model(tmp_path):
    (tmp_path / "m.xml").write_text(MODEL)
    return str(tmp_path / "m.xml")


def test_the_verdict_and_the_errors_are_those_of_this_process(model, tmp_path):
    assert ask.checked(model, "standard") == checked(model, "standard")
    (tmp_path / "robot.json").write_text("[null]")
    for place, message in ((tmp_path, "expected a table"), (tmp_path / "none", "no such file")):
        with pytest.raises(OutputError, match=message):
            ask.checked(str(place), "standard")


def test_a_verdict_is_whole_on_the_other_side():
    finding = Finding('joint "a"', "range", "is 1")
    failed = Check("m.xml: a", False, "off", 1.5, float("inf"), "C-A", "warning", (finding,))
    verdict = Verdict("r", "/r", "robot", "quick", (failed, Check("b", True, "right")), ("a note",))
    assert wire.load(wire.dump(verdict)) == verdict


@pytest.mark.parametrize(
    "reply", [b"", b"[]", b"{}", b"[" * 100_000, json.dumps({"checks": [None]}).encode()]
)
def test_a_reply_that_is_no_verdict_and_a_guest_that_ends_are_errors(model, reply):
    with patch.object(guest, "ask", return_value=reply), pytest.raises(OutputError, match="is not a verdict"):
        ask.checked(model, "standard")
    ended = guest.Ended("crashed (SIGSEGV)")
    with patch.object(guest, "ask", side_effect=ended), pytest.raises(OutputError, match="crashed"):
        ask.checked(model, "standard")
