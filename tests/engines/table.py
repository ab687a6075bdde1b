"""Which engines are measured, on which robots, and what is known not to hold."""

from dataclasses import dataclass
from fnmatch import fnmatchcase

ROBOTS = ("sample", "quadruped", "humanoid", "so101", "duck")


@dataclass(frozen=True, slots=True)
class Engine:
    """An engine in an environment of its own. `driver`: its script beside this module; `requirements`: of
    pip; `keys`: overrides of the builds that it is given; `python`: the only version that it has wheels
    for."""

    name: str
    driver: str
    requirements: tuple[str, ...]
    keys: tuple[str, ...] = ()
    robots: tuple[str, ...] = ROBOTS
    python: str = ""


LEARNING = ("sample", "quadruped", "humanoid", "so101")
"""Robots of the engines that compile for minutes."""

ENGINES = (
    *(
        Engine(f"mujoco-{version}", "mujoco", (f"mujoco=={version}.0",))
        for version in ("3.11", "3.16", "3.17", "4.0")
    ),
    # JAX compiles each pair of hulls by itself: of the sample's links with each other, 300.
    Engine(
        "mjx",
        "mjx",
        ("mujoco-mjx==3.17.0", "mujoco==3.17.0", "jax[cpu]"),
        ("target=mjx", "contact.self=none"),
        LEARNING,
    ),
    Engine("mjwarp", "mjwarp", ("mujoco-warp==4.0.0", "mujoco==4.0.0"), ("target=mjwarp",), LEARNING),
    Engine("newton", "newton", ("newton[sim,importers]==1.8.0",), ("target=newton",)),
    Engine("drake", "drake", ("drake==1.51.1",), ("target=drake",)),
    Engine("pybullet", "pybullet", ("pybullet==3.2.7",), ("target=pybullet",), python="3.11"),
    Engine("pinocchio", "pinocchio", ("pin==4.1.0",)),
)


@dataclass(frozen=True, slots=True)
class Lack:
    """Rows that do not hold, by globs, and why."""

    engine: str
    robot: str
    format: str
    thing: str
    why: str

    def of(self, place):
        globs = self.engine, self.robot, self.format, self.thing
        return all(fnmatchcase(given, glob) for given, glob in zip(place, globs, strict=True))


_SATURATED = "implicit integrators damp a servo on as if its force were not at its limit"
_BULLET_MJCF = "it reads no classes of joints and geoms: nothing moves"
_BULLET_SDF = "it knows no relative_to: all links are at the origin; and the base is free"

LACKS = (
    Lack("mujoco-3.*", "*", "scene", "saturated: *", f"{_SATURATED}, before MuJoCo 4.0"),
    Lack("mujoco-3.11", "duck", "urdf", "mass matrix", "it finds principal axes of an inertia to 1e-7 only"),
    Lack("mjx", "*", "scene", "saturated: *", _SATURATED),
    Lack("mjx", "humanoid", "scene", "pushed: *", "single precision, while feet slip from the first step on"),
    Lack("mjwarp", "humanoid", "scene", "saturated: *", "single precision, while joints are fast"),
    Lack("newton", "*", "scene", "saturated: *", f"its MuJoCo is 3.17: {_SATURATED}"),
    Lack("newton", "*", "mjcf", "kinematics", "single precision, from where the joints start"),
    Lack("drake", "sample", "sdf", "loads", "it refuses loops"),
    Lack("pybullet", "*", "mjcf", "masses", _BULLET_MJCF),
    Lack("pybullet", "*", "mjcf", "kinematics", _BULLET_MJCF),
    Lack("pybullet", "*", "mjcf", "motion", _BULLET_MJCF),
    Lack("pybullet", "sample", "sdf", "loads", "it refuses a joint to the world"),
    Lack("pybullet", "so101", "sdf", "loads", "it refuses a joint to the world"),
    Lack("pybullet", "*", "sdf", "kinematics", _BULLET_SDF),
    Lack("pybullet", "*", "sdf", "motion", _BULLET_SDF),
)
"""The first that fits tells why."""
