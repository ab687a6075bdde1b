"""The JSON Schema of robot.json and the page about it, from the records of `stages.formats.robot_json`."""

import inspect
import json
import re
from dataclasses import MISSING, is_dataclass
from typing import get_args

from linkwright.stages.formats.robot_json.codec import entries_of
from linkwright.stages.formats.robot_json.robot import RobotRecord
from tests.config.reference import DIALECT

TITLE = "robot.json of Linkwright"

INTRODUCTION = """# robot.json

The model in no simulator's format, with its origins in CAD. A build writes it beside the robot's other files,
`linkwright check` compares these with it, and `linkwright diff` compares two of it. Its JSON Schema is
[robot_json.schema.json](../robot_json.schema.json). New keys come without a new `version`: a reader passes
over those that it does not know.

Generated from `stages/formats/robot_json` by `python -m tests.config.regenerate`; do not edit.
"""


def records(kind=RobotRecord):
    """The class of each table by its name, from the whole down."""
    kinds = {}
    waiting = [kind]
    while waiting:
        candidate = waiting.pop(0)
        if isinstance(candidate, type) and is_dataclass(candidate):
            if candidate.__name__ not in kinds:
                kinds[candidate.__name__] = candidate
                waiting += [entry.kind for entry in entries_of(candidate)]
        else:
            waiting += get_args(candidate)
    return kinds


def tables(whole=RobotRecord):
    """The records that are tables themselves, from the whole down."""
    kinds = records(whole)
    entries = [entry for kind in kinds.values() for entry in entries_of(kind) if entry.inline]
    inside = {get_args(entry.kind)[0] for entry in entries}
    return {name: kind for name, kind in kinds.items() if kind not in inside}


def meaning(kind):
    """The first paragraph of a record's docstring."""
    return " ".join(inspect.cleandoc(kind.__doc__ or "").split("\n\n")[0].split())


def meanings(kind):
    """Key → what the docstring of a record, or of the record that it adds to, says of it."""
    texts = {}
    for base in reversed(kind.__mro__[:-1]):
        if "__dataclass_fields__" in vars(base):
            _, _, text = inspect.cleandoc(base.__doc__ or "").partition("\n\n")
            rows = re.findall(r"^(\w+): (.*(?:\n    .*)*)", text, re.MULTILINE)
            texts |= {key: " ".join(said.split()) for key, said in rows}
    return texts


def fields(kind):
    """Key, schema, meaning and whether it is always there, of each key of a table."""
    said = meanings(kind)
    for entry in entries_of(kind):
        if entry.inline:
            yield from fields(get_args(entry.kind)[0])
        else:
            data, always = entry.form.schema, entry.default is MISSING
            # What may be left out is left out where it would be null.
            data = data if always else next(iter(data.get("anyOf", [data])))
            yield entry.key, data, said[entry.key][:1].upper() + said[entry.key][1:], always


def schema(kind=RobotRecord, title=TITLE):
    """The JSON Schema of a record."""
    definitions = {name: _table(table) for name, table in tables(kind).items()}
    whole = definitions.pop(kind.__name__)
    return {"$schema": DIALECT, "title": title, **whole, "$defs": definitions}


def _table(kind):
    rows = list(fields(kind))
    return {
        "type": "object",
        "description": meaning(kind),
        "properties": {key: {**data, "description": said} for key, data, said, _ in rows},
        "required": [key for key, _, _, always in rows if always],
    }


def schema_text():
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


def markdown():
    """The page: a section for each table."""
    return INTRODUCTION + "".join(section(kind) for kind in tables().values())


def section(kind, head="##"):
    """A section with the table of a record's keys."""
    rows = [
        f"| `{key}`{'' if always else ' (optional)'} | {_words(data)} | {_escaped(said)} |\n"
        for key, data, said, always in fields(kind)
    ]
    lines = f"| key | value | meaning |\n| --- | --- | --- |\n{''.join(rows)}"
    return f"\n{head} {title(kind.__name__)}\n\n{_escaped(meaning(kind))}\n\n{lines}"


def title(name):
    """The name of a record in words: "Sensor site"."""
    return re.sub(
        r"(?<=[a-z])(?=[A-Z])", " ", name.removesuffix("JsonRecord").removesuffix("Document")
    ).capitalize()


def _words(data):
    """A type in words, tables with a link to their section."""
    if "$ref" in data:
        name = title(data["$ref"].rpartition("/")[2])
        return f"[{name.lower()}](#{name.lower().replace(' ', '-')})"
    if "anyOf" in data:
        return " or ".join(_words(option) for option in data["anyOf"])
    if not data:
        return "any value"
    if "enum" in data:
        return ", ".join(f"`{word}`" if word else '`""`' for word in data["enum"])
    kind = data["type"]
    if isinstance(kind, list):
        return " or ".join(_words({"type": type_name}) for type_name in kind)
    if kind == "array":
        bounds = {data.get("minItems"), data.get("maxItems")}
        count = f"{' or '.join(map(str, sorted(bounds)))} × " if bounds != {None} else ""
        return f"list of {count}{_words(data['items'])}"
    if kind == "object":
        return f"table by names of {_words(data['additionalProperties'])}"
    names = {"string": "text", "boolean": "true or false", "integer": "whole number"}
    return names.get(kind, kind)


def _escaped(text):
    return text.replace("|", "\\|").replace("<", "&lt;")
