"""Text for the user to paste into a shell: quoted, so that no character of a name runs anything there."""

import os
import re
import shlex
from collections.abc import Iterable

_WINDOWS = os.name == "nt"
_SAFE = re.compile(r"[\w@%+=:,./\\-]+", re.ASCII)


def word(text: str, windows: bool = _WINDOWS) -> str:
    """`text` as one word of a POSIX shell; on Windows, of PowerShell.

    In PowerShell's single quotes every character is literal, but for the quote itself, which is doubled
    (about_Quoting_Rules).
    """
    if not windows:
        return shlex.quote(text)
    if _SAFE.fullmatch(text):
        return text
    # PowerShell takes typographic quotes for its own.
    return "'" + re.sub("(['\u2018\u2019\u201a\u201b])", r"\1\1", text) + "'"


def line(words: Iterable[str]) -> str:
    """A command line of these words."""
    return " ".join(map(word, words))


def override(key: str, value: str) -> str:
    """`key=value` with Hydra's quotes around the value, and the shell's around the whole."""
    inner = value.strip().strip("'\"")
    # Hydra takes backslashes for escapes only before a quote.
    inner = re.sub(r"(\\*)('|$)", lambda found: 2 * found[1] + found[2].replace("'", r"\'"), inner)
    text = f"{key}='{inner}'"
    # Double quotes are the form that users know from other examples.
    return word(text) if _WINDOWS or re.search(r'[$`"!\\]', text) else f'"{text}"'
