"""Tab completion for bash, zsh and fish: the shell scripts, and the candidates for a command line.

It runs at every press of the tab key, so it reads only file names and the list of keys and imports nothing
heavy. File names may be hostile: a name that a shell could read as more than a word is never offered.
"""

import importlib.util
import os
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path

from linkwright.pipeline.motor_files import is_motor, library
from linkwright.pipeline.reference.key_entries import entries, is_placeholder, matching
from linkwright.pipeline.verbs import VERBS

CONF = Path(__file__).resolve().parents[1] / "conf"

SHELLS = ("bash", "zsh", "fish")

LAUNCHERS: Mapping[str, tuple[str, ...]] = {
    "hydra_joblib_launcher": ("joblib",),
    "hydra_submitit_launcher": ("submitit_local", "submitit_slurm"),
    "hydra_ray_launcher": ("ray", "ray_aws"),
}
"""Package in `hydra_plugins` → the launchers in it."""

MOTOR_KEY = "actuators.<glob>.motor"
"""The key whose values are the names of motors."""

PATH_KEYS = ("source.path", "output", "cache.dir", "robot")
"""Keys whose values are files or folders."""

OPTION_WORDS: Mapping[str, tuple[str, ...]] = {
    "--cfg": ("job", "hydra", "all"),
    "--info": ("all", "config", "defaults", "defaults-tree", "plugins", "searchpath"),
    "--install-completion": SHELLS,
    "--level": ("quick", "standard", "strict"),
}
"""Option → the words that may follow it."""

LONG_OPTIONS = {"-c": "--cfg", "-i": "--info", "-cd": "--config-dir"}
"""Short option → long option."""

OPTIONS = (
    "--multirun", "--config-dir", "--cfg", "--package", "--resolve", "--info", "--install-completion",
    "--plan", "--offline", "--verbose", "--quiet", "--json", "--help", "--help-all", "--version",
)  # fmt: skip

VERB_OPTIONS: Mapping[str, tuple[str, ...]] = {
    "check": ("--level", "--json", "--sarif", "--junit", "--baseline", "--help"),
    "diff": ("--json", "--markdown"),
    "job": ("--shard", "--json", "--help"),
    "jobs": ("--fetch", "--shard", "--json", "--help"),
    "new": ("--deep", "--from", "--config-dir", "--json", "--help"),
    "skill": ("--path", "--help"),
    "snapshot": ("--check", "--config-dir", "--help"),
}
"""Verb whose arguments are files or folders → its options."""

BASH = """\
_linkwright() {
    local found
    COMPREPLY=()
    while IFS= read -r found; do
        COMPREPLY+=("$found")
    done < <(COMP_LINE="$COMP_LINE" COMP_POINT="$COMP_POINT" COMP_WORDBREAKS="$COMP_WORDBREAKS" \\
        "${COMP_WORDS[0]}" -sc query=bash 2>/dev/null)
}
complete -o nospace -F _linkwright linkwright
"""

ZSH = """\
#compdef linkwright
_linkwright() {
    emulate -L zsh
    local -a found open whole
    found=("${(@f)$(COMP_LINE="${(j: :)words[1,CURRENT]}" "${(Q)words[1]}" -sc query=zsh 2>/dev/null)}")
    open=(${(M)found:#*[=./]}) whole=(${found:#*[=./]})
    (( $#open )) && compadd -Q -S '' -- $open
    (( $#whole )) && compadd -Q -- $whole
}
(( $+functions[compdef] )) || { autoload -Uz compinit && compinit -u; }
compdef _linkwright linkwright
"""

FISH = """\
function __linkwright_complete
    set -lx COMP_LINE (commandline -cp)
    set -l words (commandline -cpo)
    $words[1] -sc query=fish 2>/dev/null
end
complete -c linkwright -f -a '(__linkwright_complete)'
"""

SCRIPTS = {"bash": BASH, "zsh": ZSH, "fish": FISH}

REMOVAL_SCRIPTS = {
    "bash": "complete -r linkwright; unset -f _linkwright\n",
    "zsh": "compdef -d linkwright; unfunction _linkwright\n",
    "fish": "complete -e -c linkwright; functions -e __linkwright_complete\n",
}


def run(argument: str, environ: Mapping[str, str] = os.environ) -> str:
    """Returns the output of `-sc` for `install=`, `uninstall=` or `query=SHELL`, as in Hydra; else ""."""
    verb, _, shell = argument.partition("=")
    if shell not in SHELLS:
        return ""
    if verb == "query":
        return "".join(f"{candidate}\n" for candidate in query(shell, environ))
    return {"install": SCRIPTS, "uninstall": REMOVAL_SCRIPTS}.get(verb, {}).get(shell, "")


