"""What is wrong with a configuration, in words: full key, value given, what is allowed."""

import difflib
from collections.abc import Iterable
from typing import Any, get_args, get_origin

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from pipeline.config.schema import Place, annotation_at, field_at, is_section, key_of, leaves, names, options
from stages.export.keys import LATER_FORMATS, ExportSection
from stages.fetch.keys import SOURCES
from stages.fetch.source_keys import ADDRESS
from stages.robot.errors import Diagnostic
from stages.robot.keys import NOT_YET, Keys

GLOBAL = "# @package _global_"
"""The first line of a file whose keys are those of the whole tree."""

EXPERIMENT = "experiment"
"""The customary group of files that change a robot and choose its options, over all else."""

WORDS = {
    "bool_type": "must be true or false",
    "dict_type": "must be a mapping",
    "finite_number": "must be finite",
    "float_type": "must be a number",
    "int_type": "must be a whole number",
    "model_type": "must be a mapping",
    "string_too_short": "must not be empty",
    "string_type": "must be text",
}
"""pydantic's error type → what the key must be."""


def told(error: ValidationError, root: type[Keys]) -> list[Diagnostic]:
    """Each problem that pydantic found in a tree of `root`, once, in the order of the tree.

    Codes: E-KEY unknown, E-MISSING, E-LATER not supported yet, E-VALUE not allowed.
    """
    found = [_diagnostic(details, root) for details in error.errors(include_url=False)]
    return list(dict.fromkeys(found))


def shown(value: Any) -> str:
    """A value as an error shows it: as YAML would, and short."""
    if value is None or isinstance(value, bool):
        return str(value).lower().replace("none", "null")
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:57]}..."


def nearest(name: str, candidates: Iterable[str]) -> str:
    """A question that names what is near to `name`; empty where nothing is."""
    near = difflib.get_close_matches(name, sorted(candidates), n=3, cutoff=0.6)
    return f"did you mean {' or '.join(near)}?" if near else ""


def how_to_give(key: str, kind: str = "") -> str:
    """How a value that is missing can be given, of a source of this kind."""
    files = {"urdf": "arm.urdf", "mjcf": "arm.xml", "bundle": "arm.zip"}
    examples = {"source.url": "https://cad.onshape.com/documents/...", "source.path": files.get(kind)}
    example = examples.get(key) or "..."
    return f"set it in the robot's file, or on the command line: \"{key}='{example}'\""


def _diagnostic(details: ErrorDetails, root: type[Keys]) -> Diagnostic:
    kind, place, value = details["type"], details["loc"], details["input"]
    owner = annotation_at(root, place[:-1])
    if place[0] == "source" and len(place) > 1:
        # pydantic puts the kind of source into the place; the tree has no such level.
        owner = annotation_at(SOURCES[str(place[1])], place[2:-1])
        place = ("source", *place[2:])
    name, key = place[-1], key_of(place)
    if kind == "extra_forbidden":
        return _unknown(place, value, owner, root)
    if key == "source" and (kind == "missing" or kind.startswith("union_tag")):
        return _source(None if kind == "missing" else value)
    if kind == "missing" and isinstance(name, str):
        field = field_at(owner, name)
        return Diagnostic("E-MISSING", "missing", key, (field and field.description) or "")
    if kind == NOT_YET:
        return _later(key, value, owner, name)
    if kind == ADDRESS:
        # The value is not shown: it may hold a password.
        return Diagnostic("E-VALUE", details["ctx"]["message"], key, details["ctx"]["hint"])
    if kind == "missing":
        return _value(f"must be a list of {len(get_args(owner))} numbers", value, key_of(place[:-1]))
    if kind == "too_long":
        return _value(f"must be a list of {details['ctx']['max_length']} numbers", value, key)
    if kind == "tuple_type":
        inside = get_args(annotation_at(owner, (name,)))
        several = "" if ... in inside else f" of {len(inside)} numbers"
        return _value(f"must be a list{several}", value, key)
    if name == "[key]":
        hint = f'put the name in quotes: "{value}": ...'
        return _value("names must be text", value, key_of(place[:-2]), hint)
    if kind == "literal_error":
        allowed = options(annotation_at(owner, (name,)))
        hint = f"{nearest(str(value), allowed)} allowed: {', '.join(allowed)}".strip()
        return Diagnostic("E-VALUE", f"{shown(value)} is not allowed", key, hint)
    hint = ""
    if kind == "string_type" and isinstance(value, int | float):
        hint = f"""quote it: {name}: "..." in YAML, "{key}='...'" on the command line"""
        if isinstance(name, int):
            hint = 'quote it: ["..."]'
    return _value(WORDS.get(kind) or details["msg"].replace("Input should be", "must be"), value, key, hint)


