"""Lists, in one table, what other programs read of our files, and what they do with the rest.

A row says what one version of a reader does with one kind of thing in a format, and how a build for that
reader (a `target`) responds. The table is the source of what a build for a target checks and refuses, of the
report of a build, and of the page `pipeline/reference/formats/READERS.md`.
"""

from collections.abc import Iterator

from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.mujoco_readers import MUJOCO_READERS, POSITION_FOR_PID, SLOWER_AT_LIMIT
from linkwright.stages.targets.row import ReaderRow, measured_rows

_NOV_23, _NOV_27 = "2026-11-23", "2026-11-27"
"""Days of the measurements."""

MUJOCO = "MuJoCo"
"""The name of MuJoCo among the readers."""

_ISAAC_ISSUE = "https://github.com/isaac-sim/IsaacSim/issues/841"
_URDF_FORMAT_PAGE = "https://wiki.ros.org/urdf/XML/model"
_ROS_PAGE = "https://docs.ros.org/en/jazzy/p/sdformat_urdf"
_OBJ_FOR_STL = "refuses the file: a build for it writes meshes as OBJ"
"""What a reader without STL does with a mesh in STL."""

READERS: tuple[ReaderRow, ...] = (
    *measured_rows(
        "Drake",
        "1.51.1",
        "urdf",
        _NOV_23,
        ("colliders in STL", "replaced", _OBJ_FOR_STL),
        ("friction", "stated", "dropped, with a warning"),
        ("effort", "stated", "dropped: without transmissions it has no actuators"),
        ("fixed base", "stated", "the root link is free until it is welded"),
    ),
    *measured_rows(
        "Drake",
        "1.51.1",
        "urdf",
        _NOV_27,
        ("visuals in GLB", "stated", "shown by none of its renderers, with a warning: they show OBJ"),
        ("loops", "stated", "left open, as a URDF has none: close them in the plant"),
        ("relations", "stated", "a plant in continuous time refuses to simulate them: give it a time step"),
    ),
    *measured_rows(
        "Drake",
        "1.51.1",
        "sdf",
        _NOV_23,
        ("colliders in STL", "replaced", _OBJ_FOR_STL),
        ("friction", "stated", "dropped silently"),
        ("loops", "refused", "refuses the file"),
        ("relations", "refused", "dropped silently: it reads them from a URDF"),
    ),
    *measured_rows(
        "Drake",
        "1.51.1",
        "mjcf",
        _NOV_23,
        ("meshes in STL", "replaced", _OBJ_FOR_STL),
        ("friction", "stated", "dropped, with a warning"),
        ("effort", "stated", "dropped, with a warning"),
        ("loops", "refused", "left open, with a warning: it has no equalities of sites"),
        ("relations", "refused", "dropped, with a warning: it reads them from a URDF"),
        ("keyframes", "stated", "dropped, with a warning"),
    ),
    *measured_rows(
        "PyBullet",
        "3.2.7",
        "urdf",
        _NOV_23,
        ("inertia", "stated", "from colliders, unless URDF_USE_INERTIA_FROM_FILE is given"),
        ("relations", "refused", "dropped silently: followers move freely"),
        ("loops", "refused", "left open, as a URDF has none"),
        ("fixed base", "stated", "the root link is free, unless useFixedBase is given"),
        (
            "frames",
            "replaced",
            "gives each frame 1 kg: a build for it sets `export.urdf.frame_inertia: tiny`",
        ),
    ),
    *measured_rows(
        "PyBullet",
        "3.2.7",
        "urdf",
        _NOV_27,
        ("visuals in GLB", "refused", "refuses the file: `mesh.format: obj` or `stl`"),
    ),
    *measured_rows(
        "PyBullet",
        "3.2.7",
        "sdf",
        _NOV_23,
        ("fixed base", "refused", "refuses the file: it does not know joints to the world"),
        ("balls", "refused", "refuses the file"),
    ),
    *measured_rows(
        "PyBullet",
        "3.2.7",
        "sdf",
        _NOV_27,
        ("everything", "refused", "puts every link at the origin: it does not know `relative_to`"),
    ),
    *measured_rows(
        "PyBullet",
        "3.2.7",
        "mjcf",
        _NOV_23,
        ("everything", "refused", "nothing moves: it reads no classes of joints and geoms"),
    ),
    *MUJOCO_READERS,
    *measured_rows(
        "Pinocchio",
        "4.1.0",
        "urdf",
        _NOV_23,
        (
            "relations",
            "stated",
            "followers move freely, unless mimic=True is given, which refuses continuous joints",
        ),
    ),
    *measured_rows(
        "Pinocchio",
        "4.1.0",
        "urdf",
        _NOV_27,
        ("loops", "stated", "left open, as a URDF has none: robot.json has them for its constraints"),
        ("visuals in GLB", "stated", "shown without their colours"),
    ),
    ReaderRow(
        "RViz 2",
        "from 15.1.4",
        "urdf",
        "visuals in GLB",
        "turned from y-up to z-up: `mesh.glb_up: y`",
        "stated",
        source="https://github.com/ros2/rviz/pull/1482",
    ),
    *measured_rows(
        "sdformat",
        "12.3",
        "sdf",
        _NOV_23,
        ("relations", "stated", "it does not know `<mimic>`, nor does Gazebo Fortress"),
    ),
    ReaderRow(
        "Gazebo with DART",
        "Harmonic",
        "sdf",
        "relations",
        "dropped, with an error; the engine bullet-featherstone has them",
        "refused",
        source="https://github.com/gazebosim/gz-physics/issues/432",
    ),
    ReaderRow(
        "Gazebo with DART",
        "all so far",
        "sdf",
        "loops",
        "only those that a fixed joint closes",
        "refused",
        source="https://github.com/gazebosim/gz-physics/issues/25",
    ),
    ReaderRow("ROS (sdformat_urdf)", "Jazzy", "sdf", "loops", "refuses the file", "stated", source=_ROS_PAGE),
    ReaderRow("ROS (sdformat_urdf)", "Jazzy", "sdf", "balls", "refuses the file", "stated", source=_ROS_PAGE),
    *measured_rows(
        "Newton",
        "1.8.0",
        "mjcf",
        _NOV_27,
        ("starts of joints", "stated", "values of joints count from `ref`, but controls do not"),
        ("keyframes", "stated", "dropped: it starts at zero"),
        ("sensors", "stated", "dropped silently"),
        ("cameras", "stated", "dropped silently"),
        ("gravity", "stated", "dropped: gravity is an argument of ModelBuilder"),
        ("noslip iterations", "stated", "dropped silently"),
        (
            "pid servos",
            "replaced",
            f"dropped silently: {POSITION_FOR_PID}",
        ),
        ("orientation servos", "refused", "dropped silently"),
        ("adhesion", "refused", "dropped silently"),
        ("pneumatic cylinders", "refused", "dropped silently"),
        ("delays of actuators", "refused", "dropped silently: controls act at once"),
        (
            "time constants of servos",
            "refused",
            "dropped silently: it has those of a `general` actuator with `dyntype` filterexact",
        ),
        ("cones", "refused", "dropped silently: its ball joints have no limits"),
        ("spring-dampers", "refused", "dropped silently: it has `stiffness` and `damping`"),
        ("polynomials of damping", "refused", "refuses the file"),
        ("saturated servos", "stated", SLOWER_AT_LIMIT),
    ),
    *measured_rows(
        "Newton",
        "1.8.0",
        "urdf",
        _NOV_27,
        ("loops", "stated", "left open, as a URDF has none: it reads them from an MJCF or a USD"),
        ("velocity", "stated", "kept in its model; its MuJoCo solver does not limit velocities"),
    ),
    *measured_rows(
        "Newton",
        "1.8.0",
        "usd",
        _NOV_23,
        ("keyframes", "stated", "starts at zero, unless SchemaResolverPhysx is given"),
        ("cones", "stated", "dropped silently"),
    ),
    *measured_rows(
        "PhysX",
        "ovphysx 0.7.0",
        "usd",
        _NOV_23,
        ("loops", "refused", "pushed at the start, or lost (NaN)"),
    ),
    ReaderRow("Isaac Sim", "6.1.0", "urdf", "damping", "dropped silently", "stated", source=_ISAAC_ISSUE),
    ReaderRow(
        "Isaac Sim",
        "6.1.0",
        "urdf",
        "loops",
        "left open, as a URDF has none: it reads them from a USD",
        "stated",
        source=_URDF_FORMAT_PAGE,
    ),
    ReaderRow("Isaac Sim", "6.1.0", "urdf", "friction", "dropped silently", "stated", source=_ISAAC_ISSUE),
)
"""All rows, in the order of the page."""

