"""Reads limits that the assembly definition does not give from the lists of features.

Before v17 of the API mates have no `mateLimits`. The designer's input is then in each assembly's own list of
features, as expressions: the `value` beside them is a stale zero. Lists come in two envelopes, `{typeName,
message: {...}}` and flat with `btType`.

A limit that the designer never typed does not count. It has `isNull`, or, in all recorded replies, the words
of the empty field as its `nullValue` ("No maximum") beside a zero; a typed limit has the `nullValue` "".
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import orjson

from linkwright.stages.formats.onshape_configuration import decode_value, split_configuration
from linkwright.stages.graph.dofs import Freedom
from linkwright.stages.graph.onshape.assembly import Assembly, Mate, Record
from linkwright.stages.graph.onshape.expressions.evaluate import ExpressionError, Scope, measured
from linkwright.stages.graph.onshape.mates.joints import JOINT_TYPES, freedoms_of, limit_names
from linkwright.stages.graph.onshape.reply_fields import protocol_errors
from linkwright.stages.robot.bundle import ElementKey, Features, OnshapeBundle
from linkwright.stages.robot.model.dofs import AS_TYPED, LimitOrigin
from linkwright.stages.robot.model.robot import DofKind

_UNTOUCHED = re.compile(r"\s*(0+(\.0*)?\s*\*?\s*([^\W\d_]+|[°'\"])?)?\s*")
"""The content of an empty field: nothing, or a zero in some unit ("0 deg", "0.0*mm")."""


@dataclass(frozen=True, slots=True)
class _Owner:
    """The parameters of an assembly's mates, with the assembly's configuration and variables."""

    mates: Mapping[str, Mapping[str, Record]]
    """Feature id → parameter id → parameter."""
    configuration: Mapping[str, str]
    scope: Scope


def with_limits(assembly: Assembly, bundle: OnshapeBundle) -> Assembly:
    """Returns the assembly with the limits of every mate that moves, in the shape of `mateLimits`."""
    replies = {features.key: features for features in bundle.features}
    owners: dict[tuple[ElementKey, str], _Owner] = {}
    mates = []
    for mate in assembly.mates:
        mates.append(mate)
        if mate.limits is not None or mate.ref.type == "FASTENED":
            continue
        record = assembly.occurrences[mate.ref.owner].record if mate.ref.owner else assembly.root
        key = ElementKey.of(record)
        if key not in replies:
            why = "the reply has no limits, and the list of features is missing"
            mates[-1] = replace(mate, limit_origin=LimitOrigin(why))
            continue
        settings = record.get("fullConfiguration") or key.configuration
        with protocol_errors("list of features or of variables", f"assembly {key.element}"):
            owner = owners.get((key, settings))
            if owner is None:
                owner = owners[key, settings] = _read(bundle, replies[key], settings)
            limits, origin = _limits(mate, owner)
        mates[-1] = replace(mate, limits=limits, limit_origin=origin)
    return replace(assembly, mates=mates)


def _read(bundle: OnshapeBundle, features: Features, settings: str) -> _Owner:
    configuration = {name: decode_value(value) for name, value in split_configuration(settings).items()}
    expressions, values = dict(configuration), dict[str, str]()
    if features.variables is not None:
        for name, expression, value in _variables(bundle.body(features.variables)):
            expressions.setdefault(name, expression)
            values.setdefault(name, value)
    return _Owner(dict(_mates(bundle.body(features.features))), configuration, Scope(expressions, values))


def _variables(body: bytes) -> Iterator[tuple[str, str, str]]:
    """Yields (name, expression, value as text) of all tables; the element's own come before referenced
    ones."""
    tables = orjson.loads(body)
    for table in sorted(tables, key=lambda table: table.get("variableStudioReference") is not None):
        for variable in table.get("variables") or ():
            value = str(variable.get("value") or "")
            yield variable.get("name", ""), str(variable.get("expression") or value), value


def _mates(body: bytes) -> Iterator[tuple[str, Mapping[str, Record]]]:
    for feature in orjson.loads(body)["features"]:
        record = _unwrap(feature)
        parameters = [_unwrap(envelope) for envelope in record.get("parameters") or ()]
        by_id = {parameter.get("parameterId", ""): parameter for parameter in parameters}
        if "limitsEnabled" in by_id:
            yield record.get("featureId", ""), by_id


def _unwrap(record: Any) -> Record:
    """Returns a feature or parameter without its envelope, if any."""
    message = record.get("message")
    return message if isinstance(message, dict) else record


def _limits(mate: Mate, owner: _Owner) -> tuple[Record, LimitOrigin]:
    """Returns the limits of a mate [m and rad, by Onshape's names], and how they were read."""
    parameters = owner.mates.get(mate.ref.feature)
    if parameters is None:
        return {}, LimitOrigin("the list of features lacks this mate")
    freedoms = freedoms_of(mate.ref.type) if mate.ref.type in JOINT_TYPES else ()
    typed_limits = _TypedLimits({}, {}, [], [], [])
    try:
        if not _parameter_value(parameters["limitsEnabled"], owner).get("value"):
            return {}, AS_TYPED
        for freedom in freedoms:
            for name in limit_names(freedom):
                if name and name in parameters:
                    _read_limit(
                        name,
                        freedom.kind,
                        _parameter_value(parameters[name], owner),
                        owner.scope,
                        typed_limits,
                    )
            _compare(freedom, typed_limits)
    except ExpressionError as error:
        return {}, LimitOrigin(str(error))
    return typed_limits.limits, LimitOrigin(
        "; ".join(typed_limits.reasons), tuple(typed_limits.doubts), tuple(typed_limits.half_open)
    )


@dataclass(frozen=True, slots=True)
class _TypedLimits:
    """The limits of a mate, by Onshape's names."""

    limits: dict[str, float]
    empty: dict[str, str]
    """Name of each limit that was not typed → how the reply shows this."""
    reasons: list[str]
    doubts: list[str]
    half_open: list[str]


def _read_limit(
    name: str, kind: DofKind, parameter: Record, scope: Scope, typed_limits: _TypedLimits
) -> None:
    """Records a limit as a number, as open, or as unknown."""
    text, null_text = str(parameter.get("expression") or ""), str(parameter.get("nullValue") or "")
    if parameter.get("isNull"):
        return
    if null_text and _UNTOUCHED.fullmatch(text):
        typed_limits.empty[name] = f"{text!r} beside {null_text!r}"
        return
    scope.rounded.clear()
    try:
        typed_limits.limits[name] = measured(text, "length" if kind == "slide" else "angle", scope)
    except ExpressionError as error:
        typed_limits.reasons.append(f"{name} is {text!r}, which has no value: {error}")
    else:
        if null_text:
            doubt = f"{name} is {text!r} beside {null_text!r}, which contradict each other: {text!r} is used"
            typed_limits.doubts.append(doubt)
    if scope.rounded:
        names = ", ".join(f"#{variable}" for variable in sorted(scope.rounded))
        typed_limits.reasons.append(f"{name} is {text!r}, with {names} as Onshape shows it, rounded")


def _compare(freedom: Freedom, typed_limits: _TypedLimits) -> None:
    """Drops limits whose lower end is above the upper, and records a side that is open although the other
    side was typed."""
    low, high = (typed_limits.limits.get(name) for name in limit_names(freedom))
    if low is not None and high is not None and low > high:
        typed_limits.reasons.append(f"its lower limit {low:.6g} is above its upper limit {high:.6g}")
        for name in limit_names(freedom):
            del typed_limits.limits[name]
    for name, other in (limit_names(freedom), limit_names(freedom)[::-1]):
        if name in typed_limits.empty and other in typed_limits.limits:
            typed_limits.half_open.append(
                f"{name} is {typed_limits.empty[name]}, so it was not typed: the joint is open on that side"
            )


def _parameter_value(parameter: Record, owner: _Owner) -> Record:
    """Returns the parameter that applies in this configuration; raises ExpressionError if that is unknown."""
    if "configurationParameterId" not in parameter:
        return parameter
    name = parameter["configurationParameterId"]
    option = owner.configuration.get(name)
    for value in map(_unwrap, parameter.get("values") or ()):
        if option is not None and option in _options(value):
            return _unwrap(value["value"])
    setting = f"{name} = {option!r}" if option is not None else f"the unknown value of {name}"
    msg = f"{parameter.get('parameterId')} depends on the configuration, and nothing fits {setting}"
    raise ExpressionError(msg)


def _options(value: Record) -> set[str]:
    """Returns the option of a configuration parameter to which a value belongs, in all its forms."""
    flag = value.get("booleanValue")
    return {
        str(option)
        for option in (
            value.get("configurationValueString"),
            value.get("enumValue"),
            None if flag is None else str(flag).lower(),
        )
        if option
    }
