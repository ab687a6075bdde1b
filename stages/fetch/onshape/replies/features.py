"""Finds the feature lists and variables to fetch where a definition has no limits.

Before v17 of the API recorded mates have no `mateLimits`. The graph stage reads the replies; this module
only finds which assemblies to ask for, and whether their limits refer to a variable.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import orjson

from linkwright.stages.fetch.onshape import definition
from linkwright.stages.formats.onshape_configuration import split
from linkwright.stages.robot.bundle import StudioKey
from linkwright.stages.robot.errors import ProtocolError

_Record = Mapping[str, Any]
_VARIABLE = re.compile(r"#([A-Za-z_]\w*)")


@dataclass(frozen=True, slots=True)
class Owner:
    """An assembly that owns a mate of unknown limits; `settings`: all values of its configuration."""

    key: StudioKey
    settings: str


def owners(body: bytes) -> tuple[Owner, ...]:
    """The assemblies of a definition with a movable mate whose limits are not given, by their keys."""
    data = orjson.loads(body)
    used = definition.assemblies(data["rootAssembly"], data.get("subAssemblies") or ())
    found = {StudioKey.of(record): record for record in used if any(map(_silent, _mates(record)))}
    return tuple(Owner(key, _settings(found[key], key)) for key in sorted(found))


def name_variables(body: bytes, owner: Owner) -> bool:
    """Whether limits in an assembly's list of features name variables that its configuration lacks."""
    known = split(owner.settings)
    return any(name not in known for name in _names(orjson.loads(body)["features"]))


def check(body: bytes, what: str, *, tables: bool) -> None:
    """ProtocolError where `body` is not a feature list, or (`tables`) not a list of variable tables."""
    hint = "run the same command again; if it fails each time, the API has changed"
    try:
        data = orjson.loads(body)
    except orjson.JSONDecodeError:
        msg = f"the reply with {what} is not JSON, or was cut short"
        raise ProtocolError(msg, hint=hint) from None
    if not tables:
        data = data.get("features") if isinstance(data, dict) else None
    if not isinstance(data, list) or not all(isinstance(item, dict) for item in data):
        msg = f"the reply with {what} contains no list of features"
        raise ProtocolError(msg, hint=hint)


def _settings(record: _Record, key: StudioKey) -> str:
    return str(record.get("fullConfiguration") or key.configuration)


def _mates(record: _Record) -> Iterator[_Record]:
    for feature in record.get("features") or ():
        if feature.get("featureType") == "mate" and not feature.get("suppressed"):
            yield feature.get("featureData") or {}


def _silent(mate: _Record) -> bool:
    """Whether a movable mate with both its sides lacks limits."""
    whole = len(mate.get("matedEntities") or ()) == 2
    return whole and mate.get("mateType") != "FASTENED" and mate.get("mateLimits") is None


def _names(features: Any) -> Iterator[str]:
    """The variables in the limits of all mates with enabled limits."""
    for feature in features:
        parameters = list(map(_open, _open(feature).get("parameters") or ()))
        switches = [one for one in parameters if one.get("parameterId") == "limitsEnabled"]
        # A switch that the configuration sets may be on.
        if not any(one.get("value") or "values" in one for one in switches):
            continue
        for parameter in parameters:
            if str(parameter.get("parameterId")).startswith("limit"):
                for one in (
                    parameter,
                    *(_open(_open(v).get("value")) for v in parameter.get("values") or ()),
                ):
                    if not one.get("isNull"):
                        yield from _VARIABLE.findall(str(one.get("expression") or ""))


def _open(record: Any) -> _Record:
    """A feature or parameter out of its envelope, if it has one."""
    inside = record.get("message") if isinstance(record, dict) else {}
    return inside if isinstance(inside, dict) else record
