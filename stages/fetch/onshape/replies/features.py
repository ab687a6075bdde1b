"""Finds the feature lists and variables to fetch if a definition has no limits.

Before v17 of the API recorded mates have no `mateLimits`. The graph stage reads the replies; this module only
finds the assemblies to ask for, and whether their limits refer to a variable.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import orjson

from linkwright.stages.fetch.onshape import definition
from linkwright.stages.formats.onshape_configuration import split_configuration
from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import ProtocolError

_Record = Mapping[str, Any]
_VARIABLE = re.compile(r"#([A-Za-z_]\w*)")


@dataclass(frozen=True, slots=True)
class Owner:
    """An assembly that owns a mate of unknown limits."""

    key: ElementKey
    settings: str
    """All values of the assembly's configuration."""


def owners(body: bytes) -> tuple[Owner, ...]:
    """Returns the assemblies of a definition with a movable mate whose limits are not given, by their
    keys."""
    data = orjson.loads(body)
    used_assemblies = definition.assemblies(data["rootAssembly"], data.get("subAssemblies") or ())
    silent_owners = {
        ElementKey.of(record): record for record in used_assemblies if any(map(_lacks_limits, _mates(record)))
    }
    return tuple(Owner(key, _settings(silent_owners[key], key)) for key in sorted(silent_owners))


def name_variables(body: bytes, owner: Owner) -> bool:
    """Tells whether limits in an assembly's list of features name variables that its configuration lacks."""
    settings = split_configuration(owner.settings)
    return any(name not in settings for name in _names(orjson.loads(body)["features"]))


def check(body: bytes, subject: str, *, tables: bool) -> None:
    """Raises ProtocolError if `body` is not a feature list, or (`tables`) not a list of variable tables."""
    hint = "run the same command again; if it fails each time, the API has changed"
    try:
        data = orjson.loads(body)
    except orjson.JSONDecodeError:
        msg = f"the reply with {subject} is not JSON, or was cut short"
        raise ProtocolError(msg, hint=hint) from None
    if not tables:
        data = data.get("features") if isinstance(data, dict) else None
    if not isinstance(data, list) or not all(isinstance(item, dict) for item in data):
        msg = f"the reply with {subject} contains no list of features"
        raise ProtocolError(msg, hint=hint)


def _settings(record: _Record, key: ElementKey) -> str:
    return str(record.get("fullConfiguration") or key.configuration)


def _mates(record: _Record) -> Iterator[_Record]:
    for feature in record.get("features") or ():
        if feature.get("featureType") == "mate" and not feature.get("suppressed"):
            yield feature.get("featureData") or {}


def _lacks_limits(mate: _Record) -> bool:
    """Tells whether a movable mate with both its sides lacks limits."""
    has_both_sides = len(mate.get("matedEntities") or ()) == 2
    return has_both_sides and mate.get("mateType") != "FASTENED" and mate.get("mateLimits") is None


def _names(features: Any) -> Iterator[str]:
    """Yields the variables in the limits of all mates with enabled limits."""
    for feature in features:
        parameters = list(map(_without_envelope, _without_envelope(feature).get("parameters") or ()))
        switches = [parameter for parameter in parameters if parameter.get("parameterId") == "limitsEnabled"]
        # A switch that the configuration sets may be on.
        if not any(switch.get("value") or "values" in switch for switch in switches):
            continue
        for parameter in parameters:
            if str(parameter.get("parameterId")).startswith("limit"):
                for setting in (
                    parameter,
                    *(
                        _without_envelope(_without_envelope(v).get("value"))
                        for v in parameter.get("values") or ()
                    ),
                ):
                    if not setting.get("isNull"):
                        yield from _VARIABLE.findall(str(setting.get("expression") or ""))


def _without_envelope(record: Any) -> _Record:
    """Returns a feature or parameter without its envelope, if any."""
    inside = record.get("message") if isinstance(record, dict) else {}
    return inside if isinstance(inside, dict) else record
