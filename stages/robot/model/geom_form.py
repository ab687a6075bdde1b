"""How a geom is in an MJCF, beside its shape and place: its name, and its properties in contact."""

from dataclasses import dataclass, fields


@dataclass(frozen=True, slots=True)
class ContactProperties:
    """MuJoCo's properties of a geom in contact, in its own words and units; None for its default. Those from
    `solmix` on are an MJCF source's alone."""

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
        """Those that are not left at their default, by name."""
        values = {one.name: getattr(self, one.name) for one in fields(self)}
        return {name: value for name, value in values.items() if value is not None}


@dataclass(frozen=True, slots=True)
class GeomForm:
    """How an MJCF source has a geom, beside its shape and place. `ellipsoid`: of one, its lengths along x, y
    and z [m]; to all else it is a mesh. `attributes`: what no other format has, as MJCF's text."""

    name: str = ""
    contact: ContactProperties | None = None
    attributes: tuple[tuple[str, str], ...] = ()
    ellipsoid: tuple[float, ...] = ()


PLAIN = GeomForm()
"""A geom without a name, of MuJoCo's defaults."""
