"""A model file as an engine compiled it: what an engine returns, and what a check works with."""

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal, Protocol

from linkwright.stages.formats.written import FormatView, Written
from linkwright.stages.robot.check import Check, CheckLevel, Finding
from linkwright.stages.robot.dynamics.fusing import Holders
from linkwright.stages.robot.model.amendments import Surplus, tag_of
from linkwright.stages.robot.model.geometry import Geometry
from linkwright.stages.robot.model.mjcf_extras import children_of
from linkwright.stages.robot.model.robot import Robot
from linkwright.stages.validate.check_options import AS_STANDARD, Asked

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
    """A compiled model, the file that it was compiled from, and the robot as it is `written`, that it must
    agree with. `asked`: what the configuration asks of the checks."""

    path: Path
    model: Any
    written: Written
    asked: Asked = AS_STANDARD

    @property
    def robot(self) -> Robot:
        """The robot as this file has it."""
        return self._view.robot

    @property
    def held(self) -> Holders:
        """By link: the link of this file that has it, and where."""
        return self._view.held

    @property
    def geometry(self) -> Geometry | None:
        """The shapes, in an MJCF by the links that have bodies; None where nothing is known of them."""
        known = self.written.geometry
        return known if known is None or self.urdf else self.written.mjcf_shapes

    @property
    def _view(self) -> FormatView:
        return self.written.as_urdf if self.urdf else self.written.as_mjcf

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
        added = self.written.amendments.surplus_of(self.path.name)
        extras = self.robot.mjcf
        if extras is None or self.urdf:
            return added
        sections = (*extras.sections, *(extras.scene if self.path.name == SCENE else ()))
        ties = sum(1 for _ in children_of(sections, "equality"))
        return replace(added, equalities=added.equalities + ties)

    def sets(self, attribute: str) -> bool:
        """Whether the user's own XML sets an attribute of this name: its value is then the user's."""
        return any(attribute in one.sets for one in self.written.amendments.changes)

    def sets_of(self, target: str) -> frozenset[str]:
        """The attributes that the user's own XML sets of an element, by its tag and name: "geom floor"."""
        return frozenset(
            name for one in self.written.amendments.changes if one.target == target for name in one.sets
        )

    @property
    def recolours(self) -> bool:
        """Whether the user's own XML changes what the robot looks like in this file."""
        changes = self.written.amendments.of(self.path.name)
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
