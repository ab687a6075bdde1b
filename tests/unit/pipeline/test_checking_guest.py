"""The guest that checks files: its verdict is that of this process, and its failures are errors."""

import json
from pathlib import Path
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
def model(tmp_path: Path) -> str:
    (tmp_path / "m.xml").write_text(MODEL)
    return str(tmp_path / "m.xml")


def test_the_verdict_is_that_of_this_process(model: str) -> None:
    assert ask.checked(model, "standard") == checked(model, "standard")


def test_a_verdict_is_whole_on_the_other_side() -> None:
    finding = Finding('joint "a"', "range", "is 1")
    checks = (
        Check("m.xml: a", False, "off", 1.5, float("inf"), "C-A", "warning", (finding,)),
        Check("b", True, "right"),
    )
    verdict = Verdict("r", "/r", "robot", "quick", checks, ("a note",))
    assert wire.load(wire.dump(verdict)) == verdict


def test_what_cannot_be_read_is_the_error_of_this_process(tmp_path: Path) -> None:
    (tmp_path / "robot.json").write_text("[null]")
    with pytest.raises(OutputError, match="expected a table"):
        ask.checked(str(tmp_path), "standard")
    with pytest.raises(OutputError, match="no such file"):
        ask.checked(str(tmp_path / "none"), "standard")


NO_VERDICTS = [b"", b"[]", b"{}", b"[" * 100_000, json.dumps({"checks": [None]}).encode()]


@pytest.mark.parametrize("reply", NO_VERDICTS)
def test_a_reply_that_is_no_verdict_is_an_error(model: str, reply: bytes) -> None:
    with patch.object(guest, "ask", return_value=reply), pytest.raises(OutputError, match="no verdict"):
        ask.checked(model, "standard")


def test_a_guest_that_ends_is_an_error(model: str) -> None:
    ended = guest.Ended("crashed (SIGSEGV)")
    with patch.object(guest, "ask", side_effect=ended), pytest.raises(OutputError, match="crashed"):
        ask.checked(model, "standard")