_HARMLESS = re.compile(r"[\w./,+:=@ -]*")
"""Texts that completion may add: characters without a meaning in any shell, a space after a backslash."""


def query(shell: str, environ: Mapping[str, str]) -> list[str]:
    """Returns the candidates for the line in `COMP_LINE`, in the format of the shell."""
    line = environ.get("COMP_LINE", "")
    point = environ.get("COMP_POINT", "")
    # The words as typed, with quotes and backslashes; the first is the command itself.
    raw_words = split(line[: int(point)] if point.isdigit() else line)
    if len(raw_words) < 2:
        return []
    typed, words = raw_words[-1], [word.replace("\\ ", " ") for word in raw_words]
    rests = _additions(words[-1], candidates(words[-1], words[1:-1], Path.cwd()))
    if shell == "fish":
        # fish quotes what it inserts.
        return [words[-1] + rest for rest in rests]
    rests = [typed + rest.replace(" ", "\\ ") for rest in rests]
    if shell == "zsh":
        return rests
    # bash replaces only the text after the last of these characters, and the script asks it to add no space.
    breaks = set(environ.get("COMP_WORDBREAKS", "=:")) & set("=:@")
    cut = max((typed.rfind(character) + 1 for character in breaks), default=0)
    sweep = {"-m", "--multirun"} & set(words)
    return [text[cut:] if text.endswith(("=", ".", "/")) or sweep else f"{text[cut:]} " for text in rests]


def _additions(word: str, texts: Iterable[str]) -> list[str]:
    """Returns the text that each candidate adds to `word`.

    Leaves out candidates that would add more to a shell's line than a part of a word (`$(...)`, quotes,
    globs, control characters), and names of files that would be read as options."""
    rests = (text.removeprefix(word) for text in texts)
    forbidden_starts = () if word else ("-", "=")
    return [rest for rest in rests if _HARMLESS.fullmatch(rest) and not rest.startswith(forbidden_starts)]


def split(line: str) -> list[str]:
    """Returns the words of a line, with their quotes and backslashes; the last is empty after a space."""
    words, quote, escaped = [""], "", False
    for letter in line:
        if letter.isspace() and not quote and not escaped:
            words += [""] if words[-1] else []
            continue
        if letter in "'\"" and not escaped:
            quote = "" if letter == quote else quote or letter
        escaped = letter == "\\" and not escaped and quote != "'"
        words[-1] += letter
    return words


def candidates(word: str, context: Sequence[str], cwd: Path) -> list[str]:
    """Returns the sorted completions of `word`, which follows the words `context` on the command line."""
    option = LONG_OPTIONS.get(context[-1], context[-1]) if context else ""
    if option in ("--config-dir", "--plan"):
        return [file for file in _files(word, cwd) if file.endswith("/") or option == "--plan"]
    if context and context[0] in VERB_OPTIONS and option != "--level":
        paths = [file for file in _files(word, cwd) if context[0] != "snapshot" or file.endswith("/")]
        return _with_prefix(VERB_OPTIONS[context[0]], word) if word.startswith("-") else paths
    if option in OPTION_WORDS and (words := _with_prefix(OPTION_WORDS[option], word)):
        return words
    if word.startswith("-"):
        return _with_prefix(OPTIONS, word)
    if option == "--package":
        return []
    if context[:1] == ["explain"]:
        return _explainable_names(word)
    sign = word[: len(word) - len(word.lstrip("+~"))]
    word = word[len(sign) :]
    folders = [cwd, *(cwd / directory for directory in _config_dirs(context))]
    key, equal, value = word.partition("=")
    if equal:
        head, comma, last = value.rpartition(",")
        completions = [f"{key}={head}{comma}{option_value}" for option_value in _values(key, last, folders)]
    else:
        completions = _with_prefix((f"{group}=" for group in _groups(folders)), word)
        completions += [] if sign == "~" else _keys(word)
        completions += _with_prefix(VERBS, word) if not context and not sign else []
    return [sign + completion for completion in sorted(set(completions))]


def _with_prefix(words: Iterable[str], start: str) -> list[str]:
    return sorted(word for word in words if word.startswith(start))


def _explainable_names(word: str) -> list[str]:
    # Imported late, since other completions do not need it.
    from linkwright.pipeline.verbs.explain import names

    return _with_prefix(sorted(set(names())), word)


