"""Parses the command line into options and overrides. Imports nothing heavy."""

from collections.abc import Callable, Iterator, Sequence
from typing import Literal, NamedTuple

CFG = ("job", "hydra", "all")
"""Arguments of `--cfg`: parts of the configuration to show."""

INFO = ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath")
"""Arguments of `--info`: kinds of information to show."""

HYDRA_ONLY = {
    "--config-name": "a robot is a file: linkwright robot=NAME builds ./robot/NAME.yaml",
    "--config-path": "add a folder of your own: linkwright --config-dir DIR, where DIR holds robot/",
    "--hydra-help": "linkwright --help lists all options; linkwright --cfg hydra shows Hydra's configuration",
    "--experimental-rerun": "builds are reproducible: type the command again",
}
"""Options of Hydra that have no meaning here → what to do instead."""

LONG_OPTIONS = {
    "-h": "--help", "-m": "--multirun", "-cd": "--config-dir", "-c": "--cfg", "-p": "--package",
    "-i": "--info", "-r": "--run", "-sc": "--shell-completion", "-cn": "--config-name",
    "-cp": "--config-path", "-v": "--verbose", "-q": "--quiet",
}  # fmt: skip


Detail = Literal["errors", "usual", "all"]
"""The findings that a build shows: only errors (`-q`), the worst of each code, or all (`-v`)."""

HELP = ("--help", "--help-all", "--version")
"""Options that show a text of Linkwright's own."""

JSON = "--json"
"""The option by which a command prints one JSON document."""


# Not a dataclass: importing the module `dataclasses` takes a quarter of the time of `--help`.
class Command(NamedTuple):
    """The parsed command line."""

    overrides: tuple[str, ...] = ()
    config_dirs: tuple[str, ...] = ()
    multirun: bool = False
    show: str = ""
    """The output in place of a build: help, help-all, version, cfg, info, shell-completion or
    install-completion; "" for a build."""
    subject: str = ""
    """The argument of the option that `show` names."""
    package: str = ""
    """The part of the configuration that `--cfg` shows."""
    resolve: bool = False
    """Whether `--cfg` resolves interpolations."""
    detail: Detail = "usual"
    """The findings that a build shows."""
    plan: str = ""
    """The file for the list of a sweep's jobs, which are then not built."""
    offline: bool = False
    """Whether the list of jobs is written without an API call."""
    json: bool = False
    """Whether the result is printed as a JSON document."""


class UsageError(Exception):
    """The command line has an unknown option, or an option without its value."""


def parse(arguments: Sequence[str]) -> Command:
    """Parses the command line; raises UsageError for an unknown option."""
    rest = _Arguments(arguments)
    command = _OptionReader(rest)
    for argument in rest:
        if not argument.startswith("-"):
            command.overrides.append(argument)
            continue
        option, equal, value = argument.partition("=")
        name = LONG_OPTIONS.get(option, option)
        if name in HELP:
            return Command(show=name[2:])
        reader = _OPTIONS.get(name)
        if reader is None:
            alternative = HYDRA_ONLY.get(name)
            msg = f"there is no option {option} here\n  → {alternative}" if alternative else ""
            raise UsageError(msg or f"there is no option {option}\n  → {_dash_hint(option[2:])}")
        reader(command, option, value if equal else None)
    return command.finish()


