"""The reference of keys, made from the sections: entries, help, Markdown, JSON Schema."""

import json
import re
import textwrap
import types
from dataclasses import asdict
from functools import cache
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import yaml
from pydantic import TypeAdapter
from pydantic.fields import FieldInfo

from linkwright.pipeline.config.plan import SECTIONS, Plan
from linkwright.pipeline.config.schema import is_section
from linkwright.pipeline.motor_files import library
from linkwright.pipeline.reference.environment import VARIABLES
from linkwright.pipeline.reference.key_entries import KeyEntry, is_placeholder
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.robot.section import NOT_YET, Section

UNIT = re.compile(r"\s?\[((?:-|rad|m[²³]?|kg|s|N|/| |or(?= ))+)\]")
"""A unit in the documentation of a key: [m], [N m s/rad or N s/m]."""

INTERPOLATION = {"type": "string", "pattern": r"\$\{.*\}", "description": "A value that Hydra computes."}

DIALECT = "https://json-schema.org/draft/2020-12/schema"


def fields(section):
    """The keys of a section as the configuration names them; those of the plan in the stages' order."""
    stages = [name for model in SECTIONS for name in model.model_fields] if section is Plan else []
    for name in dict.fromkeys(["name", *stages] if stages else section.model_fields):
        yield section.model_fields[name].alias or name, section.model_fields[name]
    if stages:
        yield from ((name, field) for name, field in Plan.model_fields.items() if name not in stages)


@cache
def entries():
    """Every key and section of the configuration, in its order."""
    return tuple(_entries(Plan, (), {}, ""))


def _entries(section, place, names, source):
    """`names`: a place that stands for any name → the name in the examples."""
    meanings = section.meanings()
    for name, field in fields(section):
        path, meaning = (*place, name), meanings.get(name, "")
        yield _entry(path, field, meaning, names, source)
        if path == ("source",):
            for kind, keys in SOURCES.items():
                yield from _entries(keys, path, names, kind)
            continue
        below, named = _section_of(field.annotation)
        if below is None or _later(field):
            continue
        inner = names
        if named:
            path = (*path, "<glob>" if meaning.startswith("Glob") else "<name>")
            inner = {**names, place_name(path): next(iter(_example(field)))}
        yield from _entries(below, path, inner, source)


def place_name(path):
    return ".".join(path)


def _entry(path, field, meaning, names, source):
    kind, allowed = _type(field.annotation, field.metadata)
    meaning = " ".join(meaning.split())
    units = UNIT.findall(meaning)
    if len(units) == 1:
        meaning = UNIT.sub("", meaning)
    return KeyEntry(
        key=place_name(path),
        source=source,
        type=kind,
        unit=units[0] if len(units) == 1 else "",
        default=_default(field),
        allowed=allowed,
        words=tuple(_words(field.annotation)),
        meaning=meaning,
        example="" if kind.startswith("section") or _later(field) else _shown(path, _example(field), names),
        later=_later(field),
    )


def _later(field):
    return isinstance(field.json_schema_extra, dict) and bool(field.json_schema_extra.get(NOT_YET))


def _parts(annotation):
    """A type without `Annotated` and `| None`, its metadata, and whether it may be null."""
    constraints = []
    null = False
    while True:
        if get_origin(annotation) is Annotated:
            annotation, *more = get_args(annotation)
            constraints += more
        elif get_origin(annotation) in (Union, types.UnionType) and type(None) in get_args(annotation):
            (annotation,) = [arg for arg in get_args(annotation) if arg is not type(None)]
            null = True
        else:
            return annotation, constraints, null


def _section_of(annotation):
    """The section that a key holds, and whether it holds one for each name."""
    bare, _, _ = _parts(annotation)
    if get_origin(bare) is dict:
        inside, _, _ = _parts(get_args(bare)[1])
        return (inside, True) if is_section(inside) else (None, False)
    return (bare, False) if is_section(bare) else (None, False)


def _type(annotation, metadata=()):
    """The type of a key in words, and its allowed values."""
    bare, more, null = _parts(annotation)
    name, allowed = _bare_type(bare, [*more, *metadata])
    return (f"{name} or null" if null else name), allowed


