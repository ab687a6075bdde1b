"""Describes the properties of a geom in an MJCF beside its shape and pose: its name and its contact
properties."""

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True)
class ContactProperties:
    """MuJoCo's contact properties of a geom, with its names and units; None for MuJoCo's default."""

    friction: tuple[float, float, float] | None = None
    condim: int | None = None
    solref: tuple[float, float] | None = None
    solimp: tuple[float, float, float, float, float] | None = None
    margin: float | None = None
    priority: int | None = None
    solmix: float | None = None
    """From here on, only an MJCF source gives values."""
    gap: float | None = None
    contype: int | None = None
    conaffinity: int | None = None

    def given(self) -> dict[str, float | tuple[float, ...]]:
        """Returns the properties that are not left at their default, by name."""
        values = {entry.name: getattr(self, entry.name) for entry in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class GeomForm:
    """The properties of a geom in an MJCF source beside its shape and pose."""

    name: str = ""
    contact: ContactProperties | None = None
    """Its contact properties."""
    attributes: tuple[tuple[str, str], ...] = ()
    """The attributes that no other format has: (name, MJCF's text)."""
    ellipsoid: tuple[float, ...] = ()
    """Lengths of an ellipsoid along x, y and z [m]; other formats have a mesh in its place."""


PLAIN = GeomForm()
"""A geom without a name, of MuJoCo's defaults."""