COMPLETE_READERS: tuple[tuple[str, str, str], ...] = (
    ("yourdfpy", "0.0.60", "urdf"),
    ("Pinocchio", "4.1.0", "urdf"),
)
"""(reader, version, format): readers that keep limits, effort, velocity, damping, friction and mimic, as
measured. Pinocchio reads mimic only with mimic=True."""


def rows_of(target: str, file_format: str, version: str | None = None) -> Iterator[ReaderRow]:
    """Yields the rows of a target's readers for a format. If MuJoCo compiles the engine's models, these are
    the engine's rows for the format and for MJCF, then MuJoCo's rows for the format about other things.
    `version`: the version of MuJoCo; None for the engine's own."""
    engine = ENGINES[target]
    if engine.mujoco is None:
        yield from (row for row in READERS if row.reader in engine.readers and row.format == file_format)
        return
    # Such an engine sees any format as the MJCF that MuJoCo compiles from it.
    engine_rows = [
        row
        for row in READERS
        if row.reader in engine.readers and row.reader != MUJOCO and row.format in (file_format, "mjcf")
    ]
    yield from engine_rows
    engine_things = {row.thing for row in engine_rows}
    for row in READERS:
        is_mujoco = row.reader == MUJOCO and row.version == (version or engine.mujoco)
        if is_mujoco and row.format == file_format and row.thing not in engine_things:
            yield row
