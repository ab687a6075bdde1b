"""The records an author makes through `document`: parts, instances, occurrences, features."""

from dataclasses import dataclass, field

import numpy as np

from tests.fake_onshape import ids, settings
from tests.fake_onshape.mates import FREEDOMS, OPEN, bounds
from tests.fake_onshape.solids import Solid

GREY = (200, 205, 210)


@dataclass(eq=False)
class Part:
    """A part: geometry and density [kg/m³] (None: no material), colours as (r, g, b[, a]) 0..255.

    `mass` [kg] overrides the mass; `face_colours` maps names of faces to colours; `connectors` maps
    feature ids to mate connectors in the part's frame. `body`: solid, sheet or composite; a composite
    is made of `members`.
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
    body: str = "solid"
    members: tuple = ()

    def connector(self, name, frame):
        """A mate connector in the part's frame; returns its feature id."""
        feature = ids.node_id(self.studio.element, self.name, "connector", name)
        self.connectors[f"{feature}.{name}"] = np.asarray(frame, float)
        return f"{feature}.{name}"

    @property
    def has_mass(self):
        return self.density is not None or self.mass is not None or any(p.has_mass for p in self.members)

    @property
    def volume(self):
        """[m³]; a sheet has none."""
        return 0.0 if self.body == "sheet" else self.solid.properties.volume

    def inertial(self, overrides=True):
        """Mass [kg], centroid [m] (3,), inertia about it [kg m²] (3, 3); zeros without material."""
        if self.members and self.mass is None:
            return together([member.inertial(overrides) for member in self.members])
        properties = self.solid.properties
        if overrides and self.mass is not None:
            density = self.mass / properties.volume
        elif self.density is not None:
            density = self.density
        else:
            return 0.0, np.zeros(3), np.zeros((3, 3))
        return density * properties.volume, properties.centroid, density * properties.inertia


def together(pieces):
    """(mass, centroid, inertia about it) of several such in one frame."""
    mass = sum(piece[0] for piece in pieces)
    if mass == 0:
        return 0.0, np.zeros(3), np.zeros((3, 3))
    com = sum(m * at for m, at, _ in pieces) / mass
    inertia = np.zeros((3, 3))
    for m, at, own in pieces:
        d = at - com
        inertia += own + m * (d @ d * np.eye(3) - np.outer(d, d))
    return mass, com, inertia


class Studio:
    """A part studio, in one configuration."""

    def __init__(self, home, name, configuration=settings.DEFAULT):
        self.home, self.name, self.configuration = home, name, configuration
        self.element = ids.hex_id(home.name, name, "studio")
        self.parts, self.parameters = [], ()
        self._build, self._variants = None, {}

    def configure(self, parameters, build):
        """Gives it configurations: `build(studio, values)` makes the parts, as it does here and now.

        `values`: parameter id → text. The parts of other configurations have other ids.
        """
        self.parameters, self._build = tuple(parameters), build
        build(self, settings.values(parameters, settings.DEFAULT))
        return self

    def at(self, configuration):
        """The studio in a configuration: Onshape's text for it."""
        values = settings.values(self.parameters, configuration)
        if not self.parameters or configuration in ("", self.configuration):
            return self
        if configuration not in self._variants:
            variant = self._variants[configuration] = Studio(self.home, self.name, configuration)
            variant.parameters = self.parameters
            if self._build is not None:
                self._build(variant, values)
        return self._variants[configuration]

    def sheet(self, name, solid, colour=GREY, mass=None):
        """A sheet body: of a solid, the faces alone."""
        made = self.part(name, solid, None, colour, mass=mass)
        made.body = "sheet"
        return made

    def composite(self, name, members):
        """A composite part of parts of this studio."""
        solid = members[0].solid
        for member in members[1:]:
            solid += member.solid
        made = self.part(name, solid, None, members[0].colour)
        made.body, made.members = "composite", tuple(members)
        return made

    def image(self, part, reflection):
        """The part that is the mirror image of another, by a reflection (4, 4) of this studio."""
        solid = part.solid.reflected(reflection)
        name = f"{part.name} mirrored {sum(candidate.name.startswith(part.name) for candidate in self.parts)}"
        return self.part(name, solid, part.density, part.colour, part.face_colours, part.mass)

    def part(self, name, solid, density=None, colour=GREY, face_colours=None, mass=None, id=None):  # noqa: A002
        """A new part; its id is made from its name unless given."""
        taken = {part.id for part in self.parts}
        seed = () if self.configuration == settings.DEFAULT else (self.configuration,)
        unique = id or ids.deterministic_id(taken, self.element, name, *seed)
        made = Part(self, name, unique, solid, density, colour, dict(face_colours or {}), mass)
        self.parts.append(made)
        return made


class Instance:
    """A use of a part or an assembly inside an assembly.

    `image_from_seed` (4, 4): of a copy made of a mirror-image part, the reflection from the seed's part.
    """

    def __init__(self, owner, source, name, *, fixed, hidden, suppressed, pose, configuration):
        self.owner, self.source, self.name = owner, source, name
        self.id = ids.node_id(owner.element, name)
        self.fixed, self.hidden, self.suppressed = fixed, hidden, suppressed
        self.pose = np.eye(4) if pose is None else np.asarray(pose, float)
        self.configuration, self.mirrored = configuration, False
        self.image_from_seed = np.eye(4)

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
    """A mate feature between two (occurrence, frame) entities; value and limits as `mates` says.

    `closing`: it closes a loop. `redundant`: what it says, another mate says already. `broken`: its
    second entity is lost.
    """

    id: str
    name: str
    type: str
    entities: tuple
    value: object = 0.0
    limits: tuple = OPEN
    closing: bool = False
    suppressed: bool = False
    typed: tuple | None = None
    redundant: bool = False
    broken: bool = False

    @property
    def typed_limits(self):
        """A pair (lower, upper) for each freedom, as expressions: as typed, else made from the numbers."""
        if self.typed is not None:
            return bounds(self.type, self.typed)
        return tuple(
            tuple(None if end is None else f"{float(end)!r} {unit}" for end in pair)
            for pair, unit in zip(bounds(self.type, self.limits), self._units, strict=True)
        )

    @property
    def _units(self):
        return ["m" if freedom.kind == "slide" else "rad" for freedom in FREEDOMS[self.type]]


@dataclass(eq=False)
class Relation:
    """A relation of (owner occurrence, mate)s: q2 = −k·q1, +k·q1 reversed.

    `amount` is k itself for GEAR and LINEAR, and metres in a turn for RACK_AND_PINION and SCREW; a SCREW
    has one mate, whose slide follows its turn. `offset`: what q2 had more than that when it was drawn, which
    is kept; no reply tells it.
    """

    id: str
    name: str
    type: str
    mates: tuple
    amount: float
    reverse: bool
    offset: float = 0.0

    @property
    def by_length(self):
        return self.type in ("RACK_AND_PINION", "SCREW")


@dataclass(eq=False)
class Pattern:
    """Copies of instances: `copies[i][k]` is the seed `seeds[i]` moved by `transforms[k]` (4, 4), in the
    assembly's frame at the saved pose. `type`: LINEAR, CIRCULAR or MIRROR, whose transform reflects."""

    id: str
    name: str
    type: str
    seeds: tuple
    copies: tuple
    transforms: tuple


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
