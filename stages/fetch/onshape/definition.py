"""Reads the identity of an assembly and its part studios from the assembly definition."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import orjson

from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import AssemblyError, ProtocolError

_Record = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Definition:
    """An assembly definition, as far as fetch needs it."""

    document: str
    microversion: str
    element: str
    parts: Mapping[ElementKey, tuple[str, ...]]
    """Part studio → the ids of its parts that the assembly uses; keys and ids sorted."""

    solids: Mapping[ElementKey, tuple[str, ...]]
    """The same, only with parts listed as solid bodies, which certainly have a mass and triangles."""


def read(body: bytes) -> Definition:
    """Returns the definition in a reply. Raises ProtocolError for any other reply.

    Suppressed instances, and sub-assemblies that only suppressed instances use, need nothing.
    """
    try:
        data = orjson.loads(body)
        root = data["rootAssembly"]
        used_parts: dict[ElementKey, set[str]] = {}
        for instance in _part_instances(root, data.get("subAssemblies") or ()):
            used_parts.setdefault(ElementKey.of(instance), set()).add(instance["partId"])
        solid_bodies = {
            (ElementKey.of(part), part.get("partId"))
            for part in data.get("parts") or ()
            if part.get("bodyType") == "solid"
        }
        return Definition(
            document=_text(root, "documentId"),
            microversion=_text(root, "documentMicroversion"),
            element=_text(root, "elementId"),
            parts={key: tuple(sorted(used_parts[key])) for key in sorted(used_parts)},
            solids={
                key: tuple(sorted(p for p in used_parts[key] if (key, p) in solid_bodies))
                for key in sorted(used_parts)
            },
        )
    except orjson.JSONDecodeError:
        msg = "the assembly definition is not JSON, or was cut short"
        raise ProtocolError(msg, hint="run the same command again") from None
    except KeyError as error:
        msg = f"the assembly definition lacks the key {error.args[0]!r}"
        raise ProtocolError(msg, hint=_HINT) from None
    except (AttributeError, TypeError) as error:
        msg = f"the assembly definition has an unknown format: {error}"
        raise ProtocolError(msg, hint=_HINT) from None


def require_parts(definition: Definition) -> None:
    """Raises AssemblyError if the assembly has no part."""
    if not definition.parts:
        msg = "the assembly is empty: it has no unsuppressed part"
        hint = "insert parts, or choose another tab or configuration"
        raise AssemblyError(msg, f"assembly {definition.element}", hint)


_HINT = "check that the address is that of an assembly; if it is, the API has changed"


def assemblies(root: _Record, subs: Any) -> Iterator[_Record]:
    """Yields the root, and the sub-assemblies that unsuppressed instances use."""
    definitions = {ElementKey.of(sub): sub for sub in subs}
    pending = [root]
    visited_keys = {ElementKey.of(root)}
    while pending:
        record = pending.pop()
        yield record
        for instance in record["instances"]:
            if instance.get("suppressed") or instance.get("type") != "Assembly":
                continue
            if (key := ElementKey.of(instance)) not in visited_keys:
                if key not in definitions:
                    msg = f"the definition does not describe the sub-assembly {instance.get('name')!r}"
                    raise ProtocolError(msg, hint=_HINT)
                visited_keys.add(key)
                pending.append(definitions[key])


def _part_instances(root: _Record, subs: Any) -> Iterator[_Record]:
    """Yields the unsuppressed part instances of the root and of the sub-assemblies that it uses."""
    for record in assemblies(root, subs):
        for instance in record["instances"]:
            if instance.get("type") == "Part" and not instance.get("suppressed"):
                yield instance


def _text(record: _Record, key: str) -> str:
    value = record[key]
    if not isinstance(value, str) or not value:
        msg = f"{key} is not text"
        raise TypeError(msg)
    return value
