"""Lists the 35 points of sim-readiness, which models of the quality of MuJoCo Menagerie meet."""

from collections.abc import Iterator
from dataclasses import dataclass

from linkwright.stages.validate.readiness import bodies, evidence, joints, text
from linkwright.stages.validate.readiness.finished import FinishedRobot, PointJudge


def masses(finished: FinishedRobot) -> Iterator[str]:
    """Judges masses, and the form of inertias in the file."""
    yield from bodies.masses(finished)
    yield from text.inertia_convention(finished)


@dataclass(frozen=True, slots=True)
class Point:
    """A point of sim-readiness."""

    number: int
    title: str
    """The point as a statement."""

    judge: PointJudge


TITLES_AND_JUDGES: tuple[tuple[str, PointJudge], ...] = (
    ("loads from any folder, without a warning", evidence.compiles),
    ("the robot's file is the robot alone; scene.xml adds ground, light and sky", text.the_robot_alone),
    ("radians; all paths are relative, to files that exist", text.paths),
    ("a root default class, and classes for visual geoms and colliders", text.classes),
    ("visual geoms collide with nothing, colliders are in a group of their own", bodies.roles),
    ("each visible body collides", bodies.colliders),
    ("each body has its inertia in the file, and no geom has a mass", text.inertials),
    ("inertias are physically possible", bodies.inertias),
    ("inertia and centre of mass fit the visual shapes", bodies.extents),
    ("masses are those of the source", evidence.same_mass),
    ("no body too light for its neighbour; one convention for inertias", masses),
    ("every body moves", bodies.moving),
    ("every frame exists by name", bodies.frames),
    ("joints have their limits, and home is within", joints.limits),
    ("driven joints have armature, damping and a single bound of their force", joints.drives),
    ("as many actuators as independent joints, within their ranges", joints.controls),
    ("names in letters, digits and underscores, unique over kinds", bodies.names),
    ("actuators are named and ordered as their joints", text.order),
    ("a keyframe home with controls", joints.keyframe),
    ("rests at home", evidence.rests),
    ("stays stable under control noise", evidence.noise),
    ("only known contacts at home", evidence.contacts_at_home),
    ("few convex pieces of few vertices", bodies.pieces),
    ("colliders are within their tolerances", evidence.collider_tolerances),
    ("every reader accepts the meshes, and none is there twice", evidence.assets),
    ("colours are shared materials", text.materials),
    ("time step and an implicit integrator are stated", text.option),
    ("a floating base is named and stands on the ground; a fixed base does not float", joints.base_placement),
    ("joints are measured; IMUs and cameras are whole", joints.sensors),
    ("relations and loops are equalities that hold", evidence.closes),
    ("a second engine agrees on motion and masses", evidence.parity),
    ("the formats describe one robot", evidence.formats),
    ("numbers have no noise, and no negative zeros", text.numbers),
    ("survives MuJoCo's own writer", evidence.round_trip),
    ("says where its parameters come from, with README and license", evidence.provenance),
)

POINTS = tuple(Point(number, *row) for number, row in enumerate(TITLES_AND_JUDGES, start=1))
