"""Sections of the configuration: their documentation is read from the source, and only when asked for."""

import ast

from pydantic import Field

from linkwright.stages.robot.section import Section


class Base(Section):
    """The shared keys."""

    width: float = 1.0
    """How wide [m],
    from side to side."""

    shade: str = "grey"
    """A word."""


class Inner(Base):
    """The keys in question."""

    shade: str = "red"
    """Another word."""

    from_: str = Field(default="", alias="from")
    """Where it comes from."""

    said: int = Field(default=1, description="In its own words.")

    silent: int = 0

    def later(self):
        """No field."""


MEANINGS = {
    "width": "How wide [m],\nfrom side to side.",
    "shade": "Another word.",
    "from": "Where it comes from.",
    "said": "In its own words.",
}


def test_text_under_each_field_is_its_meaning():
    assert Inner.meanings() == MEANINGS
    properties = Inner.model_json_schema()["properties"]
    texts = {key: entry["description"] for key, entry in properties.items() if "description" in entry}
    assert texts == MEANINGS


def test_no_source_is_parsed_before_a_meaning_is_asked_for(monkeypatch):
    parsed, parse = [], ast.parse
    monkeypatch.setattr(ast, "parse", lambda *args, **more: parsed.append(args) or parse(*args, **more))

    class Late(Section):
        """Defined at run time."""

        width: float = 1.0
        """How wide."""

    assert parsed == []
    assert Late.meanings() == {"width": "How wide."}


def test_section_without_source_has_no_meanings():
    inside = {"__annotations__": {"width": float}, "width": 1.0, "__module__": "nowhere"}
    assert type("Made", (Section,), inside).meanings() == {}
