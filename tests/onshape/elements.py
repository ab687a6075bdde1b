"""The records an author makes through `document`: parts, instances, occurrences, features."""

from dataclasses import dataclass, field

import numpy as np

from tests.onshape import ids
from tests.onshape.solids import Solid

GREY = (200, 205, 210)
OPEN = (None, None)


@dataclass(eq=False)
class Part:
    """A part: geometry and density [kg/m³] (None: no material), colours as (r, g, b[, a]) 0..255.

    `mass` [kg] overrides the mass; `face_colours` maps names of faces to colours; `connectors` maps
    feature ids to mate connectors in the part's frame.
    """

    studio: "Studio"
    name: str
    id: str
    solid: Solid
    density: float | None
    colour: tuple = GREY
    face_colours: dict = field(default_factory=dict)
    mass: float | None = None
    connectors: dict = field(default_factory=dict)

    def connector(self, name, frame):
        """A mate connector in the part's frame; returns its feature id."""
        feature = ids.node_id(self.studio.element, self.name, "connector", name)
        self.connectors[f"{feature}.{name}"] = np.asarray(frame, float)
        return f"{feature}.{name}"

    @property
    def has_mass(self):
        return self.density is not None or self.mass is not None

    def inertial(self, overrides=True):
        """Mass [kg], centroid [m] (3,), inertia about it [kg m²] (3, 3); zeros without material."""
        properties = self.solid.properties
        if overrides and self.mass is not None:
            density = self.mass / properties.volume
        elif self.density is not None:
            density = self.density
        else:
            return 0.0, np.zeros(3), np.zeros((3, 3))
        return density * properties.volume, properties.centroid, density * properties.inertia


class Studio:
    """A part studio."""

    def __init__(self, home, name):
        self.home, self.name = home, name
        self.element = ids.hex_id(home.name, name, "studio")
        self.parts = []

    def part(self, name, solid, density=None, colour=GREY, face_colours=None, mass=None, id=None):  # noqa: A002
        """A new part; its id is made from its name unless given."""
        taken = {part.id for part in self.parts}
        unique = id or ids.deterministic_id(taken, self.element, name)
        made = Part(self, name, unique, solid, density, colour, dict(face_colours or {}), mass)
        self.parts.append(made)
        return made


class Instance:
    """One use of a part or an assembly inside an assembly."""

    def __init__(self, owner, source, name, *, fixed, hidden, suppressed, pose, configuration):
        self.owner, self.source, self.name = owner, source, name
        self.id = ids.node_id(owner.element, name)
        self.fixed, self.hidden, self.suppressed = fixed, hidden, suppressed
        self.pose = np.eye(4) if pose is None else np.asarray(pose, float)
        self.configuration = configuration

    @property
    def is_part(self):
        return isinstance(self.source, Part)


class Occurrence:
    """A path of instances, relative to the assembly whose method it is given to: `arm / hand`."""

    def __init__(self, instances=()):
        self.instances = tuple(instances)

    def __truediv__(self, other):
        return Occurrence(self.instances + other.instances)

    @property
    def path(self):
        """The instance ids."""
        return tuple(instance.id for instance in self.instances)

    @property
    def last(self):
        return self.instances[-1]


ORIGIN = Occurrence()


@dataclass(eq=False)
class Mate:
    """A mate feature: FASTENED, REVOLUTE or SLIDER between two (occurrence, frame) entities."""

    id: str
    name: str
    type: str
    entities: tuple
    value: float = 0.0
    limits: tuple = OPEN
    closing: bool = False
    suppressed: bool = False


@dataclass(eq=False)
class Gear:
    """A gear relation between two (owner occurrence, mate): q2 = −ratio·q1, +ratio·q1 reversed."""

    id: str
    name: str
    mates: tuple
    ratio: float
    reverse: bool


@dataclass(eq=False)
class Group:
    """A mate group: occurrences that keep their poses, given relative to the first one's."""

    id: str
    name: str
    members: tuple


@dataclass(eq=False)
class Connector:
    """A mate connector owned by the assembly: a frame on an occurrence."""

    id: str
    name: str
    occurrence: Occurrence
    frame: np.ndarray
