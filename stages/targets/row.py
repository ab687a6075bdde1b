"""Defines a row of the table of readers."""

from dataclasses import dataclass
from typing import Literal

Response = Literal["replaced", "refused", "stated"]
"""How a build for a reader responds. replaced: its files have something else, which `does` names; refused:
the check of the target fails, and names each thing; stated: the reader leaves the thing out, and the report
says so."""

Thing = Literal[
    # Of a robot, whatever the format.
    "balls",
    "colliders in STL",
    "cones",
    "damping",
    "effort",
    "everything",
    "fixed base",
    "frames",
    "friction",
    "inertia",
    "keyframes",
    "loops",
    "meshes in STL",
    "relations",
    "saturated servos",
    "starts of joints",
    "velocity",
    "visuals in GLB",
    # Of a model that MuJoCo compiles.
    "adhesion and slider-cranks",
    "contact sensors of sites, bodies and net forces",
    "cylinders",
    "delays of actuators",
    "dense Jacobian of more than 60 speeds",
    "disabled midphase or autoreset",
    "ellipsoids",
    "fluid with implicitfast",
    "flag energy",
    "flag fwdinv",
    "flag ipc",
    "flags of the solver",
    "flexes",
    "frictionless contacts in elliptic cones",
    "height fields",
    "hulls of more than 32 vertices",
    "implicit integrator",
    "many pairs of convex shapes",
    "margins of meshes",
    "motors by voltage",
    "noslip iterations",
    "noslip iterations of the discrete integrator",
    "orientation servos",
    "pid servos",
    "plug-ins",
    "sensors of distances, limits and energies",
    "rigid, quadratic and self-colliding flexes",
    "signed distance fields",
    "sleep of another solver than Newton",
    "sleep policies",
    "solver PGS",
    "user actuators",
    # Of the text of a file.
    "adhesion",
    "cameras",
    "gravity",
    "pneumatic cylinders",
    "polynomials of damping",
    "sensors",
    "spring-dampers",
    "time constants of servos",
    "words of MuJoCo 3.16",
    "words of MuJoCo 3.17",
    "words of MuJoCo 4.0",
    "words that MuJoCo 4.0 no longer has",
]
"""The things of a robot that some reader drops, refuses or treats in its own way."""

_PAGE_KINDS = {"/issues/": "issues", "/blob/": "source", "/pull/": "source"}
"""Part of an address → the kind of page there."""


@dataclass(frozen=True, slots=True)
class ReaderRow:
    """The behaviour of a version of a reader for a thing in a format."""

    reader: str
    version: str
    format: str
    thing: Thing

    does: str
    """What the reader does with the thing, in words."""

    response: Response
    """How a build for the reader responds."""

    measured: str = ""
    """The day of the measurement, as year-month-day; "" if the behaviour was read in a source."""

    source: str = ""
    """The address of the page that states the behaviour; "" if it was measured."""

    @property
    def evidence(self) -> str:
        """Returns how the behaviour is known, in words."""
        if self.measured:
            return f"measured {self.measured}"
        page = next((kind for part, kind in _PAGE_KINDS.items() if part in self.source), "documentation")
        return f"read in its {page}"


def measured_rows(
    reader: str, version: str, form: str, day: str, *things: tuple[Thing, Response, str]
) -> tuple[ReaderRow, ...]:
    """Returns rows of one reader and one format that were measured on the same day (year-month-day).
    `things`: (the thing, how a build responds, what the reader does)."""
    return tuple(
        ReaderRow(reader, version, form, thing, does, response, day) for thing, response, does in things
    )
