"""Describes the properties of a geom in an MJCF beside its shape and pose: its name, its contact properties
and its other attributes."""

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True)
class ContactProperties:
    """The contact properties of a geom, with MuJoCo's names and units; None for MuJoCo's default.

    Those after `priority` are set only by an MJCF source, and not by the configuration.
    """

    friction: tuple[float, float, float] | None = None
    condim: int | None = None
    solref: tuple[float, float] | None = None
    solimp: tuple[float, float, float, float, float] | None = None
    margin: float | None = None
    priority: int | None = None
    solmix: float | None = None
    gap: float | None = None
    contype: int | None = None
    conaffinity: int | None = None

    def given(self) -> dict[str, float | tuple[float, ...]]:
        """Returns the properties that are not None, by name."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class GeomForm:
    """The properties of a geom in an MJCF source beside its shape and pose."""

    name: str = ""
    contact: ContactProperties | None = None
    """The contact properties; None if all are MuJoCo's defaults."""
    attributes: tuple[tuple[str, str], ...] = ()
    """The attributes that only MJCF has: (name, text)."""
    ellipsoid: tuple[float, ...] = ()
    """Lengths [m] of an ellipsoid along x, y and z, which is a mesh in other formats; () for other shapes."""


PLAIN = GeomForm()
"""The form of a geom without a name and with MuJoCo's defaults."""
