"""Parses the command line into options and overrides. Imports nothing heavy."""

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, NamedTuple

CFG = ("job", "hydra", "all")
"""What `--cfg` shows."""

INFO = ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath")
"""What `--info` shows."""

ELSEWHERE = {
    "--config-name": "a robot is a file: linkwright robot=NAME builds ./robot/NAME.yaml",
    "--config-path": "add a folder of your own: linkwright --config-dir DIR, where DIR holds robot/",
    "--hydra-help": "linkwright --help lists all options; linkwright --cfg hydra shows Hydra's configuration",
    "--experimental-rerun": "builds are reproducible: type the command again",
}
"""Options of Hydra that have no meaning here → what to do instead."""

SHORT = {
    "-h": "--help", "-m": "--multirun", "-cd": "--config-dir", "-c": "--cfg", "-p": "--package",
    "-i": "--info", "-r": "--run", "-sc": "--shell-completion", "-cn": "--config-name",
    "-cp": "--config-path", "-v": "--verbose", "-q": "--quiet",
}  # fmt: skip


Detail = Literal["errors", "usual", "all"]
"""How much a build tells: errors alone (`-q`), of each code the worst findings, or all of them (`-v`)."""

HELP = ("--help", "--help-all", "--version")
"""Options that show a text of our own."""


# No dataclass: to import their module takes a quarter of the time of `--help`.
class Command(NamedTuple):
    """The parsed command line.

    `show`: the output in place of a build: help, help-all, version, cfg, info, shell-completion or
    install-completion; `what`: its kind; `package` and `resolve` are the options of `--cfg`. `detail`: how
    much a build tells.
    """

    overrides: tuple[str, ...] = ()
    config_dirs: tuple[str, ...] = ()
    multirun: bool = False
    show: str = ""
    what: str = ""
    package: str = ""
    resolve: bool = False
    detail: Detail = "usual"


class UsageError(Exception):
    """The command line has an unknown option, or one without its value."""


def parse(arguments: Sequence[str]) -> Command:
    """Parses the command line; UsageError for an unknown option."""
    rest = _Rest(arguments)
    command = _Reading(rest)
    for argument in rest:
        if not argument.startswith("-"):
            command.overrides.append(argument)
            continue
        option, equal, value = argument.partition("=")
        name = SHORT.get(option, option)
        if name in HELP:
            return Command(show=name[2:])
        reader = _OPTIONS.get(name)
        if reader is None:
            elsewhere = ELSEWHERE.get(name)
            msg = f"there is no option {option} here\n  → {elsewhere}" if elsewhere else ""
            raise UsageError(msg or f"there is no option {option}\n  → linkwright --help lists the options")
        reader(command, option, value if equal else None)
    return command.done()


class _Reading:
    """The options read so far. Each method takes the option as typed, and the value after its `=` or
    None."""

    def __init__(self, rest: "_Rest") -> None:
        self._rest = rest
        self.overrides: list[str] = []
        self._folders: list[str] = []
        self._multirun = self._resolve = False
        self._show, self._what, self._package = "", "", ""
        self._details: set[Detail] = set()

    def multirun(self, option: str, given: str | None) -> None:
        self._multirun = True

    def resolve(self, option: str, given: str | None) -> None:
        self._resolve = True

    def verbose(self, option: str, given: str | None) -> None:
        self._details.add("all")

    def quiet(self, option: str, given: str | None) -> None:
        self._details.add("errors")

    def run(self, option: str, given: str | None) -> None:
        """Hydra's option for a single run; it has no effect here."""

    def config_dir(self, option: str, given: str | None) -> None:
        example = f"{option} DIR, where DIR holds robot/"
        self._folders.append(given or self._rest.value(option, "a folder", example))

    def package(self, option: str, given: str | None) -> None:
        self._package = given or self._rest.value(option, "a key", f"{option} mesh, with --cfg job")

    def cfg(self, option: str, given: str | None) -> None:
        word = given or self._rest.value(option, "a word", f"{option} job")
        self._show, self._what = "cfg", _one_of(CFG, word, option)

    def info(self, option: str, given: str | None) -> None:
        word = given or self._rest.one_of(INFO) or "all"
        self._show, self._what = "info", _one_of(INFO, word, option)

    def completion(self, option: str, given: str | None) -> None:
        self._show = SHORT.get(option, option)[2:]
        self._what = given if given is not None else next(self._rest, "")

    def done(self) -> Command:
        """The whole command; UsageError for options that exclude each other."""
        if self._show != "cfg" and (self._package or self._resolve):
            msg = "--package and --resolve belong to --cfg\n  → linkwright --cfg job --resolve"
            raise UsageError(msg)
        if self._multirun and self._show in ("cfg", "info"):
            text = f"--{self._show} shows one configuration, and a sweep has many"
            msg = f"{text}\n  → leave out -m and give single values"
            raise UsageError(msg)
        if len(self._details) > 1:
            raise UsageError("-q and -v exclude each other\n  → -q shows only errors, -v shows all findings")
        return Command(
            tuple(self.overrides),
            tuple(self._folders),
            self._multirun,
            self._show,
            self._what,
            self._package,
            self._resolve,
            next(iter(self._details), "usual"),
        )


_OPTIONS: dict[str, Callable[[_Reading, str, str | None], None]] = {
    "--multirun": _Reading.multirun,
    "--resolve": _Reading.resolve,
    "--run": _Reading.run,
    "--verbose": _Reading.verbose,
    "--quiet": _Reading.quiet,
    "--config-dir": _Reading.config_dir,
    "--package": _Reading.package,
    "--cfg": _Reading.cfg,
    "--info": _Reading.info,
    "--shell-completion": _Reading.completion,
    "--install-completion": _Reading.completion,
}
"""Option → its reader."""


def _one_of(words: Sequence[str], word: str, option: str) -> str:
    if word not in words:
        msg = f"{option} knows no {word}\n  → {option} {words[0]}, or one of: {', '.join(words)}"
        raise UsageError(msg)
    return word


class _Rest:
    """The arguments that are not yet read."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._arguments = list(arguments)

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        if not self._arguments:
            raise StopIteration
        return self._arguments.pop(0)

    def value(self, option: str, what: str, example: str) -> str:
        found = next(self, "")
        if not found:
            msg = f"{option} needs {what}\n  → {example}"
            raise UsageError(msg)
        return found

    def one_of(self, words: Sequence[str]) -> str:
        """Takes the next argument if it is one of these words; else returns ""."""
        return next(self) if self._arguments and self._arguments[0] in words else ""
