"""The command line, taken apart into options and overrides. Imports nothing heavy."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

CFG = ("job", "hydra", "all")
"""What `--cfg` shows."""

INFO = ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath")
"""What `--info` tells."""

ELSEWHERE = {
    "--config-name": "a robot is a file: linkwright robot=NAME, of ./robot/NAME.yaml",
    "--config-path": "folders of your own are added: linkwright --config-dir DIR, where DIR holds robot/",
    "--hydra-help": "linkwright --help tells all; linkwright --cfg hydra shows what concerns Hydra",
    "--experimental-rerun": "linkwright builds the same from the same files: type the command again",
}
"""Options of Hydra's that mean nothing here → what is done instead."""

SHORT = {
    "-h": "--help", "-m": "--multirun", "-cd": "--config-dir", "-c": "--cfg", "-p": "--package",
    "-i": "--info", "-r": "--run", "-sc": "--shell-completion", "-cn": "--config-name",
    "-cp": "--config-path",
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class Command:
    """The command line, taken apart.

    `show`: what else it asks for than a build: help, version, cfg, info, shell-completion or
    install-completion; `what`: of which kind; `package` and `resolve` are those of `--cfg`.
    """

    overrides: tuple[str, ...] = ()
    config_dirs: tuple[str, ...] = ()
    multirun: bool = False
    show: str = ""
    what: str = ""
    package: str = ""
    resolve: bool = False


class UsageError(Exception):
    """The command line has an option that is not there, or one without its value."""


def parse(arguments: Sequence[str]) -> Command:
    """The command line taken apart; UsageError for an unknown option."""
    overrides: list[str] = []
    folders: list[str] = []
    flags: set[str] = set()
    show, what, package = "", "", ""
    rest = _Rest(arguments)
    for argument in rest:
        option, equal, value = argument.partition("=")
        if not argument.startswith("-"):
            overrides.append(argument)
            continue
        name = SHORT.get(option, option)
        given = value if equal else None
        if name in ("--help", "--version"):
            return Command(show=name[2:])
        if name in ("--multirun", "--resolve", "--run"):
            flags.add(name)
        elif name == "--config-dir":
            folders.append(given or rest.value(option, "a folder", f"{option} DIR, where DIR holds robot/"))
        elif name == "--package":
            package = given or rest.value(option, "a key", f"{option} mesh, with --cfg job")
        elif name == "--cfg":
            show, what = "cfg", _one_of(CFG, given or rest.value(option, "a word", f"{option} job"), option)
        elif name == "--info":
            show, what = "info", _one_of(INFO, given or rest.one_of(INFO) or "all", option)
        elif name in ("--shell-completion", "--install-completion"):
            show, what = name[2:], given if given is not None else next(rest, "")
        elif name in ELSEWHERE:
            msg = f"there is no option {option} here\n  → {ELSEWHERE[name]}"
            raise UsageError(msg)
        else:
            msg = f"there is no option {option}\n  → linkwright --help shows what there is"
            raise UsageError(msg)
    if show != "cfg" and (package or "--resolve" in flags):
        msg = "--package and --resolve belong to --cfg\n  → linkwright --cfg job --resolve"
        raise UsageError(msg)
    multirun = "--multirun" in flags
    if multirun and show in ("cfg", "info"):
        msg = (
            f"--{show} shows one configuration, and a sweep has many\n  → leave out -m and give single values"
        )
        raise UsageError(msg)
    return Command(tuple(overrides), tuple(folders), multirun, show, what, package, "--resolve" in flags)


def _one_of(words: Sequence[str], word: str, option: str) -> str:
    if word not in words:
        msg = f"{option} knows no {word}\n  → {option} {words[0]}, or one of: {', '.join(words)}"
        raise UsageError(msg)
    return word


class _Rest:
    """The arguments that are not taken yet."""

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
        """The next argument where it is one of these words; nothing, and it stays, where it is not."""
        return next(self) if self._arguments and self._arguments[0] in words else ""
