"""Compares our sum of masses with Onshape's, to check that reused replies still describe the assembly.

A part studio that derives from another can change while its own microversion stays. Its mass then differs
from the cached reply, and so does the mass of the assembly, which the server gives in a single call.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import orjson

from linkwright.stages.robot.bundle import ElementKey
from linkwright.stages.robot.errors import Diagnostic, ProtocolError, SourceError

_RELATIVE_TOLERANCE = 1e-6
"""Largest relative difference of sums of the same parts, by rounding; a changed part differs more."""

_HINT = "run the same command again; if it fails each time, set source.verify: false"


@dataclass(frozen=True, slots=True)
class Masses:
    """Masses of an assembly [kg].

    Whether the server's mass includes hidden instances is not documented, so either of our sums may agree.
    """

    onshape_mass: float
    """The server's mass of the assembly."""

    sum_of_parts: float
    """Our sum over all occurrences."""

    sum_of_visible: float
    """Our sum without hidden occurrences."""

    @property
    def agree(self) -> bool:
        """Whether the server's mass is one of our sums, up to rounding."""
        tolerance = _RELATIVE_TOLERANCE * max(abs(self.onshape_mass), abs(self.sum_of_parts))
        return (
            min(abs(self.onshape_mass - self.sum_of_parts), abs(self.onshape_mass - self.sum_of_visible))
            <= tolerance
        )

    @property
    def excess(self) -> tuple[float, float]:
        """Returns theirs less ours [kg]: with hidden occurrences, and without."""
        return self.onshape_mass - self.sum_of_parts, self.onshape_mass - self.sum_of_visible

    def differs_as_before(self, excess: Sequence[float]) -> bool:
        """Tells whether they differ by the same amount as when all replies were known to be current."""
        tolerance = _RELATIVE_TOLERANCE * max(abs(self.onshape_mass), abs(self.sum_of_parts))
        return any(abs(now - then) <= tolerance for now, then in zip(self.excess, excess, strict=True))

    def diagnostic(self, element: str, *, lasting: bool = False) -> Diagnostic:
        """Returns the diagnostic for a difference that remains after fetching everything again.

        `lasting`: the same difference was found at an earlier state of the document.
        """
        state_text = (
            "the difference was the same when every part studio of the document was last fetched"
            if lasting
            else "every part studio of the document was fetched in its present state"
        )
        return Diagnostic(
            "W-VERIFY",
            f"the parts weigh {self.sum_of_parts:.9g} kg together, but Onshape gives the assembly a mass of "
            f"{self.onshape_mass:.9g} kg; {state_text}",
            f"assembly {element}",
            "compare with the mass properties that Onshape shows for the assembly (overridden masses?); "
            "source.refresh=true fetches everything again, source.verify=false skips the comparison",
        )


def unchecked(element: str, error: SourceError) -> Diagnostic:
    """Returns the diagnostic for an assembly whose mass cannot be fetched."""
    return Diagnostic(
        "W-VERIFY",
        f"the masses could not be compared, so a cached part studio may be outdated: {error.message}",
        f"assembly {element}",
        "run the same command again to compare them; source.refresh=true fetches everything "
        "again, source.verify=false skips the comparison",
    )


def compare(definition: bytes, weights: Mapping[ElementKey, Mapping[str, float]], total: bytes) -> Masses:
    """Compares the masses of an assembly: `definition` and `total` are replies, `weights` [kg] by part id.

    A part without mass is not counted, as in the server's total.
    """
    total_mass = shown_mass = 0.0
    for studio, part, hidden in _occurrences(orjson.loads(definition)):
        weight = weights.get(studio, {}).get(part, 0.0)
        total_mass += weight
        shown_mass += 0.0 if hidden else weight
    return Masses(read_total(total), total_mass, shown_mass)


def read_total(body: bytes) -> float:
    """Returns the mass [kg] in an assembly's mass properties. Raises ProtocolError if it is missing."""
    try:
        return _mass(orjson.loads(body))
    except (orjson.JSONDecodeError, AttributeError, KeyError, IndexError, TypeError, ValueError):
        msg = "the reply with the mass of the assembly has no mass"
        raise ProtocolError(msg, hint=_HINT) from None


def read_weights(body: bytes) -> Mapping[str, float]:
    """Returns part id → mass [kg], from a part studio's mass properties. Raises ProtocolError if a mass is
    unreadable."""
    try:
        return {part: _mass(record) for part, record in orjson.loads(body)["bodies"].items()}
    except (orjson.JSONDecodeError, AttributeError, KeyError, IndexError, TypeError, ValueError):
        msg = "the reply with the mass properties of a part studio has a part without mass properties"
        raise ProtocolError(msg, hint=_HINT) from None


def _mass(record: Mapping[str, Any]) -> float:
    """Returns the nominal mass; 0 if nothing has a material."""
    return float(record["mass"][0]) if record.get("hasMass", True) else 0.0


def _occurrences(data: Mapping[str, Any]) -> Iterator[tuple[ElementKey, str, bool]]:
    """Yields (part studio, part id, hidden) of every part in the assembly, at any depth."""
    root = data["rootAssembly"]
    subs = {ElementKey.of(sub): sub for sub in data.get("subAssemblies") or ()}
    by_id = {
        id(assembly_record): {i["id"]: i for i in assembly_record["instances"]}
        for assembly_record in (root, *subs.values())
    }
    for occurrence in root.get("occurrences") or ():
        owner: Mapping[str, Any] | None = root
        instance: Mapping[str, Any] | None = None
        for step in occurrence["path"]:
            instance = by_id[id(owner)].get(step) if owner is not None else None
            if instance is None or instance.get("suppressed"):
                instance = None
                break
            owner = subs.get(ElementKey.of(instance)) if instance.get("type") == "Assembly" else None
        if instance is not None and instance.get("type") == "Part":
            yield ElementKey.of(instance), instance["partId"], bool(occurrence.get("hidden"))