def _config_dirs(words: Sequence[str]) -> Iterator[str]:
    for option, value in zip(words, [*words[1:], ""], strict=False):
        if option in ("--config-dir", "-cd"):
            yield value
        elif option.startswith(("--config-dir=", "-cd=")):
            yield option.partition("=")[2]


def _groups(folders: Iterable[Path]) -> set[str]:
    """Returns the groups in `conf`, and the user's `experiment`; other folders may hold anything."""
    shipped_groups = {folder.name for folder in CONF.iterdir() if folder.is_dir() and folder.name != "hydra"}
    user_groups = {"experiment" for folder in folders if (folder / "experiment").is_dir()}
    return {name for name in shipped_groups if not name.startswith("_")} | user_groups | {"hydra/launcher"}


def _values(key: str, start: str, folders: Sequence[Path]) -> list[str]:
    words: list[str] = []
    if key in _groups(folders):
        words = [option for folder in (CONF, *folders) for option in _options(folder / key)]
        words += _launchers() if key == "hydra/launcher" else ()
    else:
        words = [word for entry in matching(key, entries()) for word in entry.words]
        if any(entry.key == MOTOR_KEY for entry in matching(key, entries())):
            words += library(folders)
    paths = _files(start, folders[0]) if key in PATH_KEYS and (key != "robot" or "/" in start) else []
    return [*_with_prefix(words, start), *paths]


def _launchers() -> list[str]:
    """Returns Hydra's own launcher, and the launchers of installed plug-ins."""
    spec = importlib.util.find_spec("hydra_plugins")
    places = [Path(place) for place in spec.submodule_search_locations or ()] if spec else []
    return ["basic"] + [
        launcher
        for package, launchers in LAUNCHERS.items()
        for launcher in launchers
        if any((place / package).is_dir() for place in places)
    ]


def _options(group: Path) -> Iterator[str]:
    for file in group.rglob("*.yaml"):
        if not is_motor(file, group):
            yield file.relative_to(group).with_suffix("").as_posix()


def _files(start: str, cwd: Path) -> list[str]:
    """Returns files and folders whose path begins with `start`; folders end with a slash."""
    folder, slash, name = start.rpartition("/")
    place = cwd / Path(f"{folder}{slash}").expanduser()
    try:
        names_in_folder = sorted(place.iterdir())
    except OSError:
        return []
    return [
        f"{folder}{slash}{path.name}{'/' if path.is_dir() else ''}"
        for path in names_in_folder
        if path.name.startswith(name) and (name or not path.name.startswith("."))
    ]


def _keys(word: str) -> list[str]:
    """Returns the keys that begin with `word`, up to the next dot."""
    *typed, last = word.split(".")
    keys = set()
    for entry in entries():
        names = entry.names
        if entry.is_section or len(names) <= len(typed):
            continue
        if not all(is_placeholder(name) or name == part for name, part in zip(names, typed)):
            continue
        name = names[len(typed)]
        if not is_placeholder(name) and name.startswith(last):
            end = "=" if len(names) == len(typed) + 1 else "."
            keys.add(".".join([*typed, name]) + end)
    return sorted(keys)


def install(shell: str, environ: Mapping[str, str] = os.environ) -> str:
    """Installs the script of a shell (default: the current shell); returns a description of the changes.

    Raises ValueError for an unknown shell.
    """
    shell = shell or Path(environ.get("SHELL", "")).name
    if shell not in SHELLS:
        raise ValueError(shell)
    home = Path(environ.get("HOME", "~")).expanduser()
    if shell == "fish":
        config = Path(environ.get("XDG_CONFIG_HOME") or home / ".config")
        script = config / "fish" / "completions" / "linkwright.fish"
        start = None
    else:
        data = Path(environ.get("XDG_DATA_HOME") or home / ".local" / "share")
        script = data / "linkwright" / f"completion.{shell}"
        start = Path(environ.get("ZDOTDIR") or home) / ".zshrc" if shell == "zsh" else home / ".bashrc"
    script.parent.mkdir(parents=True, exist_ok=True)
    script.write_text(SCRIPTS[shell], encoding="utf-8")
    changes = [f"{script}: completion for {shell}"]
    if start is not None:
        path = f'"{script}"' if re.fullmatch(r"[\w ./,+:=@-]+", str(script)) else shlex.quote(str(script))
        line = f"[ -r {path} ] && . {path}  # completion of linkwright\n"
        before = start.read_text(encoding="utf-8") if start.exists() else ""
        if line not in before:
            gap = "" if not before or before.endswith("\n") else "\n"
            with start.open("a", encoding="utf-8") as file:
                file.write(gap + line)
        changes.append(f"{start}: loads it")
    return "\n".join([*changes, "open a new shell to use it"])
