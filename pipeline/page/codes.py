"""What the codes on a page mean, to which each of them leads."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.page.html.template import link, rendered, text
from linkwright.pipeline.reference.codes import explanations

LEVELS = {"E": "error", "W": "warning"}


def level_of(code: str) -> str:
    """The level of a diagnostic's code: error, warning or info."""
    return LEVELS.get(code[:1], "info")


def to_code(code: str, words: str = "") -> str:
    """A code, or other words, with a link to what the code means."""
    return link(f"#{code}", words or code) if code in explanations() else text(words or code)


def codes(used: Iterable[str]) -> str:
    """The section about the codes that a page uses; nothing without any."""
    known = sorted({*used} & explanations().keys())
    return rendered("codes", codes=[(code, explanations()[code]) for code in known]) if known else ""


def problems_of(tree: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The diagnostics of a report, and the problems that ended its build."""
    return [*tree["diagnostics"], *(tree["error"] or {}).get("problems", [])]
