"""The list of features of one assembly, in the old envelope and in the new one.

The old: `{type, typeName, message: {...}}`, states as a list. The new: flat with `btType`, states by
id. Both give limits as the author typed them, beside a value that is always 0. As in all recordings,
every mate has the fields of every limit, none `isNull`: one that nobody typed in says so in `nullValue`,
and holds a zero.
"""

from tests.fake_onshape import ids
from tests.fake_onshape.elements import Connector, Group, Mate, Relation
from tests.fake_onshape.mates import FREEDOMS

_KINDS = {
    Mate: (64, "BTMMate", "mate"),
    Connector: (66, "BTMMateConnector", "mateConnector"),
    Group: (65, "BTMMateGroup", "mateGroup"),
    Relation: (1412, "BTMMateRelation", "mateRelation"),
}
_SIDES = ("X", "Y", "Z", "AxialX", "AxialY", "AxialZ")
_LIMITS = (*(f"limit{side}{end}" for side in _SIDES for end in ("Min", "Max")), "limitEulerConeAngleMax")
"""The fields of every mate, whatever its type."""


def features(assembly, *, old):
    """The reply; `old`: in the old envelope."""
    made = [_feature(feature, old) for feature in assembly.features]
    state = _wrap(1688, "BTFeatureState", {"featureStatus": "OK", "inactive": False}, old)
    ids = [feature.id for feature in assembly.features]
    return {
        **({} if old else {"btType": "BTAssemblyFeatureListResponse-1174"}),
        "features": made,
        "featureStates": [{"key": feature, "value": state} for feature in ids]
        if old
        else dict.fromkeys(ids, state),
        "isComplete": True,
        "serializationVersion": "1.2.12",
        "sourceMicroversion": assembly.home.microversion,
        "rejectMicroversionSkew": False,
        "microversionSkew": False,
        "libraryVersion": 0,
    }


def _feature(feature, old):
    number, name, kind = _KINDS[type(feature)]
    record = {
        "featureId": feature.id,
        "name": feature.name,
        "featureType": kind,
        "suppressed": getattr(feature, "suppressed", False),
        "parameters": _mate(feature, old) if isinstance(feature, Mate) else [],
    }
    return _wrap(number, name, record, old)


def _mate(mate, old):
    typed = {
        name: text
        for freedom, pair in zip(FREEDOMS[mate.type], mate.typed_limits, strict=True)
        for name, text in zip(freedom.limit_names, pair, strict=True)
        if name and text is not None
    }
    parameters = [
        _parameter(mate, 145, "BTMParameterEnum", "mateType", {"value": mate.type}, old),
        _parameter(mate, 144, "BTMParameterBoolean", "limitsEnabled", {"value": bool(typed)}, old),
    ]
    for name in _LIMITS:
        untouched = "0 deg" if "A" in name else "0 mm"
        empty = "No minimum" if name.endswith("Min") else "No maximum"
        record = {
            "isNull": False,
            "nullValue": "" if name in typed else empty,
            "units": "",
            "value": 0.0,
            "expression": typed.get(name, untouched),
            "isInteger": False,
        }
        parameters.append(_parameter(mate, 807, "BTMParameterNullableQuantity", name, record, old))
    return parameters


def _parameter(mate, number, kind, name, record, old):
    named = {"parameterId": name, "nodeId": ids.node_id(mate.id, name)}
    return _wrap(number, kind, {**record, **named}, old)


def _wrap(number, name, record, old):
    if old:
        return {"type": number, "typeName": name, "message": record}
    return {"btType": f"{name}-{number}", **record}
