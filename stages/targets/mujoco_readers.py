"""Lists what MuJoCo, MJX and MuJoCo Warp do not read of our files, or treat in their own way: their rows of
the table of readers."""

from linkwright.stages.targets.row import ReaderRow, measured_rows

_NOV_23, _NOV_27 = "2026-11-23", "2026-11-27"
"""Days of the measurements."""

_MJX_MESH_SOURCE = "https://github.com/google-deepmind/mujoco/blob/3.17.0/mjx/mujoco/mjx/_src/mesh.py"
_MJWARP_README = "https://github.com/google-deepmind/mujoco_warp#mujoco-api-compatibility"

POSITION_FOR_PID = (
    "a build for it has a `position` servo with the same force, where there is neither `ki` nor `slewmax`"
)
"""What a build has in place of pid servos."""

SLOWER_AT_LIMIT = (
    "slower than in MuJoCo 4.0 while at the limit of their force: implicitfast keeps their damping"
)
"""What other versions do with servos at the limit of their force."""

NEWTON_FOR_PGS = "refuses the model: a build for it has Newton, which looks for the same forces"
"""What a build has in place of the solver PGS."""

LEFT_OUT_FLAG = "refuses the model: a build for it leaves it out, which moves nothing"
"""What a build does with flags that only compute more."""

