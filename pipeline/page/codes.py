"""Renders the meanings of the codes on a page, and links each code to its meaning."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.page.html.template import link, rendered, text
from linkwright.pipeline.reference.codes import explanations

LEVEL_BY_LETTER = {"E": "error", "W": "warning"}
"""First letter of a code → its level; other codes are for information."""


def level_of(code: str) -> str:
    """Returns the level of a diagnostic's code: error, warning or info."""
    return LEVEL_BY_LETTER.get(code[:1], "info")


def to_code(code: str, words: str = "") -> str:
    """Returns a code, or other words for it, as a link to the meaning of the code."""
    return link(f"#{code}", words or code) if code in explanations() else text(words or code)


def codes(page_codes: Iterable[str]) -> str:
    """Renders the section about the codes that a page uses; "" without any."""
    known_codes = sorted({*page_codes} & explanations().keys())
    return (
        rendered("codes", codes=[(code, explanations()[code]) for code in known_codes]) if known_codes else ""
    )


def problems_of(tree: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """Returns the diagnostics of a report, and the problems that ended its build."""
    return [*tree["diagnostics"], *(tree["error"] or {}).get("problems", [])]
