"""What an author does inside one assembly: instances, mates, relations, groups, patterns and mirrors."""

import numpy as np

from tests.fake_onshape import ids, settings
from tests.fake_onshape.elements import (
    ORIGIN,
    Connector,
    Group,
    Instance,
    Mate,
    Occurrence,
    Pattern,
    Relation,
)
from tests.fake_onshape.frames import inverse, product
from tests.fake_onshape.mates import MIRROR, OPEN, REST


def _mate_of(kind, rest):
    """A method that draws a mate of this kind: `value` and `limits` as `mates` says, in rad and m (None is
    open), `typed`: the limits as the expressions that their author typed; more keys of `elements.Mate`."""

    def add(self, name, first, second, value=rest, limits=OPEN, **more):
        return self._mate(kind, name, first, second, value, limits, **more)

    return add


class Assembly:
    """An assembly: instances and features."""

    def __init__(self, home, name):
        self.home, self.name = home, name
        self.element = ids.hex_id(home.name, name, "assembly")
        self.instances, self.features = [], []
        self.patterns, self.fixes = [], []
        self._ground = None

    def add(
        self, source, *, fixed=False, hidden=False, suppressed=False, pose=None, configuration=None, name=None
    ):
        """A new instance of a part or an assembly; returns its `Occurrence`.

        `pose` (4, 4), in this assembly, places a fixed instance, or one that nothing else places.
        `configuration`: by default the one that the part is of.
        """
        if configuration is None:
            configuration = getattr(getattr(source, "studio", None), "configuration", settings.DEFAULT)
        number = 1 + sum(instance.source is source for instance in self.instances)
        state = {"fixed": fixed, "hidden": hidden, "suppressed": suppressed, "pose": pose}
        title = name or f"{source.name} <{number}>"
        instance = Instance(self, source, title, configuration=configuration, **state)
        if any(other.id == instance.id for other in self.instances):
            msg = f"assembly {self.name!r} has two instances named {instance.name!r}"
            raise ValueError(msg)
        self.instances.append(instance)
        self.home.document.changed()
        return Occurrence([instance])

    def ground(self, occurrence, pose=None):
        """Say which occurrence carries this assembly's own frame, and its pose (4, 4) in it."""
        self._ground = (occurrence, np.eye(4) if pose is None else np.asarray(pose, float))
        self.home.document.changed()

    @property
    def carrier(self):
        """The occurrence that carries this assembly's frame and its pose in it; None if empty."""
        if self._ground is not None:
            return self._ground
        for instance in self.instances:
            if not instance.suppressed and (instance.is_part or instance.source.carrier):
                return Occurrence([instance]), np.eye(4)
        return None

    def fix(self, occurrence):
        """Fixes one occurrence, at any depth, to the world: where it is at the saved pose."""
        self.fixes.append(occurrence)
        self.home.document.changed()

    fasten = _mate_of("FASTENED", 0.0)
    revolute = _mate_of("REVOLUTE", 0.0)
    slider = _mate_of("SLIDER", 0.0)
    cylindrical = _mate_of("CYLINDRICAL", (0.0, 0.0))
    pin_slot = _mate_of("PIN_SLOT", (0.0, 0.0))
    planar = _mate_of("PLANAR", (0.0, 0.0, 0.0))
    parallel = _mate_of("PARALLEL", (0.0, 0.0, 0.0, 0.0))

    def ball(self, name, first, second, value=REST, limits=None, *, typed=None, **more):
        """BALL: `value` a quaternion (w, x, y, z), `limits` the half angle [rad] of a cone, or None."""
        quat = tuple(float(number) for number in np.asarray(value, float) / np.linalg.norm(value))
        typed = None if typed is None else (None, typed)
        return self._mate("BALL", name, first, second, quat, (None, limits), typed=typed, **more)

    def gear(self, name, first, second, ratio=1.0, *, reverse=False, offset=0.0):
        """GEAR: the second (mate, or (owner occurrence, mate)) follows the first, `offset` [rad or m] apart
        where they were drawn so."""
        return self._relation("GEAR", name, (first, second), ratio, reverse, offset)

    def linear(self, name, first, second, ratio=1.0, *, reverse=False, offset=0.0):
        """LINEAR: the slide of the second follows that of the first."""
        return self._relation("LINEAR", name, (first, second), ratio, reverse, offset)

    def rack(self, name, first, second, length, *, reverse=False, offset=0.0):
        """RACK_AND_PINION: a turn of the one is `length` [m] of slide of the other, in either order."""
        return self._relation("RACK_AND_PINION", name, (first, second), length, reverse, offset)

    def screw(self, name, mate, length, *, reverse=False, offset=0.0):
        """SCREW: the slide of a CYLINDRICAL mate follows its turn, by `length` [m] a turn."""
        return self._relation("SCREW", name, (mate,), length, reverse, offset)

    def group(self, name, members):
        """A mate group of (occurrence, pose in the first one's frame)."""
        return self._feature(Group(self._id(name), name, tuple(members)))

    def connector(self, name, occurrence, frame):
        """An explicit mate connector on an occurrence."""
        return self._feature(Connector(self._id(name), name, occurrence, np.asarray(frame, float)))

    def pattern(self, name, seeds, transforms, kind="LINEAR"):
        """Copies of instances of this assembly, each moved by each of `transforms` (4, 4).

        Returns, for each seed, the occurrences of its copies.
        """
        copies = tuple(tuple(self._copy(seed.last, False) for _ in transforms) for seed in seeds)
        self._pattern(name, kind, seeds, copies, transforms)
        return copies

    def mirror(self, name, seeds, plane, parts_at=None):
        """Mirror images of instances of this assembly; `plane` (4, 4): its z is the normal.

        `parts_at`: the images of parts are instances of new parts, made by a mirror at this plane (4, 4) of
        the seeds' part studios. Returns, for each seed, the occurrence of its image.
        """
        copies = tuple((self._image(seed.last, parts_at),) for seed in seeds)
        self._pattern(name, "MIRROR", seeds, copies, (_reflection(plane),))
        return tuple(copy for (copy,) in copies)

    def _image(self, seed, parts_at):
        if parts_at is None or not seed.is_part:
            return self._copy(seed, True)
        reflection = _reflection(parts_at)
        part = seed.source.studio.image(seed.source, reflection)
        made = self.add(part, hidden=seed.hidden, configuration=seed.configuration)
        made.last.mirrored, made.last.image_from_seed = seed.mirrored, reflection
        return made

    def _copy(self, seed, mirrored):
        made = self.add(seed.source, hidden=seed.hidden, configuration=seed.configuration)
        made.last.mirrored = seed.mirrored != mirrored
        return made

    def _pattern(self, name, kind, seeds, copies, transforms):
        moved = tuple(np.asarray(transform, float) for transform in transforms)
        self.patterns.append(Pattern(self._id(name), name, kind, tuple(seeds), copies, moved))
        self.home.document.changed()

    def _relation(self, kind, name, mates, amount, reverse, offset):
        ends = tuple(mate if isinstance(mate, tuple) else (ORIGIN, mate) for mate in mates)
        return self._feature(Relation(self._id(name), name, kind, ends, amount, reverse, offset))

    def _mate(self, kind, name, first, second, value=0.0, limits=OPEN, **more):
        entities = tuple((occurrence, np.asarray(frame, float)) for occurrence, frame in (first, second))
        return self._feature(Mate(self._id(name), name, kind, entities, value, limits, **more))

    def _id(self, name):
        return ids.node_id(self.element, "feature", name)

    def _feature(self, feature):
        if any(other.name == feature.name for other in self.features):
            msg = f"assembly {self.name!r} has two features named {feature.name!r}"
            raise ValueError(msg)
        self.features.append(feature)
        self.home.document.changed()
        return feature


def _reflection(plane):
    """The reflection (4, 4) at the plane at right angles to z of a frame."""
    return product(plane, MIRROR, inverse(plane))
