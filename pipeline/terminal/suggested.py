"""Suggests what to type in place of a command line that cannot be read."""

import re
from collections.abc import Collection, Iterable, Iterator, Sequence

from linkwright.pipeline.terminal import pasted
from linkwright.stages.robot.text.globs import did_you_mean

NO_KEY = "expected key=value"

_SOURCES = {"urdf": "urdf", "xacro": "urdf", "xml": "mjcf", "mjcf": "mjcf", "zip": "bundle"}
"""Ending of a file → the kind of source that it is."""

_BUILD_WORDS = ("build", "run", "make", "export", "convert")
"""Words that other programs have for what `linkwright` does without a verb."""


def has_url(argument: str) -> bool:
    """Tells whether an argument contains a URL."""
    return "://" in argument


def join_arguments(arguments: Sequence[str]) -> Iterator[tuple[str, list[str]]]:
    """Yields each argument, and the words that the user typed for it: an argument that the shell split at
    spaces, as in `robot = my_arm` or `source.path=my arm.urdf`, is joined again."""
    rest = list(arguments)
    while rest:
        argument = rest.pop(0)
        words = [argument]
        while rest and _continues(argument, rest[0]):
            words.append(rest.pop(0))
            space = "" if "=" in (argument[-1:], words[-1][:1]) else " "
            argument = f"{argument}{space}{words[-1]}"
        yield argument, words


def _continues(argument: str, word: str) -> bool:
    if word[:1] == "=":
        return bool(re.fullmatch(r"[\w.*/]+", argument))
    if re.fullmatch(r"[\w.*/]+=", argument):
        return "=" not in word
    _, equal, value = argument.partition("=")
    return bool(equal) and _is_plain_file(word) and not _ending(value) and "'" not in value


def _is_plain_file(word: str) -> bool:
    return bool(_ending(word)) and "=" not in word and not has_url(word)


def _ending(word: str) -> str:
    ending = word.lower().rpartition(".")[2]
    return ending if ending in (*_SOURCES, "yaml") and "." in word else ""


def split_message(argument: str) -> str:
    """Returns the message about an argument that the shell split at spaces."""
    return "a value with a space needs quotes" if " " in argument else "no spaces belong around ="


def command(arguments: Sequence[str], multirun: bool) -> str:
    """Returns the command line with the arguments that were split joined again."""
    return _line((argument for argument, _ in join_arguments(arguments)), multirun)


def paste(arguments: Iterable[str], multirun: bool) -> str:
    """Returns a hint with the command line, its URLs in quotes."""
    return (
        f"paste: {_line(arguments, multirun)}   (check its end: an unquoted & has cut the URL in the shell)"
    )


def _line(arguments: Iterable[str], multirun: bool) -> str:
    words = ["linkwright", "-m"] if multirun else ["linkwright"]
    for argument in arguments:
        key, _, value = argument.partition("=")
        needs_quotes = has_url(argument) or " " in value
        words.append(pasted.override(key, value) if needs_quotes else pasted.word(argument))
    return " ".join(words)


def assignment(argument: str, arguments: Sequence[str], verbs: Collection[str]) -> tuple[str, str]:
    """Returns message and hint about an argument without a key. `verbs`: those of the command line."""
    if argument in verbs:
        return f"`{argument}` is not supported yet", "linkwright --help lists the verbs"
    if argument in _BUILD_WORDS and len(arguments) > 1:
        words = [word for word, _ in join_arguments(arguments) if word != argument]
        return (
            "there is no such verb",
            f"leave it out, the command builds without a verb: {_line(words, False)}",
        )
    if has_url(argument):
        return NO_KEY, f"linkwright source=onshape {pasted.override('source.url', argument)}"
    suggestion = did_you_mean(argument, verbs)
    if suggestion or not re.fullmatch(r"[\w./~ -]+", argument):
        return NO_KEY, suggestion or "linkwright --help shows how keys and groups are typed"
    ending = argument.lower().rpartition(".")[2]
    key = f"source={_SOURCES[ending]} source.path" if ending in _SOURCES else "robot"
    plain = re.fullmatch(r"[\w./-]+", argument)
    return (
        NO_KEY,
        f"linkwright {key}={argument}" if plain else f"linkwright {_quoted_assignment(key, argument)}",
    )


def _quoted_assignment(key: str, value: str) -> str:
    """Returns `key` with the value assigned to its last word, in quotes."""
    *first_words, last = key.split(" ")
    return " ".join([*first_words, pasted.override(last, value)])
