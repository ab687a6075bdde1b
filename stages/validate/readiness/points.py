"""The 35 points of sim-readiness, by number: what a model of the grade of MuJoCo Menagerie meets."""

from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.validate.readiness import bodies, evidence, joints, text
from linkwright.stages.validate.readiness.finished import Finished, Judge


def masses(finished: Finished) -> Iterator[str]:
    """Masses, and how the file has the inertias."""
    yield from bodies.masses(finished)
    yield from text.one_convention(finished)


@dataclass(frozen=True, slots=True)
class Point:
    """`title`: what is met, as a statement."""

    number: int
    title: str
    judge: Judge


TITLES_AND_JUDGES: tuple[tuple[str, Judge], ...] = (
    ("loads from any folder, without a warning", evidence.compiles),
    ("the robot's file is the robot alone; scene.xml adds ground, light and sky", text.the_robot_alone),
    ("radians; relative paths of files that are there, and no others", text.paths),
    ("a root default class, and classes for what is seen and what collides", text.classes),
    ("what is seen touches nothing, what collides is in a group of its own", bodies.roles),
    ("each body that is seen collides", bodies.colliders),
    ("each body has its inertia in the file, and no geom weighs", text.inertials),
    ("inertias that bodies can have", bodies.inertias),
    ("inertia and centre of mass fit what is seen", bodies.extents),
    ("masses are those of the source", evidence.same_mass),
    ("no body too light for its neighbour; one convention for inertias", masses),
    ("every body moves", bodies.moving),
    ("every frame is there by name", bodies.frames),
    ("joints have their limits, and home is within", joints.limits),
    ("what is driven has armature, damping and one bound of its force", joints.driven),
    ("as many actuators as independent joints, within their ranges", joints.independent),
    ("names in letters, digits and underscores, unique over kinds", bodies.names),
    ("actuators are named and ordered as their joints", text.order),
    ("a keyframe home with controls", joints.keyframe),
    ("rests at home", evidence.rests),
    ("stays whole under control noise", evidence.noise),
    ("nothing touches at home that is not known", evidence.apart),
    ("few convex pieces of few vertices", bodies.pieces),
    ("colliders are within their tolerances", evidence.near),
    ("meshes that every reader takes, none twice", evidence.assets),
    ("colours are shared materials", text.materials),
    ("time step and an implicit integrator are stated", text.option),
    ("a floating base is named and stands on the ground; a fixed one does not float", joints.stance),
    ("joints are measured; IMUs and cameras are whole", joints.sensors),
    ("relations and loops are equalities that hold", evidence.closes),
    ("a second engine agrees on motion and masses", evidence.parity),
    ("the formats describe one robot", evidence.formats),
    ("numbers without noise; the same bytes again", text.numbers),
    ("survives MuJoCo's own writer", evidence.round_trip),
    ("says where its parameters come from, with README and license", evidence.provenance),
)

POINTS = tuple(Point(number, *one) for number, one in enumerate(TITLES_AND_JUDGES, start=1))
