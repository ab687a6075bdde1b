"""Sections of the configuration: their documentation is read from the source, and only when asked for."""

import ast

import pytest
from pydantic import Field

from linkwright.stages.robot.section import Section


class Base(Section):
    """What is shared."""

    width: float = 1.0
    """How wide [m],
    from side to side."""

    shade: str = "grey"
    """A word."""


class Inner(Base):
    """What is asked."""

    shade: str = "red"
    """Another word."""

    from_: str = Field(default="", alias="from")
    """Where it comes from."""

    said: int = Field(default=1, description="In its own words.")

    silent: int = 0

    def later(self) -> None:
        """No field."""


MEANINGS = {
    "width": "How wide [m],\nfrom side to side.",
    "shade": "Another word.",
    "from": "Where it comes from.",
    "said": "In its own words.",
}


def test_the_text_under_each_field_is_its_meaning():
    assert Inner.meanings() == MEANINGS


def test_the_json_schema_has_the_meanings():
    properties = Inner.model_json_schema()["properties"]
    found = {key: one["description"] for key, one in properties.items() if "description" in one}
    assert found == MEANINGS


def test_no_source_is_parsed_before_a_meaning_is_asked_for(monkeypatch: pytest.MonkeyPatch):
    parsed = []
    parse = ast.parse
    monkeypatch.setattr(ast, "parse", lambda *given, **more: parsed.append(given) or parse(*given, **more))

    class Late(Section):
        """Defined at run time."""

        width: float = 1.0
        """How wide."""

    assert parsed == []
    assert Late.meanings() == {"width": "How wide."}


def test_a_section_without_source_has_no_meanings():
    made = type(
        "Made", (Section,), {"__annotations__": {"width": float}, "width": 1.0, "__module__": "nowhere"}
    )
    assert made.meanings() == {}