def _bare_type(bare, metadata):
    if is_section(bare):
        return "section", ""
    origin, inside = get_origin(bare), get_args(bare)
    if origin is Literal:
        return "choice", ", ".join(map(str, inside))
    if origin is dict:
        return "mapping", ""
    if origin is tuple:
        each, allowed = _type(inside[0])
        several = {"number": "numbers", "text": "texts", "number or null": "numbers or nulls"}.get(
            each, "values"
        )
        count = "" if inside[-1] is ... else f"{len(inside)} "
        return f"list of {count}{several or 'values'}", f"each {allowed}" if allowed else ""
    if origin in (Union, types.UnionType):
        return "section", f"kind: {', '.join(SOURCES)}"
    names = {bool: "true or false", str: "text", int: "whole number", float: "number", Any: "any value"}
    if bare not in names:  # a value of our own, made from what its schema says
        assert TypeAdapter(Annotated[bare, *metadata]).json_schema()["type"] == "string", bare
        return "text", ""
    return names[bare], ", ".join(_bounds(metadata))


def _bounds(metadata):
    for constraint in metadata:
        if isinstance(constraint, FieldInfo):
            yield from _bounds(constraint.metadata)
        for sign, name in ((">", "gt"), (">=", "ge"), ("<", "lt"), ("<=", "le")):
            if getattr(constraint, name, None) is not None:
                yield f"{sign} {getattr(constraint, name):g}"


def _words(annotation):
    bare, _, _ = _parts(annotation)
    if bare is bool:
        return ["false", "true"]
    return sorted(map(str, get_args(bare))) if get_origin(bare) is Literal else []


def _value(field):
    value = field.get_default(call_default_factory=True)
    return list(value) if isinstance(value, tuple) else value


def _default(field):
    if field.is_required():
        return "must be given"
    value = _value(field)
    return "" if isinstance(value, Section) else flow(value)


def _example(field):
    """The example that the section gives, else a value other than the default, else the default."""
    if field.examples:
        return field.examples[0]
    bare, _, _ = _parts(field.annotation)
    value = _value(field)
    if bare is bool:
        return not value
    if get_origin(bare) is Literal:
        return next((word for word in get_args(bare) if word != value), value)
    return value


def flow(value):
    """A value as YAML in one line."""
    text = yaml.safe_dump(value, default_flow_style=True, sort_keys=False, width=10_000, allow_unicode=True)
    return text.removesuffix("\n").removesuffix("\n...").removesuffix("\n")


def _shown(path, value, names):
    """An example as a line of a robot's file."""
    for end in range(len(path), 0, -1):
        part = path[end - 1]
        value = {names[place_name(path[:end])] if is_placeholder(part) else part: value}
    return flow(value)[1:-1]


def json_text():
    return json.dumps([asdict(entry) for entry in entries()], indent=1, ensure_ascii=False) + "\n"


def help_text():
    """The keys as `--help-all` lists them: those of a section together."""
    tops = {}
    for entry in entries():
        if entry.later or entry.is_section or entry.key == "source.kind" or _has_inside(entry):
            continue
        head, _, last = entry.key.rpartition(".")
        end = f" ({entry.source})" if entry.source else ""
        tops.setdefault(f"{head}|{end}", []).append(last)
    lines = []
    for place, last in tops.items():
        head, _, end = place.partition("|")
        inside = f"{{{','.join(last)}}}" if len(last) > 1 else last[0]
        lines.append("  ".join(last) if not head else f"{head}.{inside}{end}".replace(" ", "\xa0"))
    pieces = [piece for words in lines for piece in _pieces(words)]
    wrap = textwrap.TextWrapper(
        80, initial_indent="  ", subsequent_indent="  ", break_on_hyphens=False, break_long_words=False
    )
    return "\n".join(wrap.wrap("  ".join(pieces))).replace("\xa0", " ") + "\n"


def _pieces(words, most=78):
    """The keys of a section, after commas, in as many pieces as a line needs."""
    lines = [""]
    for part in re.findall(r"[^,]*,|[^,]+", words):
        if lines[-1] and len(lines[-1] + part) > most:
            lines.append("")
        lines[-1] += part
    return lines


def _has_inside(entry):
    """Whether the keys inside a mapping are listed in its place."""
    return any(candidate.key.startswith(f"{entry.key}.<") for candidate in entries())


COLUMNS = ("key", "type", "unit", "default", "allowed", "meaning", "example")

INTRODUCTION = """\
# Every key of the configuration

Generated from `stages/*/section.py`, `stages/*/*/section.py` and `pipeline/config/plan.py` by
`python -m tests.config.regenerate`; do not edit. `linkwright explain KEY` prints an entry.

A key is written in a robot's file as YAML, or on the command line as `key=value`. Lengths are in metres,
angles in radians, masses in kilograms; each length and each angle also takes a text with its unit: `"25 mm"`,
`"-90 deg"`. `<name>` means any name, `<glob>` a name or a pattern with `*`, `?` and `[...]`. A value may be
an interpolation of Hydra's: `${vars.reach}`, `${oc.env:DAMPING,0.1}`.
"""


