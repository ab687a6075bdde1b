"""Defines compiled models, which engines make from files and checks take as their argument."""

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
from linkwright.stages.validate.check_options import DEFAULT_OPTIONS, CheckOptions

LOOKS = frozenset(["rgba", "material", "texture", "color", "default", "class"])
"""Elements and attributes on which colours depend."""

SCENE = "scene.xml"
"""The file that puts the robot into a world."""

FileKind = Literal["mjcf", "urdf", "scene", "simulated"]
"""The kind of a file. simulated: the scene, or the MJCF if there is no scene, which then has both kinds."""


@dataclass(frozen=True, slots=True)
class Loaded:
    """The result of loading a file."""

    model: Any
    """The compiled model; None if the file does not compile."""

    check: Check
    """Whether the file compiles without a warning."""


class Engine(Protocol):
    """A physics engine as a reader of model files."""

    def files(self, robot: str) -> tuple[str, ...]:
        """Returns the names of the files that the engine reads, for a robot of this name."""

    def load(self, path: Path) -> Loaded:
        """Compiles a file in its folder."""

    def warnings(self) -> AbstractContextManager[list[str]]:
        """Collects the engine's warnings while models are used."""


@dataclass(frozen=True, slots=True, eq=False)
class CompiledModel:
    """A compiled model, its file, and the robot that it must match."""

    path: Path
    model: Any
    written: Written
    options: CheckOptions = DEFAULT_OPTIONS
    """The configuration's settings for the checks."""

    @property
    def robot(self) -> Robot:
        """The robot in the form that this file has."""
        return self._view.robot

    @property
    def held(self) -> Holders:
        """Maps each link to the link of this file that holds it, with its pose there."""
        return self._view.held

    @property
    def geometry(self) -> Geometry | None:
        """The shapes of the links, in an MJCF of the links that have bodies; None if they are not known."""
        geometry = self.written.geometry
        return geometry if geometry is None or self.urdf else self.written.mjcf_shapes

    @property
    def _view(self) -> FormatView:
        """The robot in the form of this file's format."""
        return self.written.as_urdf if self.urdf else self.written.as_mjcf

    @property
    def has_keyframes(self) -> bool:
        """Tells whether the robot's keyframes are in this file. They are in the scene if it has other moving
        or driven bodies than the robot's, else in the MJCF."""
        extras = self.robot.mjcf
        return (self.path.name == SCENE) == (extras is not None and extras.moves_in_scene)

    @property
    def surplus(self) -> Surplus:
        """The elements that follow the robot's own in the file: those of the user's own XML, and equalities
        that only an MJCF source has."""
        added = self.written.amendments.surplus_of(self.path.name)
        extras = self.robot.mjcf
        if extras is None or self.urdf:
            return added
        sections = (*extras.sections, *(extras.scene if self.path.name == SCENE else ()))
        ties = sum(1 for _ in children_of(sections, "equality"))
        return replace(added, equalities=added.equalities + ties)

    def sets(self, attribute: str) -> bool:
        """Tells whether the user's own XML sets an attribute of this name, so that it is not compared."""
        return any(attribute in change.sets for change in self.written.amendments.changes)

    def sets_of(self, target: str) -> frozenset[str]:
        """Returns the attributes that the user's own XML sets on an element. `target`: tag and name, such as
        "geom floor"."""
        return frozenset(
            name
            for change in self.written.amendments.changes
            if change.target == target
            for name in change.sets
        )

    @property
    def recolours(self) -> bool:
        """Tells whether the user's own XML changes the robot's look in this file."""
        changes = self.written.amendments.changes_of(self.path.name)
        return any(LOOKS & {*change.sets, *change.added_tags, tag_of(change.target)} for change in changes)

    @property
    def urdf(self) -> bool:
        """Tells whether the file is a URDF."""
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
        """Returns the result of a check of this file."""
        shown = () if passed else tuple(findings)
        return Check(
            f"{self.path.name}: {name}", bool(passed), detail, value, limit, level=level, findings=shown
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
        """Returns the result of a check that passes if `value` is at most `limit`."""
        return self.result(name, value <= limit, detail, value, limit, findings, level)


CheckFunction = Callable[[CompiledModel], Iterable[Check]]
"""A check: it yields results, each with its own name, and nothing for a file that it does not apply to."""


def without_warnings(name: str, warnings: Iterable[str], code: str) -> Check:
    """Returns the result of a check that passes if the engine had no warnings."""
    texts = sorted(set(warnings))
    return Check(name, not texts, "; ".join(texts) or "no warnings", float(len(texts)), 0.0, code)
