"""Takes the figures of a robot from a build that ends after the graph.

Such a build takes a second or two; the colliders of a whole build would take minutes.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from linkwright.pipeline.config.page_section import PageSection
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.run.build import build_files
from linkwright.stages.fetch import source_class
from linkwright.stages.fetch.bundle.section import BundleSourceSection

UNTIL = "graph"

NAMES = ("links", "joints", "dofs", "coordinates", "gruebler", "dof", "loops", "parts", "mass")
"""The figures of a snapshot. A new figure of builds is not added, so that it changes no snapshot."""

DIGITS = 9
"""Number of digits that are kept; two computers may differ in further digits."""


@dataclass(frozen=True, slots=True)
class Figures:
    """Figures by name, and their source: "" without figures."""

    source: str = ""
    values: Mapping[str, float] = field(default_factory=dict)

    def lines(self) -> dict[str, Any]:
        """Returns the lines of the snapshot's section: key → value."""
        if not self.source:
            return {"source": "none"}
        return {"source": self.source, "until": UNTIL, **self.values}


def figures_of(plan: Plan, bundle: Path | None, environ: Mapping[str, str]) -> Figures:
    """Returns the figures of a plan's robot, built from `bundle`, if given, instead of the plan's source.

    There are no figures for a source that is not on this computer, or that is a program. Relative paths start
    from the working folder. Raises LinkwrightError if the robot cannot be built.
    """
    changes: dict[str, Any] = {"until": UNTIL, "output": None, "page": PageSection(), "plugins": ()}
    source = plan.source.kind
    if bundle is not None:
        source = bundle.as_posix()
        changes["source"] = BundleSourceSection(path=source)
    elif not source_class(source).on_this_computer or _is_program(plan):
        return Figures()
    report = build_files(plan.model_copy(update=changes), environ=environ, in_memory=True).report
    if bundle is not None:
        _require_same(plan, report.source, source)
    figures = {name: report.figures[name] for name in NAMES if name in report.figures}
    return Figures(source, {name: _rounded(value) for name, value in figures.items()})


def _is_program(plan: Plan) -> bool:
    """Tells whether the source is a xacro file that is not trusted: a program, which a test does not run."""
    path, trusted = getattr(plan.source, "path", ""), getattr(plan.source, "trust", False)
    return Path(path).suffix.lower() == ".xacro" and not trusted


def _require_same(plan: Plan, source: Mapping[str, Any], bundle: str) -> None:
    """Raises ConfigError if a bundle is of another assembly than the plan names."""
    url = getattr(plan.source, "url", None)
    expected = (url.document, url.element) if url else None
    actual = (source.get("document"), source.get("element"))
    if expected and actual != expected:
        msg = "it is a bundle of another assembly than source.url names"
        hint = f"build the robot, and pack it again: linkwright bundle {plan.name} {bundle}"
        raise ConfigError(msg, bundle, hint)


def _rounded(value: float) -> float:
    return value if isinstance(value, int) else float(f"{value:.{DIGITS}g}")