RESERVED = """\
## Reserved

These keys are decided, but not supported yet: only their defaults are accepted.
"""


def markdown():
    """The page of all keys."""
    keys = entries()
    supported = [entry for entry in keys if not entry.later]
    sections = {entry.names[0] for entry in keys if len(entry.names) > 1}
    pages = [INTRODUCTION, "## General\n"]
    pages.append(_keys(entry for entry in supported if entry.key not in sections and len(entry.names) == 1))
    for top in (entry for entry in supported if entry.key in sections):
        own = [entry for entry in supported if entry.names[0] == top.key]
        inside = [entry for entry in own if entry is not top or not top.is_section]
        pages.append(f"## `{top.key}`\n\n{top.meaning}\n")
        for source in dict.fromkeys(entry.source for entry in inside):
            if source:
                pages.append(f"### `source={source}`\n\n{_documentation(SOURCES[source])}\n")
            pages.append(_keys(entry for entry in inside if entry.source == source))
        if top.key == "motors":
            pages.append("The library; `linkwright explain <motor>` shows values and their sources:\n")
            pages.append(_table(("motor", "title", "known values"), _motors()))
    later = [[f"`{entry.key}`", _escaped(entry.meaning)] for entry in keys if entry.later]
    pages.append(RESERVED)
    pages.append(_table(("key", "meaning"), later))
    pages.append("## Environment variables\n")
    variables = [
        [f"`{variable.name}{'=' if variable.value else ''}{variable.value}`", variable.meaning]
        for variable in VARIABLES
    ]
    pages.append(_table(("variable", "meaning"), variables))
    return "\n".join(pages)


def _motors():
    for name, file in library().items():
        content = yaml.safe_load(file.read_text(encoding="utf-8"))
        yield [f"`{name}`", content["title"], ", ".join(content["values"])]


def _keys(rows):
    return _table(COLUMNS, [[_cell(entry, name) for name in COLUMNS] for entry in rows])


def _documentation(section):
    return " ".join((section.__doc__ or "").split())


def _cell(entry, name):
    value = str(getattr(entry, name)).replace("|", "\\|")
    return f"`{value}`" if name in ("key", "default", "example") and value else _escaped(value)


def _escaped(text):
    """Text for a cell; angle brackets outside code are no HTML."""
    parts = re.split(r"(`[^`]*`)", text)
    return "".join(part if part.startswith("`") else part.replace("<", "&lt;") for part in parts)


def _table(header, rows):
    header = list(header)
    lines = [header, ["---"] * len(header), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


HYDRA = {
    "defaults": {"type": "array", "description": "Options of groups that the file chooses: a defaults list."},
    "hydra": {"type": "object", "description": "How a sweep over the robot runs."},
}


def schema():
    """The JSON Schema of a robot's file. Nothing is required: the groups set what the file leaves out."""
    whole = Plan.model_json_schema()
    sections = {name: _section_schema(value) for name, value in whole.pop("$defs").items()}
    top = _section_schema(whole)
    top["properties"] = HYDRA | top["properties"]
    definitions = {"interpolation": INTERPOLATION, **sections}
    return {"$schema": DIALECT, "title": "A robot of Linkwright", **top, "$defs": definitions}


def _section_schema(section):
    kept = {name: value for name, value in section.items() if name not in ("title", "required", "properties")}
    properties = {name: _property(value) for name, value in section.get("properties", {}).items()}
    return {**kept, "properties": properties}


OUTER = ("description", "default", "examples")


def _property(schema):
    outer = {name: schema[name] for name in OUTER if name in schema}
    if schema.get(NOT_YET):
        outer["description"] = f"Not supported yet. {outer.get('description', '')}".strip()
        return {"const": schema.get("default", {}), **outer}
    inner = _inside({name: value for name, value in schema.items() if name not in OUTER})
    return {"anyOf": [*(inner.get("anyOf") or [inner]), {"$ref": "#/$defs/interpolation"}], **outer}


def _inside(schema):
    """A type without titles, with interpolations where values are."""
    if not isinstance(schema, dict):
        return schema
    schema = {name: value for name, value in schema.items() if name not in ("title", "discriminator")}
    if "oneOf" in schema:  # a file may leave the kind of its source to the defaults list
        schema["anyOf"] = schema.pop("oneOf")
    for name in ("items", "additionalProperties"):
        if isinstance(schema.get(name), dict):
            schema[name] = _property(schema[name])
    for name in ("anyOf", "prefixItems"):
        if name in schema:
            made = _property if name == "prefixItems" else _inside
            schema[name] = [made(item) for item in schema[name]]
    return schema


def schema_text():
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"
