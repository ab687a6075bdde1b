"""A machine of many like modules to measure with: 30 parts, 6 joints, a loop and a relation each."""

import json
import math
from dataclasses import replace
from hashlib import sha256

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn
from tests.support.building import bundle_of

PARTS = 30
"""The number of parts of each module."""

_SIDE = turn((1, 0, 0), math.pi / 2)
_HERE = np.eye(4)
_HINGE = frame((0.1, 0, 0)) @ _SIDE


def large(modules):
    """A tree of so many modules, two hung on each: every one is a use of one sub-assembly.

    The author's own kinematics would take minutes: two modules are drawn, and the rest is written like
    the second.
    """
    drawn = bundle_of(_two_modules())
    definition = json.loads(drawn.body(drawn.definition))
    root = definition["rootAssembly"]
    seed, swing = root["instances"][1], root["features"][0]
    of_seed = [occurrence for occurrence in root["occurrences"] if occurrence["path"][0] == seed["id"]]
    first = root["instances"][0]["id"]
    ids = [first, *(f"Module{number:05d}" for number in range(1, modules))]
    depths = [0]
    for number in range(1, modules):
        depths.append(depths[(number - 1) // 2] + 1)
        above = ids[(number - 1) // 2]
        root["instances"].append(seed | {"id": ids[number], "name": f"Module <{number + 1}>"})
        root["occurrences"] += [_placed(seed, ids[number], depths[number]) for seed in of_seed]
        root["features"].append(_swing(swing, number, ids[number], above))
    root["instances"].remove(seed)
    root["features"].remove(swing)
    root["occurrences"] = [
        occurrence for occurrence in root["occurrences"] if occurrence["path"][0] != seed["id"]
    ]
    body = json.dumps(definition).encode()
    name = sha256(body).hexdigest()
    return replace(drawn, definition=name, blobs={**drawn.blobs, name: body})


def _placed(occurrence, ident, depth):
    """The seed's occurrence, which is one hinge away from the origin, in the module `ident`."""
    transform = np.reshape(occurrence["transform"], (4, 4)).copy()
    transform[:3, 3] += (depth - 1) * _HINGE[:3, 3]
    return occurrence | {"path": [ident, *occurrence["path"][1:]], "transform": transform.ravel().tolist()}


def _swing(mate, number, ident, above):
    data = mate["featureData"]
    entities = [
        entity | {"matedOccurrence": [module, *entity["matedOccurrence"][1:]]}
        for entity, module in zip(data["matedEntities"], (ident, above), strict=True)
    ]
    return mate | {
        "id": f"Swing{number:05d}",
        "featureData": data | {"name": f"Swing {number}", "matedEntities": entities},
    }


def _two_modules():
    """A module: a plate; a motor that swings a crank, a coupler and a rocker that close a loop; a motor
    whose pinion moves a carriage; patterned screws on all of these; a sub-assembly inside, the motor."""
    document = Document("Large")
    studio = document.studio("Parts")
    thing = studio.part("Thing", solids.box(0.02, 0.01, 0.01), density=2700)
    screw = studio.part("Screw", solids.box(0.002, 0.002, 0.006), density=7800)
    root = document.assembly("Machine")
    motor = document.assembly("Motor")
    stator, rotor = motor.add(thing, name="Stator"), motor.add(thing, name="Rotor")
    turning = motor.revolute("Turn", (rotor, _HERE), (stator, frame((0, 0, 0.02))), 0.3, (-1.5, 1.5))
    _screwed(motor, "Motor screw", screw, stator, copies=3)

    module = document.assembly("Module")
    plate = module.add(thing, name="Plate")
    _screwed(module, "Plate screw", screw, plate, copies=3)
    swinging, driving = module.add(motor), module.add(motor)
    for number, used in enumerate((swinging, driving)):
        seat = frame((0.1 * number, 0, 0.01))
        module.fasten(f"Motor seat {number}", (used / stator, _HERE), (plate, seat))
    crank, coupler, rocker = (module.add(thing, name=name) for name in ("Crank", "Coupler", "Rocker"))
    module.fasten("Crank seat", (crank, _HERE), (swinging / rotor, _HERE))
    _screwed(module, "Crank screw", screw, crank, copies=4)
    # A parallelogram: the coupler stays level, and the rocker turns as the crank does.
    tip = frame((0.05, 0, 0))
    module.revolute("Knee", (coupler, _HERE), (crank, tip), value=-0.3)
    module.revolute("Ankle", (rocker, tip), (coupler, frame((0.08, 0, 0))), value=0.3)
    module.revolute("Close", (rocker, _HERE), (plate, frame((0.08, 0, 0.03))), closing=True)
    carriage = module.add(thing, name="Carriage")
    along = frame((0.1, 0.05, 0.03)) @ _SIDE
    rail = module.slider("Rail", (carriage, _SIDE), (plate, along), value=-0.003, limits=(-0.1, 0.1))
    module.rack("Pinion", (driving, turning), rail, 0.02 * math.pi)
    _screwed(module, "Carriage screw", screw, carriage, copies=3)

    base, hung = root.add(module) / plate, root.add(module) / plate
    root.fix(base)
    root.revolute("Swing", (hung, _SIDE), (base, _HINGE), limits=(-1, 1))
    return document


def _screwed(assembly, name, screw, onto, copies):
    """A screw fastened to a part, and a row of copies of it."""
    seed = assembly.add(screw, name=name)
    assembly.fasten(f"{name} seat", (seed, _HERE), (onto, frame((0, 0.005, 0.01))))
    assembly.pattern(f"{name}s", [seed], [frame((0.004 * step, 0, 0)) for step in range(1, copies + 1)])
