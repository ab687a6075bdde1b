"""What the codes on a page mean, to which each of them leads."""

from collections.abc import Iterable, Mapping
from typing import Any

from linkwright.pipeline.page.html.markup import inline, link, section, table, text
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
    rows = []
    for code in sorted({*used} & explanations().keys()):
        found = explanations()[code]
        remedy = "" if found.remedy == "–" else inline(found.remedy)
        rows.append([f'<span id="{code}">{code}</span>', inline(found.meaning), remedy])
    classes = {"code": "code"}
    return section(
        "What the codes mean", table(["code", "meaning", "what to do"], rows, classes, "code"), "codes"
    )


def problems_of(tree: Mapping[str, Any]) -> list[Mapping[str, Any]]:
    """The diagnostics of a report, and the problems that ended its build."""
    return [*tree["diagnostics"], *(tree["error"] or {}).get("problems", [])]
