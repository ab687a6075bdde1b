"""Quotes text for the user to paste into a shell, so that no character of a name runs a command."""

import os
import re
import shlex
from collections.abc import Iterable

_WINDOWS = os.name == "nt"
_SAFE = re.compile(r"[\w@%+=:,./\\-]+", re.ASCII)


def word(text: str, windows: bool = _WINDOWS) -> str:
    """Returns `text` as a single word of a POSIX shell; on Windows, of PowerShell.

    In PowerShell's single quotes every character is literal, except the quote itself, which is doubled
    (about_Quoting_Rules).
    """
    if not windows:
        return shlex.quote(text)
    if _SAFE.fullmatch(text):
        return text
    # PowerShell takes typographic quotes for its own.
    return "'" + re.sub("(['\u2018\u2019\u201a\u201b])", r"\1\1", text) + "'"


def line(words: Iterable[str]) -> str:
    """Returns a command line of these words."""
    return " ".join(map(word, words))


def override(key: str, value: str) -> str:
    """Returns `key=value` with Hydra's quotes around the value, and the shell's quotes around both."""
    inner = value.strip().strip("'\"")
    # Hydra takes backslashes for escapes only before a quote.
    inner = re.sub(r"(\\*)('|$)", lambda match: 2 * match[1] + match[2].replace("'", r"\'"), inner)
    text = f"{key}='{inner}'"
    # Double quotes are the form that users know from other examples.
    return word(text) if _WINDOWS or re.search(r'[$`"!\\]', text) else f'"{text}"'
