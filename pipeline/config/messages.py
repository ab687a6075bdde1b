"""Describes errors of a configuration: the full key, the given value, the allowed values."""

import difflib
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, get_args, get_origin

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from linkwright.pipeline.config.schema import annotation_at, field_at, is_section, leaves, names, options
from linkwright.pipeline.key_path import Place, key_of
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.fetch.source_section import ADDRESS
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.section import NOT_YET, Section
from linkwright.stages.robot.text.printable import join_lines

GLOBAL = "# @package _global_"
"""The first line of a file whose keys start at the top of the tree."""

EXPERIMENT = "experiment"
"""The usual group of files that change a robot and choose its options; they override everything else."""

_LEADING_POINT = re.compile(r"\s*(?:\+|(-))(\.\d+(?:[eE][+-]?\d+)?)\s*")

REQUIREMENTS = {
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


def diagnostics(error: ValidationError, root: type[Section]) -> list[Diagnostic]:
    """Returns the problems that pydantic found in a tree of `root`, each once, in the order of the tree.

    Codes: E-KEY unknown, E-MISSING, E-LATER not supported yet, E-VALUE not allowed.
    """
    problems = [_diagnostic(details, root) for details in error.errors(include_url=False)]
    return list(dict.fromkeys(problems))


def shown(value: Any) -> str:
    """Returns a value as errors show it: short, and as in YAML."""
    if value is None or isinstance(value, bool):
        return str(value).lower().replace("none", "null")
    text = repr(join_lines(value))
    return text if len(text) <= 60 else f"{text[:57]}..."


def nearest(name: str, candidates: Iterable[str]) -> str:
    """Returns a question that suggests the names most similar to `name`, or ""."""
    matches = difflib.get_close_matches(name, sorted(candidates), n=3, cutoff=0.6)
    return f"did you mean {' or '.join(matches)}?" if matches else ""


def how_to_give(key: str, kind: str = "") -> str:
    """Returns a hint that says how to set a missing value; `kind`: the kind of source."""
    files = {"urdf": "arm.urdf", "mjcf": "arm.xml", "bundle": "arm.zip"}
    examples = {"source.url": "https://cad.onshape.com/documents/...", "source.path": files.get(kind)}
    example = examples.get(key) or "..."
    return f"set it in the robot's file, or on the command line: \"{key}='{example}'\""


def with_example(problem: Diagnostic, kind: str) -> Diagnostic:
    """Returns the problem. If a value is missing, its hint has an example for the kind of source."""
    missing = problem.code == "E-MISSING"
    return replace(problem, hint=how_to_give(problem.where, kind)) if missing else problem


@dataclass(frozen=True, slots=True)
class _Problem:
    """A problem that pydantic found."""

    kind: str
    place: Place
    value: Any
    owner: Any  # the section or type that contains the value
    root: type[Section]
    message: str
    context: Mapping[str, Any]  # details of the rule that is broken

    @classmethod
    def of(cls, details: ErrorDetails, root: type[Section]) -> "_Problem":
        place = details["loc"]
        owner = annotation_at(root, place[:-1])
        if place[0] == "source" and len(place) > 1:
            # pydantic puts the kind of source into the place; the tree has no such level.
            owner = annotation_at(SOURCES[str(place[1])], place[2:-1])
            place = ("source", *place[2:])
        context = details.get("ctx", {})
        return cls(details["type"], place, details["input"], owner, root, details["msg"], context)

    @property
    def name(self) -> int | str:
        return self.place[-1]

    @property
    def key(self) -> str:
        return key_of(self.place)

    @property
    def annotation(self) -> Any:
        """The type that the schema requires of the value."""
        return annotation_at(self.owner, (self.name,))


def _diagnostic(details: ErrorDetails, root: type[Section]) -> Diagnostic:
    problem = _Problem.of(details, root)
    handler = _mapping_name if problem.name == "[key]" else _HANDLERS.get(problem.kind, _other)
    diagnostic = handler(problem)
    hint = _point_hint(problem.value) if diagnostic.code == "E-VALUE" else ""
    return replace(diagnostic, hint=hint) if hint else diagnostic


def _point_hint(value: Any) -> str:
    """Returns a hint for a number that YAML reads as text, since it begins with a point; else ""."""
    match = _LEADING_POINT.fullmatch(value) if isinstance(value, str) else None
    return f"write {match[1] or ''}0{match[2]}: in YAML {value} is text" if match else ""


def _missing(problem: _Problem) -> Diagnostic:
    if problem.key == "source":
        return _source_problem(None)
    if isinstance(problem.name, int):
        text = f"must be a list of {len(get_args(problem.owner))} numbers"
        return _value_problem(text, problem.value, key_of(problem.place[:-1]))
    meanings = problem.owner.meanings() if is_section(problem.owner) else {}
    hint = " ".join(meanings.get(problem.name, "").split())
    return Diagnostic("E-MISSING", "missing", problem.key, hint)


def _address(problem: _Problem) -> Diagnostic:
    # The value is not shown: it may hold a password.
    return Diagnostic("E-VALUE", problem.context["message"], problem.key, problem.context["hint"])


def _too_long(problem: _Problem) -> Diagnostic:
    return _value_problem(
        f"must be a list of {problem.context['max_length']} numbers", problem.value, problem.key
    )


def _not_a_list(problem: _Problem) -> Diagnostic:
    inside = get_args(problem.annotation)
    count = "" if ... in inside else f" of {len(inside)} numbers"
    return _value_problem(f"must be a list{count}", problem.value, problem.key)


def _mapping_name(problem: _Problem) -> Diagnostic:
    hint = f'put the name in quotes: "{problem.value}": ...'
    return _value_problem("names must be text", problem.value, key_of(problem.place[:-2]), hint)


def _not_a_choice(problem: _Problem) -> Diagnostic:
    allowed = options(problem.annotation)
    hint = f"{nearest(str(problem.value), allowed)} allowed: {', '.join(allowed)}".strip()
    return Diagnostic("E-VALUE", f"{shown(problem.value)} is not allowed", problem.key, hint)


def _not_text(problem: _Problem) -> Diagnostic:
    hint = ""
    if isinstance(problem.value, int | float):
        hint = f"""quote it: {problem.name}: "..." in YAML, "{problem.key}='...'" on the command line"""
        if isinstance(problem.name, int):
            hint = 'quote it: ["..."]'
    return _value_problem(REQUIREMENTS[problem.kind], problem.value, problem.key, hint)


def _not_a_section(problem: _Problem) -> Diagnostic:
    section, value, hint = problem.annotation, problem.value, ""
    if value is None:
        return Diagnostic("E-VALUE", "has no value", problem.key, "give it keys below, or remove the line")
    if is_section(section) and isinstance(value, bool | int | float):
        keys = [name for name in names(section) if _may_have(section, name, value)]
        hint = f"its keys are set by name, as {problem.key}.{keys[0]}={shown(value)}" if keys else ""
    return _value_problem(REQUIREMENTS[problem.kind], value, problem.key, hint)


def _may_have(section: type[Section], name: str, value: Any) -> bool:
    """Tells whether a key of a section may have a value."""
    try:
        section.model_validate({name: value})
    except ValidationError as error:
        return all(details["loc"][:1] not in ((), (name,)) for details in error.errors())
    return True


def _other(problem: _Problem) -> Diagnostic:
    text = REQUIREMENTS.get(problem.kind) or problem.message.replace("Input should be", "must be")
    return _value_problem(text, problem.value, problem.key)


def _value_problem(message: str, value: Any, key: str, hint: str = "") -> Diagnostic:
    return Diagnostic("E-VALUE", f"{message} (given {shown(value)})", key, hint)


def _unsupported(problem: _Problem) -> Diagnostic:
    value, annotation = problem.value, problem.annotation
    field = field_at(problem.owner, problem.name)
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
    return Diagnostic("E-LATER", text, problem.key, hint)


def _unknown(problem: _Problem) -> Diagnostic:
    place, value, owner, root = problem.place, problem.value, problem.owner, problem.root
    name, key = str(problem.name), problem.key
    value_text = f"(given {shown(value)})"
    if key in _MOVED_KEYS:
        return Diagnostic("E-KEY", f"unknown key {value_text}", key, _MOVED_KEYS[key])
    if _CREDENTIAL_NAME.search(name):
        return Diagnostic("E-KEY", "a key of Onshape is never written in YAML", key, _CREDENTIAL_HINT)
    if owner.unknown_is_later:
        hint = f"supported so far: {', '.join(names(owner))}"
        return Diagnostic("E-LATER", f"not supported yet {value_text}", key, hint)
    if key in ("robot", EXPERIMENT) and isinstance(value, dict):
        text, hint = (
            f"the keys of the {key}'s file are under `{key}`",
            f"the first line of a {key}'s file must be: {GLOBAL}",
        )
        return Diagnostic("E-KEY", text, key, hint)
    if key == EXPERIMENT:
        hint = f"an experiment is a file ./{key}/NAME.yaml, or in a folder that --config-dir names"
        return Diagnostic("E-KEY", f"there is no folder {key} here {value_text}", key, hint)
    if owner in SOURCES.values():
        source_kind = next(kind for kind, keys in SOURCES.items() if keys is owner)
        kinds = [kind for kind, keys in SOURCES.items() if name in names(keys)]
        if kinds:
            text = f"source={source_kind} has no such key {value_text}"
            return Diagnostic("E-KEY", text, key, f"it belongs to source={kinds[0]}")
    hint = _dot_hint(place, value, root) or _similar_keys_hint(name, place, owner, root)
    return Diagnostic("E-KEY", f"unknown key {value_text}", key, hint)


_CREDENTIAL_NAME = re.compile(r"(access|secret|api)_?key|token|password", re.IGNORECASE)
_CREDENTIAL_HINT = (
    "remove it there, and set ONSHAPE_ACCESS_KEY and ONSHAPE_SECRET_KEY in the environment or .env"
)
_MOVED_KEYS = {
    "mesh.target": "it is the group target: target=mjx, or in a file `target: {mjx: {}}`; MuJoCo needs none"
}
"""Key of an earlier version → what to write in its place."""


def _dot_hint(place: Place, value: Any, root: type[Section]) -> str:
    """Returns a hint for a name that was split at its dot, as in joints.joint_0.0.damping; else ""."""
    parent = place[:-2]
    if not (isinstance(value, dict) and parent and get_origin(annotation_at(root, parent)) is dict):
        return ""
    return f'a name with a dot is quoted: {key_of(parent)}["{place[-2]}.{place[-1]}"]'


def _similar_keys_hint(name: str, place: Place, owner: Any, root: type[Section]) -> str:
    """Returns a hint for an unknown key: similar keys of its section, else keys of the same name elsewhere,
    else all keys of its section."""
    siblings = names(owner)
    # `robot` is a group, but no section of the plan.
    candidates = sorted([*siblings, "robot"] if owner is root else siblings)
    matches = difflib.get_close_matches(name, candidates, n=3, cutoff=0.6)
    if not matches:
        matches = [key for key in leaves(root) if key.rpartition(".")[2] == name][:3]
    else:
        matches = [key_of((*place[:-1], sibling)) for sibling in matches]
    if matches:
        return f"did you mean {' or '.join(matches)}?"
    if owner is root:
        return "linkwright --help lists the keys"
    return f"keys there: {', '.join(siblings)}" if siblings else "there are no keys there yet"


def _source_problem(source: Any) -> Diagnostic:
    choose = f"choose one: {', '.join(f'source={kind}' for kind in SOURCES)}"
    if not source:
        return Diagnostic("E-MISSING", "the robot has no source", "source", choose)
    if not isinstance(source, dict):
        return Diagnostic("E-VALUE", f"must be a mapping (given {shown(source)})", "source", choose)
    kind = source.get("kind")
    if kind is None:
        return Diagnostic("E-MISSING", f"missing (given {shown(source)})", "source.kind", choose)
    return Diagnostic("E-VALUE", f"{shown(kind)} is not allowed", "source.kind", choose)


_HANDLERS: dict[str, Callable[[_Problem], Diagnostic]] = {
    NOT_YET: _unsupported,
    ADDRESS: _address,
    "extra_forbidden": _unknown,
    "literal_error": _not_a_choice,
    "missing": _missing,
    "model_type": _not_a_section,
    "string_type": _not_text,
    "too_long": _too_long,
    "tuple_type": _not_a_list,
    "union_tag_invalid": lambda problem: _source_problem(problem.value),
    "union_tag_not_found": lambda problem: _source_problem(problem.value),
}
"""Error type, pydantic's or ours → the diagnostic."""
