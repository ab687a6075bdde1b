"""The command `linkwright`: arguments, help, exit status, error border. Imports nothing heavy."""

import gc
import importlib
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING

from pipeline import streams
from pipeline.options import Command, UsageError, parse
from pipeline.verbs import VERBS

if TYPE_CHECKING:
    from pipeline.config.plan import Plan
    from pipeline.report import Report

_HELP = """\
linkwright: a robot is a YAML file; this builds it.

usage: linkwright [-m] [--config-dir DIR] [group=option ...] [key=value ...]

  linkwright                                    build the sample that is shipped (no network)
  linkwright robot=my_arm                       build ./robot/my_arm.yaml
  linkwright source=onshape "source.url='https://cad.onshape.com/documents/...'"
                                                build an assembly; both pairs of quotes are needed
  linkwright source=urdf source.path=arm.urdf   build from a URDF or a xacro file, and its meshes
  linkwright source=mjcf source.path=arm.xml    build from an MJCF (MuJoCo XML)
  linkwright robot=my_arm until=graph           stop after a stage: fetch graph mesh export validate
  linkwright robot=my_arm "joints.*.damping=0.2" root=free
                                                change keys and options of a robot
  linkwright experiment=wide                    build the robot of ./experiment/wide.yaml with its changes
  linkwright -m robot=my_arm root=fixed,free    a sweep: every combination, a folder each

other verbs (linkwright VERB --help shows more):
  linkwright bundle NAME out.zip                pack the inputs of the build of NAME, to build it anywhere
  linkwright view NAME                          open the robot of a build in MuJoCo's viewer
  linkwright check DIR|FILE                     whether the files of a robot are right, as they are now
  linkwright diff A B                           what is different between two robots
  linkwright cache info|gc|verify               show the cache's size and API calls, clean it, check it
  linkwright explain CODE|KEY                   explain a diagnostic's code or a key

options:
  -m, --multirun        sweep over values that are separated by commas;
                        in parallel with hydra/launcher=workstation
  --config-dir DIR      DIR holds robot/ with robots of your own (besides ./robot/); may be repeated
  --cfg job|hydra|all   print the validated configuration and build nothing; --resolve replaces ${...} by
                        values, --package KEY prints a part
  --info [KIND]         print how the configuration is composed: all config defaults
                        defaults-tree plugins searchpath
  --install-completion [SHELL]
                        install tab completion for bash, zsh or fish (in this shell only: -sc install=SHELL)
  -h, --help            this text
  --version             the version

groups, each a set of presets (group=option):
  robot       sample, legged, bare, and the files in ./robot/: everything below, in one file
  source      onshape, urdf, mjcf, bundle (a zip of replies), sample
  root        auto, central, fixed, free: the root link and its base
  depth       flexible, rigid: which sub-assemblies may move inside
  mesh        ladder, hull, coacd, primitives, spheres, raw, visual (none): the colliders
  ground      plane, none
  export      [urdf,mjcf], urdf, mjcf, sdf, usd, ros2, python: the formats; [urdf,mjcf,sdf] several
  validate    quick, standard, strict (warnings are errors)
  actuators   none, motor, position, velocity, intvelocity, pid (servos), damper, general: what drives joints
  elements    none

keys (key=value; linkwright explain KEY shows type, unit, default and an example):
{keys}

environment:
{environment}

exit status:
  0  built and valid    1  failed    2  wrong configuration, nothing was built    130  interrupted
  3  built, but a check failed, or the state is not the newest (the API quota is used up)
"""


def help_text() -> str:
    """The text of `--help`; its list of keys is generated from the schema."""
    from pipeline.reference import HELP, environment

    keys = HELP.read_text(encoding="utf-8").rstrip()
    return _HELP.replace("{keys}", keys).replace("{environment}", environment.text())


def main(arguments: Sequence[str] | None = None) -> int:
    """The console script: runs the command line and returns the exit status."""
    # Nearly all objects live until the command ends, and the garbage collector would spend a tenth of
    # its time on them.
    gc.set_threshold(100_000, 50, 100)
    streams.survive_closed_pipes()
    status = run(sys.argv[1:] if arguments is None else arguments)
    why_not = streams.flush()
    if why_not and not status:
        print(f"error: the standard output cannot be written: {why_not}", file=sys.stderr)
        status = 1
    gc.freeze()
    return status


def run(arguments: Sequence[str], build: "Callable[[Plan], Report] | None" = None) -> int:
    """Runs a command line and returns the exit status; `build` replaces the real build in tests."""
    if arguments[:1] in (["-sc"], ["--shell-completion"]):
        return _complete("".join(arguments[1:2]))
    if {"-h", "--help", "--version"}.intersection(arguments):
        return _run(arguments, build)  # prints only our own text, which needs no cleaning
    from pipeline.terminal import clean_streams

    with clean_streams():
        return _run(arguments, build)


