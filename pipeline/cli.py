"""Runs the command `linkwright`: arguments, help, exit status, error border. Imports nothing heavy."""

import gc
import importlib
import sys
from collections.abc import Callable, Iterable, Sequence
from types import ModuleType
from typing import TYPE_CHECKING, Any

from linkwright.pipeline.options import HELP, JSON, Command, UsageError, parse
from linkwright.pipeline.reference import exit_status
from linkwright.pipeline.terminal import streams
from linkwright.pipeline.verbs import VERBS
from linkwright.stages.robot.system import garbage

if TYPE_CHECKING:
    from linkwright.pipeline.config.plan import Plan
    from linkwright.pipeline.report import Report


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs the command line as the console script; returns the exit status."""
    garbage.collect_rarely()
    streams.survive_closed_pipes()
    status = run(sys.argv[1:] if arguments is None else arguments)
    failure = streams.flush()
    if failure and not status:
        print(f"error: the standard output cannot be written: {failure}", file=sys.stderr)
        status = 1
    gc.freeze()
    return status


def run(arguments: Sequence[str], build: "Callable[[Plan], Report] | None" = None) -> int:
    """Runs a command line and returns the exit status; `build` replaces the real build in tests."""
    if arguments[:1] in (["-sc"], ["--shell-completion"]):
        return _complete("".join(arguments[1:2]))
    if {"-h", *HELP}.intersection(arguments):
        return _run(arguments, build)  # prints only our own text, which needs no cleaning
    # Late: few commands need it, and `--help` does not.
    from linkwright.pipeline.terminal.output import clean_standard_streams

    with clean_standard_streams():
        return _run(arguments, build)


def _run(arguments: Sequence[str], build: "Callable[[Plan], Report] | None") -> int:
    is_verbose = not {"-v", "--verbose"}.isdisjoint(arguments)
    if JSON in arguments and {"-h", *HELP}.isdisjoint(arguments):
        # Late: few commands need it, and `--help` does not.
        from linkwright.pipeline.terminal.json_output import print_document

        return print_document(
            lambda: _run_command(arguments, build), _command_name(arguments), whole=is_verbose
        )
    try:
        status: int = _run_command(arguments, build)
        return status
    except (Exception, KeyboardInterrupt) as error:
        # Late: few commands need it, and `--help` does not.
        from linkwright.pipeline.terminal.error_border import print_error

        return print_error(error, whole=is_verbose)


def _run_command(arguments: Sequence[str], build: "Callable[[Plan], Report] | None") -> Any:
    """Runs a command; returns the exit status, or with `--json` a CommandDocument."""
    if arguments and arguments[0] in VERBS:
        return _run_verb(arguments[0], arguments[1:])
    command = parse(arguments)
    if f"--{command.show}" in HELP:
        print(_help_or_version(command.show))
        return 0
    if command.show:
        for text in _command_output(command):
            print(text, end="")
        return 0
    return _run_or_plan_sweep(command, build) if command.multirun else _run_build(command, build)


def _command_name(arguments: Sequence[str]) -> str:
    """Returns the verb of a command line, `sweep` or `build`."""
    if arguments and arguments[0] in VERBS:
        return arguments[0]
    return "build" if {"-m", "--multirun"}.isdisjoint(arguments) else "sweep"


def _help_or_version(option: str) -> str:
    # Late: few commands need it, and `--help` does not.
    from linkwright.pipeline import help_text

    if option == "version":
        return f"linkwright {_version()}"
    return (help_text.SHORT if option == "help" else help_text.whole()).rstrip()


def _version() -> str:
    # Late: few commands need it, and `--help` does not.
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("linkwright")
    except PackageNotFoundError:
        return "(not installed)"


def _run_verb(name: str, arguments: Sequence[str]) -> Any:
    """Runs a verb, or shows its help; returns the exit status, or with `--json` a CommandDocument."""
    verb = importlib.import_module(VERBS[name])
    if "-h" in arguments or "--help" in arguments:
        print(f"{verb.HELP.rstrip()}\n\n{exit_status.paragraph(name)}")
        return 0
    return verb.run(arguments)


def _command_output(command: Command) -> Iterable[str]:
    """Returns the output of `--install-completion`, `--cfg` or `--info`."""
    if command.show == "install-completion":
        return [_install_completion(command.subject)]
    # Late: few commands need it, and `--help` does not.
    from linkwright.pipeline.config.looking import configuration, information

    return [configuration(command)] if command.show == "cfg" else information(command)


def _complete(argument: str) -> int:
    """Answers a shell's request for completions; a failed query prints nothing."""
    text: str = _completion().run(argument)
    print(text, end="")
    if not text and not argument.startswith("query="):
        print(
            f"error: there is no completion for {argument}\n  → linkwright -sc install=bash", file=sys.stderr
        )
        return 2
    return 0


def _completion() -> ModuleType:
    # Late: few commands need it, and `--help` does not.
    from linkwright.pipeline import completion

    return completion


def _install_completion(shell: str) -> str:
    completion = _completion()
    try:
        return f"{completion.install(shell)}\n"
    except ValueError as error:
        msg = f"there is no completion for {error.args[0] or 'a shell without a name'}"
        hint = " or ".join(f"linkwright --install-completion {name}" for name in completion.SHELLS)
        raise UsageError(f"{msg}\n  → {hint}") from None


def _run_build(command: Command, build: "Callable[[Plan], Report] | None") -> Any:
    from linkwright.pipeline.run.single import single  # `--help` and the verbs need none of it

    return single(command, build)


def _run_or_plan_sweep(command: Command, build: "Callable[[Plan], Report] | None") -> Any:
    from linkwright.pipeline.sweep.command import run_sweep, write_plan  # a single build needs none of it

    return write_plan(command) if command.plan else run_sweep(command, build)
