"""Runs a build from the command line, or reuses its result if nothing changed."""

import os
import sys
from collections.abc import Callable
from typing import TYPE_CHECKING

from linkwright.pipeline import observed
from linkwright.pipeline.json_documents.build import build_document
from linkwright.pipeline.json_documents.document import CommandDocument
from linkwright.pipeline.options import Command
from linkwright.pipeline.report import Report
from linkwright.pipeline.run import unchanged
from linkwright.pipeline.terminal.closing import print_closing_text
from linkwright.pipeline.terminal.display import progress_for
from linkwright.pipeline.terminal.progress import Quiet

if TYPE_CHECKING:
    from linkwright.pipeline.config.plan import Plan


def single(command: Command, build: "Callable[[Plan], Report] | None" = None) -> int | CommandDocument:
    """Runs the build of a command line, prints its result, and returns the exit status; with `--json` returns
    the document of the result. `build` replaces the real build in tests."""
    if build is not None:
        test_report = build(_plan(command))
        return build_document(test_report, whole=False) if command.json else test_report.exit_status
    progress = Quiet() if command.detail == "errors" else progress_for(sys.stderr)
    action = unchanged.action_of(command)
    report = unchanged.reuse(action, command, progress)
    if report is None:
        # Late: an unchanged build does not need it.
        from linkwright.pipeline.run.build import build_files

        with observed.recording(action.key) as observations:
            plan = _plan(command)
            if not (plan.plugins or plan.validate.external):
                # No code here draws with MuJoCo, which else starts a process to look for a window library.
                os.environ.setdefault("MUJOCO_GL", "disable")
            result = build_files(plan, progress)
        unchanged.remember(action, command, observations, result)
        report = result.report
    if command.json:
        return build_document(report, whole=command.detail == "all")
    print_closing_text(report, sys.stdout, command.detail)
    return report.exit_status


def _plan(command: Command) -> "Plan":
    # Late: they import Hydra and pydantic.
    from linkwright.pipeline.config.compose import compose_plan
    from linkwright.pipeline.run.preflight import plan_problems

    return compose_plan(command.overrides, command.config_dirs, judge=plan_problems).plan