def _value(message: str, value: Any, key: str, hint: str = "") -> Diagnostic:
    return Diagnostic("E-VALUE", f"{message} (given {shown(value)})", key, hint)


def _later(key: str, value: Any, owner: Any, name: int | str) -> Diagnostic:
    field, annotation = field_at(owner, name), annotation_at(owner, (name,))
    allowed = options(annotation)
    if allowed:
        text, hint = f"{shown(value)} is not supported yet", f"allowed: {', '.join(allowed)}"
    elif is_section(annotation):
        text, hint = f"{shown(value)} is not supported yet", f"allowed: {', '.join(names(annotation))}"
    elif field is not None and field.json_schema_extra:
        default = field.get_default(call_default_factory=True)
        default = list(default) if isinstance(default, tuple) else default
        text = f"not supported yet (given {shown(value)})"
        hint = f"leave it out: only its default works so far, {shown(default)}"
    else:
        text, hint = f"{shown(value)} is not supported yet", ""
    return Diagnostic("E-LATER", text, key, hint)


def _unknown(place: Place, value: Any, owner: Any, root: type[Keys]) -> Diagnostic:
    name, key = str(place[-1]), key_of(place)
    given = f"(given {shown(value)})"
    if owner is ExportSection and name in LATER_FORMATS:
        hint = f"formats so far: {', '.join(names(owner))}"
        return Diagnostic("E-LATER", f"not supported yet {given}", key, hint)
    if owner.unknown_is_later:
        hint = f"supported so far: {', '.join(names(owner))}"
        return Diagnostic("E-LATER", f"not supported yet {given}", key, hint)
    if key in ("robot", EXPERIMENT) and isinstance(value, dict):
        text, hint = (
            f"the keys of the {key}'s file lie under `{key}`",
            f"the first line of a {key}'s file must be: {GLOBAL}",
        )
        return Diagnostic("E-KEY", text, key, hint)
    if key == EXPERIMENT:
        hint = f"an experiment is a file ./{key}/NAME.yaml, or in a folder that --config-dir names"
        return Diagnostic("E-KEY", f"there is no folder {key} here {given}", key, hint)
    if owner in SOURCES.values():
        here = next(kind for kind, keys in SOURCES.items() if keys is owner)
        others = [kind for kind, keys in SOURCES.items() if name in names(keys)]
        if others:
            text = f"source={here} has no such key {given}"
            return Diagnostic("E-KEY", text, key, f"it belongs to source={others[0]}")
    hint = _dotted(place, value, root) or _instead(name, place, owner, root)
    return Diagnostic("E-KEY", f"unknown key {given}", key, hint)


def _dotted(place: Place, value: Any, root: type[Keys]) -> str:
    """How to quote a name of the user's own that was cut at its dot: joints.joint_0.0.damping."""
    above = place[:-2]
    if not (isinstance(value, dict) and above and get_origin(annotation_at(root, above)) is dict):
        return ""
    return f'a name with a dot is quoted: {key_of(above)}["{place[-2]}.{place[-1]}"]'


def _instead(name: str, place: Place, owner: Any, root: type[Keys]) -> str:
    """Which key may be meant: of the same section, else of the same name elsewhere, else any here."""
    siblings = names(owner)
    # `robot` is the one group that is no section of the plan too.
    candidates = sorted([*siblings, "robot"] if owner is root else siblings)
    near = difflib.get_close_matches(name, candidates, n=3, cutoff=0.6)
    if not near:
        near = [key for key in leaves(root) if key.rpartition(".")[2] == name][:3]
    else:
        near = [key_of((*place[:-1], one)) for one in near]
    if near:
        return f"did you mean {' or '.join(near)}?"
    if owner is root:
        return "linkwright --help lists the keys"
    return f"keys there: {', '.join(siblings)}" if siblings else "there are no keys there yet"


def _source(source: Any) -> Diagnostic:
    choose = f"choose one: {', '.join(f'source={kind}' for kind in SOURCES)}"
    if not source:
        return Diagnostic("E-MISSING", "the robot has no source", "source", choose)
    if not isinstance(source, dict):
        return Diagnostic("E-VALUE", f"must be a mapping (given {shown(source)})", "source", choose)
    kind = source.get("kind")
    if kind is None:
        return Diagnostic("E-MISSING", f"missing (given {shown(source)})", "source.kind", choose)
    return Diagnostic("E-VALUE", f"{shown(kind)} is not allowed", "source.kind", choose)