MUJOCO_READERS: tuple[ReaderRow, ...] = (
    *measured_rows(
        "MuJoCo",
        "4.0",
        "urdf",
        _NOV_23,
        ("velocity", "stated", "dropped"),
        ("loops", "stated", "left open, as a URDF has none: it reads them from an MJCF"),
    ),
    *measured_rows(
        "MuJoCo",
        "4.0",
        "urdf",
        _NOV_27,
        (
            "visuals in GLB",
            "stated",
            "dropped: our URDF with such visuals says `discardvisual`, without which the file is refused",
        ),
    ),
    *measured_rows(
        "MuJoCo", "3.11", "urdf", _NOV_23, ("relations", "refused", "dropped: it reads them from an MJCF")
    ),
    *measured_rows(
        "MuJoCo",
        "3.11",
        "mjcf",
        _NOV_27,
        ("words of MuJoCo 3.16", "refused", "refuses the file"),
        ("words of MuJoCo 3.17", "refused", "refuses the file"),
        ("words of MuJoCo 4.0", "refused", "refuses the file"),
        ("saturated servos", "stated", SLOWER_AT_LIMIT),
    ),
    *measured_rows(
        "MuJoCo",
        "3.16",
        "mjcf",
        _NOV_27,
        ("words of MuJoCo 3.17", "refused", "refuses the file"),
        ("words of MuJoCo 4.0", "refused", "refuses the file"),
        ("saturated servos", "stated", SLOWER_AT_LIMIT),
    ),
    *measured_rows(
        "MuJoCo",
        "3.17",
        "mjcf",
        _NOV_27,
        ("words of MuJoCo 4.0", "refused", "refuses the file"),
        ("saturated servos", "stated", SLOWER_AT_LIMIT),
    ),
    *measured_rows(
        "MuJoCo",
        "4.0",
        "mjcf",
        _NOV_27,
        ("words that MuJoCo 4.0 no longer has", "refused", "refuses the file"),
    ),
    *measured_rows(
        "MJX",
        "3.17.0",
        "mjcf",
        _NOV_27,
        (
            "cylinders",
            "replaced",
            "refuses the model where one may meet a mesh or a box: a build for it has prisms of the same "
            "volume, with 16 sides, within 1.3 % of the radius",
        ),
        (
            "ellipsoids",
            "replaced",
            "refuses the model where one may meet a mesh or a box: a build for it has their hulls",
        ),
        ("height fields", "refused", "refuses the model where one may meet a cylinder or an ellipsoid"),
        ("signed distance fields", "refused", "refuses the model where one may meet another shape"),
        ("margins of meshes", "refused", "refuses the model: set `margin: 0` for them in `geoms`"),
        (
            "frictionless contacts in elliptic cones",
            "refused",
            "refuses the model: set `scene.option.cone: pyramidal`, or give the geoms friction",
        ),
        (
            "motors by voltage",
            "replaced",
            "refuses the model: a build for it has a `general` actuator with the same force, where the motor "
            "has no state and no saturation",
        ),
        (
            "pid servos",
            "replaced",
            f"refuses the model: {POSITION_FOR_PID}",
        ),
        ("user actuators", "refused", "refuses the model"),
        ("adhesion and slider-cranks", "refused", "refuses the model"),
        ("orientation servos", "refused", "refuses the model, since it has no servos of ball joints"),
        ("delays of actuators", "refused", "dropped silently: controls act at once"),
        ("implicit integrator", "refused", "refuses the model: set `scene.option.integrator: implicitfast`"),
        ("fluid with implicitfast", "refused", "refuses the model: set `scene.option.integrator: Euler`"),
        (
            "solver PGS",
            "replaced",
            NEWTON_FOR_PGS,
        ),
        ("flag energy", "replaced", LEFT_OUT_FLAG),
        ("flag fwdinv", "replaced", LEFT_OUT_FLAG),
        (
            "flags of the solver",
            "refused",
            "refuses the model if `override`, `diagexact` or `speculative` is enabled: disable it",
        ),
        (
            "contact sensors of sites, bodies and net forces",
            "refused",
            "refuses the model, since it only has those of pairs of geoms",
        ),
        ("sensors of distances, limits and energies", "refused", "refuses the model"),
        ("noslip iterations", "stated", "dropped silently"),
        (
            "many pairs of convex shapes",
            "stated",
            "JAX compiles each pair separately, which takes seconds for a pair and more than 16 GB for "
            "hundreds. With `contact.self: none` only the pairs with the surroundings remain; pairs of "
            "primitives need no such compilation",
        ),
        (
            "saturated servos",
            "stated",
            SLOWER_AT_LIMIT,
        ),
        ("flexes", "refused", "refuses the model"),
    ),
    ReaderRow(
        "MJX",
        "3.17.0",
        "mjcf",
        "hulls of more than 32 vertices",
        "is slow with them, and leaves out corners of faces that have more than 20: a build for it has none",
        "replaced",
        source=_MJX_MESH_SOURCE,
    ),
    *measured_rows(
        "MuJoCo Warp",
        "4.0.0",
        "mjcf",
        _NOV_27,
        (
            "pid servos",
            "replaced",
            f"refuses the model: {POSITION_FOR_PID}",
        ),
        (
            "solver PGS",
            "replaced",
            NEWTON_FOR_PGS,
        ),
        ("flag fwdinv", "replaced", LEFT_OUT_FLAG),
        (
            "flags of the solver",
            "refused",
            "refuses the model if `override`, `diagexact` or `speculative` is enabled: disable it",
        ),
        ("flag ipc", "refused", "refuses the model: disable it"),
        ("disabled midphase or autoreset", "refused", "refuses the model: leave them enabled"),
        (
            "sleep policies",
            "refused",
            "refuses the model with the policies `never`, `allowed` or `init` of a body",
        ),
        (
            "sleep of another solver than Newton",
            "refused",
            "refuses the model: set `scene.option.solver: Newton`, or disable the flag `sleep`",
        ),
        (
            "noslip iterations of the discrete integrator",
            "refused",
            "refuses the model: set `scene.option.noslip_iterations: 0`, or choose another integrator",
        ),
        (
            "dense Jacobian of more than 60 speeds",
            "refused",
            "refuses the model: set `scene.option.jacobian: auto` or `sparse`",
        ),
        ("orientation servos", "refused", "refuses the model, since it has no servos of ball joints"),
        ("rigid, quadratic and self-colliding flexes", "refused", "refuses the model"),
    ),
    ReaderRow(
        "MuJoCo Warp", "4.0.0", "mjcf", "plug-ins", "refuses the model", "refused", source=_MJWARP_README
    ),
)
