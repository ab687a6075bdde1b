"""A sweep as the command line asks for it."""

import functools
import time
from collections.abc import Callable

from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.options import Command
from linkwright.pipeline.output.folder import named
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.build import build as build_robot
from linkwright.pipeline.run.preflight import sweep_problems
from linkwright.pipeline.sweep.folder import keep, prepare
from linkwright.pipeline.sweep.launch import Account, launch
from linkwright.pipeline.sweep.outcome import Outcome, sweep_status, table
from linkwright.pipeline.sweep.run import Task, jobs_of, judge_folders
from linkwright.pipeline.terminal.output import say


def sweep(command: Command, build: Callable[[Plan], Report] | None) -> int:
    """Builds each robot of the sweep; returns the exit status."""
    began = time.time()
    with session(command.config_dirs, judge=sweep_problems) as composer:
        asked = composer.with_params(*composer.read(command.overrides, multirun=True))
        swept = jobs_of(composer, asked, sweep_problems)
        judge_folders(swept.jobs)
        prepare(swept.root, swept.jobs[0].plan, command.overrides)
        account = Account(asked.tree, command.overrides, swept.overrides)
        build = build or functools.partial(build_robot, began=began, sweep=swept.root)
        ours, numbers = composer.ours(swept.sweeping.launcher), swept.sweeping.numbers
        with named(swept.root):
            task = Task(swept.jobs, build, is_quiet=command.detail == "errors")
            outcomes: list[Outcome] = launch(ours, numbers, task, swept.root, account)
    status = sweep_status(outcomes)
    if status or command.detail != "errors":
        say(table(outcomes, swept.root))
    keep(outcomes, swept.root)
    return status