class _OptionReader:
    """Collects the options of a command line. Each method takes the option as typed, and the value after its
    `=` or None."""

    def __init__(self, rest: "_Arguments") -> None:
        self._rest = rest
        self.overrides: list[str] = []
        self._folders: list[str] = []
        self._multirun = self._resolve = self._offline = self._json = False
        self._plan = ""
        self._show, self._subject, self._package = "", "", ""
        self._details: set[Detail] = set()

    def multirun(self, option: str, value: str | None) -> None:
        self._multirun = True

    def resolve(self, option: str, value: str | None) -> None:
        self._resolve = True

    def verbose(self, option: str, value: str | None) -> None:
        self._details.add("all")

    def quiet(self, option: str, value: str | None) -> None:
        self._details.add("errors")

    def run(self, option: str, value: str | None) -> None:
        """Accepts Hydra's option for a single run, which has no effect here."""

    def config_dir(self, option: str, value: str | None) -> None:
        example = f"{option} DIR, where DIR holds robot/"
        self._folders.append(value or self._rest.value(option, "a folder", example))

    def plan(self, option: str, value: str | None) -> None:
        example = f"{option} jobs.json, with -m"
        self._plan = value or self._rest.value(option, "a file", example)
        if "=" in self._plan:
            raise UsageError(f"{option} needs a file, and {self._plan} is an override\n  → {example}")

    def offline(self, option: str, value: str | None) -> None:
        self._offline = True

    def json(self, option: str, value: str | None) -> None:
        self._json = True

    def package(self, option: str, value: str | None) -> None:
        self._package = value or self._rest.value(option, "a key", f"{option} mesh, with --cfg job")

    def cfg(self, option: str, value: str | None) -> None:
        word = value or self._rest.value(option, "a word", f"{option} job")
        self._show, self._subject = "cfg", _require_word(CFG, word, option)

    def info(self, option: str, value: str | None) -> None:
        word = value or self._rest.take_word(INFO) or "all"
        self._show, self._subject = "info", _require_word(INFO, word, option)

    def completion(self, option: str, value: str | None) -> None:
        self._show = LONG_OPTIONS.get(option, option)[2:]
        self._subject = value if value is not None else next(self._rest, "")

    def finish(self) -> Command:
        """Returns the parsed command; raises UsageError for options that exclude each other."""
        if self._show != "cfg" and (self._package or self._resolve):
            msg = "--package and --resolve belong to --cfg\n  → linkwright --cfg job --resolve"
            raise UsageError(msg)
        if self._multirun and self._show in ("cfg", "info"):
            text = f"--{self._show} shows one configuration, and a sweep has many"
            msg = f"{text}\n  → leave out -m and give single values"
            raise UsageError(msg)
        if self._plan and not self._multirun:
            raise UsageError(
                "--plan lists the jobs of a sweep\n  → add -m, and what is swept: root=fixed,free"
            )
        if self._offline and not self._plan:
            msg = "--offline belongs to --plan\n  → source.offline=true builds from what was fetched before"
            raise UsageError(msg)
        if self._json and self._show:
            raise UsageError(f"--json belongs to a build or a sweep\n  → leave it out with --{self._show}")
        if len(self._details) > 1:
            raise UsageError("-q and -v exclude each other\n  → -q shows only errors, -v shows all findings")
        return Command(
            tuple(self.overrides),
            tuple(self._folders),
            self._multirun,
            self._show,
            self._subject,
            self._package,
            self._resolve,
            next(iter(self._details), "usual"),
            self._plan,
            self._offline,
            self._json,
        )


_OPTIONS: dict[str, Callable[[_OptionReader, str, str | None], None]] = {
    "--multirun": _OptionReader.multirun,
    "--resolve": _OptionReader.resolve,
    "--run": _OptionReader.run,
    "--verbose": _OptionReader.verbose,
    "--quiet": _OptionReader.quiet,
    "--config-dir": _OptionReader.config_dir,
    "--package": _OptionReader.package,
    "--plan": _OptionReader.plan,
    "--offline": _OptionReader.offline,
    JSON: _OptionReader.json,
    "--cfg": _OptionReader.cfg,
    "--info": _OptionReader.info,
    "--shell-completion": _OptionReader.completion,
    "--install-completion": _OptionReader.completion,
}
"""Option → the method that reads it."""


def _dash_hint(word: str) -> str:
    """Returns a hint for an unknown option, which may be a key with dashes."""
    if word not in ("robot", "source", "mesh", "export", "output", "name", "until"):
        return "linkwright --help lists the options"
    return f"keys have no dashes: linkwright {word}=..."


def _require_word(words: Sequence[str], word: str, option: str) -> str:
    if word not in words:
        msg = f"{option} knows no {word}\n  → {option} {words[0]}, or one of: {', '.join(words)}"
        raise UsageError(msg)
    return word


class _Arguments:
    """The arguments of a command line that are not yet read."""

    def __init__(self, arguments: Sequence[str]) -> None:
        self._arguments = list(arguments)

    def __iter__(self) -> Iterator[str]:
        return self

    def __next__(self) -> str:
        if not self._arguments:
            raise StopIteration
        return self._arguments.pop(0)

    def value(self, option: str, thing: str, example: str) -> str:
        """Takes the next argument, the value of an option; raises UsageError if there is none."""
        argument = next(self, "")
        if not argument:
            msg = f"{option} needs {thing}\n  → {example}"
            raise UsageError(msg)
        return argument

    def take_word(self, words: Sequence[str]) -> str:
        """Takes the next argument if it is one of these words; else returns ""."""
        return next(self) if self._arguments and self._arguments[0] in words else ""