def _run(arguments: Sequence[str], build: "Callable[[Plan], Report] | None") -> int:
    try:
        if arguments and arguments[0] in VERBS:
            return _verb(arguments[0], arguments[1:])
        command = parse(arguments)
        if command.show in ("help", "version"):
            print(help_text().rstrip() if command.show == "help" else f"linkwright {_version()}")
            return 0
        if command.show:
            for text in _shown(command):
                print(text, end="")
            return 0
        if command.multirun:
            return _sweep(command, build)
        return _single(command, build)
    except UsageError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except (Exception, KeyboardInterrupt) as error:
        return _report(error)


def _version() -> str:
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("linkwright")
    except PackageNotFoundError:
        return "(not installed)"


def _verb(name: str, arguments: Sequence[str]) -> int:
    """Runs a verb, or shows its help; the exit status."""
    verb = importlib.import_module(VERBS[name])
    if "-h" in arguments or "--help" in arguments:
        print(verb.HELP.rstrip())
        return 0
    status: int = verb.run(arguments)
    return status


def _shown(command: Command) -> Iterable[str]:
    """The output of a command that builds nothing."""
    if command.show == "install-completion":
        return [_install_completion(command.what)]
    from pipeline.config.looking import configuration, information

    return [configuration(command)] if command.show == "cfg" else information(command)


def _complete(argument: str) -> int:
    """Answers a shell's request for completions; a failed query prints nothing."""
    from pipeline import completion

    text = completion.run(argument)
    print(text, end="")
    if not text and not argument.startswith("query="):
        print(
            f"error: there is no completion for {argument}\n  → linkwright -sc install=bash", file=sys.stderr
        )
        return 2
    return 0


def _install_completion(shell: str) -> str:
    from pipeline.completion import SHELLS, install

    try:
        return f"{install(shell)}\n"
    except ValueError as error:
        msg = f"there is no completion for {error.args[0] or 'a shell without a name'}"
        hint = " or ".join(f"linkwright --install-completion {name}" for name in SHELLS)
        raise UsageError(f"{msg}\n  → {hint}") from None


def _single(command: Command, build: "Callable[[Plan], Report] | None") -> int:
    if build is not None:
        return build(_plan(command)).exit_status
    from pipeline import observed, unchanged
    from pipeline.progress import progress_for
    from pipeline.report import show

    progress = progress_for(sys.stderr)
    action = unchanged.action_of(command)
    report = unchanged.again(action, command, progress)
    if report is None:
        from pipeline.build import build_files

        with observed.recording(action.key) as seen:
            built = build_files(_plan(command), progress)
        unchanged.remember(action, command, seen, built)
        report = built.report
    show(report, sys.stdout)
    return report.exit_status


def _plan(command: Command) -> "Plan":
    from pipeline.config.compose import compose_plan
    from pipeline.preflight import plan_problems

    return compose_plan(command.overrides, command.config_dirs, judge=plan_problems).plan


def _sweep(command: Command, build: "Callable[[Plan], Report] | None") -> int:
    import functools
    import time

    from pipeline.build import build as build_robot
    from pipeline.config.compose import session
    from pipeline.output.folder import named
    from pipeline.preflight import sweep_problems
    from pipeline.sweep.folder import keep, prepare
    from pipeline.sweep.launch import Account, launch
    from pipeline.sweep.outcome import Outcome, sweep_status, table
    from pipeline.sweep.run import Task, jobs_of, judge_folders

    began = time.time()
    with session(command.config_dirs, judge=sweep_problems) as composer:
        asked = composer.with_params(*composer.read(command.overrides, multirun=True))
        sweep = jobs_of(composer, asked, sweep_problems)
        judge_folders(sweep.jobs)
        prepare(sweep.root, sweep.jobs[0].plan, command.overrides)
        account = Account(asked.tree, command.overrides, sweep.overrides)
        build = build or functools.partial(build_robot, began=began, sweep=sweep.root)
        ours, numbers = composer.ours(sweep.sweeping.launcher), sweep.sweeping.numbers
        with named(sweep.root):
            outcomes: list[Outcome] = launch(ours, numbers, Task(sweep.jobs, build), sweep.root, account)
    print(table(outcomes, sweep.root))
    keep(outcomes, sweep.root)
    return sweep_status(outcomes)


def _report(error: BaseException) -> int:
    """Prints an error as one message; returns the exit status."""
    from pipeline.errors import exit_status, render
    from pipeline.interrupt import behind

    error = KeyboardInterrupt() if behind(error) else error
    if os.environ.get("LINKWRIGHT_TRACEBACK", "") not in ("", "0"):
        import traceback

        traceback.print_exception(error)
    print(render(error), file=sys.stderr)
    return exit_status(error)
