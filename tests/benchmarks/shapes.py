"""Machines of one assembly that go on and on in one direction, to see what grows faster than they do."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from hashlib import sha256
from itertools import pairwise

import numpy as np

from linkwright.stages.robot.bundle import Bundle
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.support.building import bundle_of

Point = tuple[float, float, float]
AXES = {"xAxis": [1.0, 0.0, 0.0], "yAxis": [0.0, 1.0, 0.0], "zAxis": [0.0, 0.0, 1.0]}


@dataclass(slots=True)
class Machine:
    """Parts at points of the assembly, none turned, the first fixed; mates at points; gears."""

    parts: list[Point] = field(default_factory=list)
    features: list[dict] = field(default_factory=list)

    def part(self, x, y=0.0, z=0.0):
        """The number of a new part."""
        self.parts.append((x, y, z))
        return len(self.parts) - 1

    def mate(self, kind, first, second, at):
        """The id of a new mate whose two frames are at one point of the assembly [m]."""
        return self._feature(
            "mate",
            mateType=kind,
            mateLimits={},
            matedEntities=[
                {
                    "matedOccurrence": [f"P{number}"],
                    "matedCS": {**AXES, "origin": np.subtract(at, self.parts[number]).tolist()},
                }
                for number in (first, second)
            ],
        )

    def gear(self, first, second, ratio):
        mates = [{"featureId": mate, "occurrence": []} for mate in (first, second)]
        self._feature(
            "mateRelation", relationType="GEAR", relationRatio=ratio, reverseDirection=False, mates=mates
        )

    def _feature(self, kind, **data):
        ident = f"F{len(self.features)}"
        data = {"name": f"{kind} {len(self.features)}", **data}
        self.features.append({"id": ident, "featureType": kind, "suppressed": False, "featureData": data})
        return ident

    def bundle(self):
        document = Document("Machine")
        block = document.studio("Parts").part("Block", solids.box(0.02, 0.01, 0.01), density=2700)
        document.assembly("Machine").add(block)
        drawn = bundle_of(document)
        definition = json.loads(drawn.body(drawn.definition))
        root = definition["rootAssembly"]
        (instance,), (occurrence,) = root["instances"], root["occurrences"]
        root["instances"] = [
            instance | {"id": f"P{n}", "name": f"Block <{n + 1}>"} for n in range(len(self.parts))
        ]
        root["occurrences"] = [
            occurrence | {"path": [f"P{n}"], "fixed": n == 0, "transform": _pose(at)}
            for n, at in enumerate(self.parts)
        ]
        root["features"] = self.features
        body = json.dumps(definition).encode()
        name = sha256(body).hexdigest()
        return replace(drawn, definition=name, blobs={**drawn.blobs, name: body})


def _pose(at):
    pose = np.eye(4)
    pose[:3, 3] = tuple(at)
    return [float(number) for number in pose.ravel()]


def chain(count):
    """Hinges one after another."""
    machine = Machine([(0.0, 0.0, 0.0)])
    for number in range(count):
        before, after = number, machine.part(0.1 * (number + 1), 0.01 * (number % 3))
        machine.mate("REVOLUTE", after, before, machine.parts[after])
    return machine.bundle()


def star(count):
    """Sliders all on one part."""
    machine = Machine([(0.0, 0.0, 0.0)])
    for number in range(count):
        machine.mate("SLIDER", machine.part(0.1 * number, 0.3), 0, (0.1 * number, 0.0, 0.0))
    return machine.bundle()


def screws(count):
    """Parts fastened in a row: one link."""
    machine = Machine([(0.0, 0.0, 0.0)])
    for number in range(count):
        machine.mate("FASTENED", machine.part(0.1 * (number + 1)), number, (0.1 * number, 0.0, 0.0))
    return machine.bundle()


def ladder(count):
    """Parallelograms one upon another: each loop shares a joint with the one before."""
    machine = Machine([(0.0, 0.0, 0.0)])
    left = right = 0
    for number in range(count):
        feet = [(0.0, 0.1 * number, 0.0), (0.3, 0.1 * number, 0.0)]
        tops = [(0.0, 0.1 * (number + 1), 0.0), (0.3, 0.1 * (number + 1), 0.0)]
        posts = [machine.part(*foot) for foot in feet]
        rung = machine.part(*tops[0])
        for post, foot, top, below in zip(posts, feet, tops, (left, right), strict=True):
            machine.mate("REVOLUTE", post, below, foot)
            machine.mate("REVOLUTE", rung, post, top)
        left = right = rung
    return machine.bundle()


def lattice(count):
    """Posts hinged to each other top to foot, and rungs between them: loops that all hang together."""
    machine = Machine([(0.0, 0.0, 0.0)])
    left = right = 0
    for number in range(count):
        feet = [(0.0, 0.1 * number, 0.0), (0.3, 0.1 * number, 0.0)]
        tops = [(0.0, 0.1 * (number + 1), 0.0), (0.3, 0.1 * (number + 1), 0.0)]
        posts = [machine.part(*foot) for foot in feet]
        rung = machine.part(*tops[0])
        for post, foot, top, below in zip(posts, feet, tops, (left, right), strict=True):
            machine.mate("REVOLUTE", post, below, foot)
            machine.mate("REVOLUTE", rung, post, top)
        left, right = posts
    return machine.bundle()


def gears(count):
    """Wheels in a row, each driven by the one before."""
    machine = Machine([(0.0, 0.0, 0.0)])
    mates = []
    for number in range(count):
        at = (0.1 * number, 0.0, 0.1)
        mates.append(machine.mate("REVOLUTE", machine.part(*at), 0, at))
    for before, after in pairwise(mates):
        machine.gear(before, after, 1.25)
    return machine.bundle()


SHAPES: dict[str, Callable[[int], Bundle]] = {
    "chain": chain,
    "star": star,
    "screws": screws,
    "ladder": ladder,
    "lattice": lattice,
    "gears": gears,
}
