"""A model file as an engine compiled it: what an engine returns, and what a check works with."""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from stages.robot.actuation import NONE, Actuation
from stages.robot.amendments import UNCHANGED, Amendments, Surplus, tag_of
from stages.robot.check import Check, CheckLevel, Finding
from stages.robot.fusing import Holders
from stages.robot.geometry import Geometry
from stages.robot.mjcf_extras import children_of
from stages.robot.model import Robot
from stages.robot.scene import Scene
from stages.robot.sensing import NOTHING, Sensing
from stages.validate.asked import AS_STANDARD, Asked

LOOKS = frozenset(["rgba", "material", "texture", "color", "default", "class"])
"""Elements and attributes on which colours depend."""

SCENE = "scene.xml"
"""The file that puts the robot into a world."""

FileKind = Literal["mjcf", "urdf", "scene", "simulated"]
"""What a file is to a check. simulated: the scene, or the MJCF where there is no scene; it is that too."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """`model`: the compiled model; None where the file does not compile. `check`: whether it compiles
    without a warning."""

    model: Any
    check: Check


class Engine(Protocol):
    """A physics engine as a reader of model files."""

    def files(self, robot: str) -> tuple[str, ...]:
        """The names of the files that it reads, for a robot of this name."""

    def load(self, path: Path) -> Loaded:
        """Compiles one file from where it lies."""

    def warnings(self) -> AbstractContextManager[list[str]]:
        """Collects what the engine warns of while models are used."""


@dataclass(frozen=True, slots=True, eq=False)
class CompiledModel:
    """A compiled model, the file that it was compiled from, and the robot, with what drives it and its shapes
    (None where nothing is known of them) and what measures it, that it must agree with. `closed`: the robot's
    loops that a URDF closes by its relations; `held`: the bodies of an MJCF that have links, and where;
    `amendments`: what the user's own XML changed in the files; `asked`: what the configuration asks of the
    checks; `scene`: where the files put the robot, None where nothing is known of that."""

    path: Path
    model: Any
    robot: Robot
    actuation: Actuation = NONE
    geometry: Geometry | None = None
    closed: tuple[str, ...] = ()
    sensing: Sensing = NOTHING
    held: Holders = field(default_factory=dict)
    amendments: Amendments = UNCHANGED
    asked: Asked = AS_STANDARD
    scene: Scene | None = None

    @property
    def has_keyframes(self) -> bool:
        """Whether the robot's keyframes are in this file: in the scene where something beside the robot moves
        or is driven there, else in the MJCF."""
        extras = self.robot.mjcf
        return (self.path.name == SCENE) == (extras is not None and extras.moves_in_scene)

    @property
    def surplus(self) -> Surplus:
        """What the file has more than the robot, after what is the robot's own: by the user's own XML, and
        equalities that only an MJCF source has."""
        added = self.amendments.surplus_of(self.path.name)
        extras = self.robot.mjcf
        if extras is None or self.urdf:
            return added
        sections = (*extras.sections, *(extras.scene if self.path.name == SCENE else ()))
        ties = sum(1 for _ in children_of(sections, "equality"))
        return replace(added, equalities=added.equalities + ties)

    def sets(self, attribute: str) -> bool:
        """Whether the user's own XML sets an attribute of this name: its value is then the user's."""
        return any(attribute in one.sets for one in self.amendments.changes)

    def sets_of(self, target: str) -> frozenset[str]:
        """The attributes that the user's own XML sets of an element, by its tag and name: "geom floor"."""
        return frozenset(name for one in self.amendments.changes if one.target == target for name in one.sets)

    @property
    def recolours(self) -> bool:
        """Whether the user's own XML changes what the robot looks like in this file."""
        changes = self.amendments.of(self.path.name)
        return any(LOOKS & {*one.sets, *one.added_tags, tag_of(one.target)} for one in changes)

    @property
    def urdf(self) -> bool:
        return self.path.suffix == ".urdf"

    def result(
        self,
        name: str,
        passed: bool,
        detail: str,
        value: float | None = None,
        limit: float | None = None,
        findings: Iterable[Finding] = (),
        level: CheckLevel = "error",
    ) -> Check:
        """The result of a check of this file."""
        found = () if passed else tuple(findings)
        return Check(
            f"{self.path.name}: {name}", bool(passed), detail, value, limit, level=level, findings=found
        )

    def within(
        self,
        name: str,
        value: float,
        limit: float,
        detail: str,
        findings: Iterable[Finding] = (),
        level: CheckLevel = "error",
    ) -> Check:
        """The result of a check that passes where `value` is at most `limit`."""
        return self.result(name, value <= limit, detail, value, limit, findings, level)


CheckFunction = Callable[[CompiledModel], Iterable[Check]]
"""A check: its results, each with a name of its own; none where it does not apply to the file."""


def without_warnings(name: str, warnings: Iterable[str], code: str) -> Check:
    """The result of a check that passes where the engine had no warnings."""
    found = sorted(set(warnings))
    return Check(name, not found, "; ".join(found) or "no warnings", float(len(found)), 0.0, code)
