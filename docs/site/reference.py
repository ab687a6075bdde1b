"""Makes pages of what programs know: the command line from its help, and the Python API from docstrings."""

import inspect
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from textwrap import dedent

import linkwright
from linkwright.pipeline.verbs import VERBS

COMMAND_LINE = """\
# The command line

Each text below is what the command prints.
"""

PYTHON = """\
# The Python API

`import linkwright` has these names, and imports nothing else until you use one. Lengths are in metres, angles
in radians, masses in kilograms.
"""

ERRORS = """
## Errors

Each is a `LinkwrightError`, with the message that the command prints.

| error | is a | |
| --- | --- | --- |
"""


def command_line() -> str:
    """The help of the command and of each of its verbs."""
    helps = [("linkwright", ["--help"]), ("All options, keys and variables", ["--help-all"])]
    helps += [(f"linkwright {verb}", [verb, "--help"]) for verb in sorted(VERBS)]
    return COMMAND_LINE + "".join(
        f"\n## {title}\n\n```sh\nlinkwright {' '.join(words)}\n```\n\n```text\n{_printed(words)}```\n"
        for title, words in helps
    )


def _printed(words: list[str]) -> str:
    command = [sys.executable, "-m", "linkwright", *words]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def python() -> str:
    """The names of the package: functions and classes with their docstrings, and a table of the errors."""
    values = {name: getattr(linkwright, name) for name in linkwright.__all__ if name != "__version__"}
    errors = {name: value for name, value in values.items() if _is_error(value)}
    texts = [_entry(name, value) for name, value in _by_use(values) if name not in errors]
    rows = [
        f"| `{name}` | `{value.__base__.__name__}` | {_sentence(value)} |\n" for name, value in errors.items()
    ]
    return PYTHON + "".join(texts) + ERRORS + "".join(rows)


def _is_error(value: object) -> bool:
    return isinstance(value, type) and issubclass(value, Exception)


def _by_use(values: dict[str, object]) -> list[tuple[str, object]]:
    """`build` and what it returns first, then the others by name."""
    first = ["build", "Build", "Robot"]
    return sorted(values.items(), key=lambda item: (first.index(item[0]) if item[0] in first else 3, item[0]))


def _entry(name: str, value: object) -> str:
    """The section of a function or class."""
    lines = [
        f"\n## {name}\n",
        f"\n```python\n{_signature(name, value)}\n```\n",
        f"\n{_documentation(value)}\n",
    ]
    if isinstance(value, type):
        for member, what in sorted(vars(value).items()):
            if not member.startswith("_") and (callable(what) or isinstance(what, property)):
                lines.append(f"\n### {name}.{member}\n\n{_member(member, what)}\n")
        lines += _attributes(value)
    return "".join(lines)


def _member(name: str, what: object) -> str:
    function = what.fget if isinstance(what, property) else what
    text = _documentation(function)
    if isinstance(what, property):
        return text
    return f"```python\n{_signature(name, what)}\n```\n\n{text}"


def _signature(name: str, value: object) -> str:
    """A signature on lines of at most 80 columns, its types without the names of their modules."""
    if not callable(value):
        return name
    signature = re.sub(r"\b(?:\w+\.)+(?=\w)", "", str(inspect.signature(value))).replace("'", "")
    line = f"{name}{signature}"
    if len(line) <= 80:
        return line
    inside, _, after = line.removeprefix(f"{name}(").rpartition(")")
    parameters = re.split(r", (?![^\[]*\])", inside)
    return f"{name}(\n" + "".join(f"    {parameter},\n" for parameter in parameters) + f"){after}"


def _attributes(value: type) -> Iterator[str]:
    """The fields of a dataclass, with the docstrings below them."""
    if not is_dataclass(value):
        return
    texts = _field_texts(value)
    yield "\n| attribute | |\n| --- | --- |\n"
    for field in fields(value):
        if not field.name.startswith("_"):
            yield f"| `{field.name}` | {texts.get(field.name, '')} |\n"


def _field_texts(value: type) -> dict[str, str]:
    pattern = re.compile(r'^    (\w+): [^\n]*\n    """(.*?)"""', re.DOTALL | re.MULTILINE)
    return {name: _cell(text) for name, text in pattern.findall(inspect.getsource(value))}


def _documentation(value: object) -> str:
    """The docstring as Markdown: angle brackets outside code are no HTML."""
    text = inspect.getdoc(value) or ""
    parts = re.split(r"(`[^`]*`)", dedent(text))
    return "".join(part if part.startswith("`") else part.replace("<", "&lt;") for part in parts)


def _sentence(value: object) -> str:
    return _cell(_documentation(value).partition("\n\n")[0])


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


PAGES = {"reference/command-line.md": command_line, "reference/python.md": python}
"""Path of a page → what makes its text."""
