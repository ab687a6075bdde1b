"""Defines the configuration of the targets: the engines whose limits the files keep."""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, SerializerFunctionWrapHandler, model_serializer, model_validator

from linkwright.stages.robot.section import Count, Section, example, invalid
from linkwright.stages.targets.engines import ENGINES, MujocoVersion

Switch = Literal["enable", "disable"]


class OptionTarget(Section):
    """An engine that reads MuJoCo's `<option>`. An attribute that is null stays as `scene.option` or the
    source sets it, and `scene.option` itself takes precedence."""

    iterations: Annotated[Count | None, example(10)] = None
    """Iterations of the solver in each step, at most."""

    ls_iterations: Annotated[Count | None, example(20)] = None
    """Iterations of the line search in each of these, at most."""

    integrator: Literal["Euler", "RK4", "implicitfast"] | None = None
    """How the engine goes from one step to the next."""

    eulerdamp: Switch | None = None
    """Whether the integrator Euler takes damping implicitly."""

    def options(self) -> dict[str, Any]:
        """Returns the attributes of `<option>` and of `<flag>` that the target sets."""
        values = {name: getattr(self, name) for name in OptionTarget.model_fields}
        return {name: value for name, value in values.items() if value is not None}


class MjxTarget(OptionTarget):
    """MJX. All robots of a batch iterate as long as any of them needs, so MJX's users set few iterations.
    With the default a quadruped on its feet stays within 1e-4 rad of MuJoCo over 100 steps; with 4 and 8
    iterations it deviates by 2e-2. There is no implicit damping by default, which would cost a further
    factorization."""

    iterations: Count | None = 10
    """Iterations of the solver in each step, at most."""

    ls_iterations: Count | None = 20
    """Iterations of the line search in each of these, at most."""

    eulerdamp: Switch | None = "disable"
    """Whether the integrator Euler takes damping implicitly."""


class MjwarpTarget(OptionTarget):
    """MuJoCo Warp."""


def _as_text(version: Any) -> Any:
    """Returns a version as text, although YAML reads it as a number without quotes."""
    return f"{version}" if isinstance(version, float) else version


class MujocoTarget(Section):
    """MuJoCo itself."""

    version: Annotated[MujocoVersion | None, BeforeValidator(_as_text)] = None
    """The version that reads the files, of those that were measured; null: the one that is installed."""


class PlainTarget(Section):
    """An engine without settings."""


class TargetSection(Section):
    """Engines whose limits the files keep; null leaves one out."""

    mjx: MjxTarget | None = None
    """MJX, on a GPU."""

    mjwarp: MjwarpTarget | None = None
    """MuJoCo Warp, with MuJoCo 4.0. mjlab has it with MuJoCo 3.11: add `mujoco: {version: "3.11"}`."""

    mujoco: MujocoTarget | None = None
    """MuJoCo, of a version."""

    newton: PlainTarget | None = None
    """Newton."""

    isaac: PlainTarget | None = None
    """Isaac Sim."""

    gazebo: PlainTarget | None = None
    """Gazebo with DART."""

    pybullet: PlainTarget | None = None
    """PyBullet."""

    drake: PlainTarget | None = None
    """Drake."""

    @property
    def chosen(self) -> tuple[str, ...]:
        """Returns the names of the targets, in the order of the table."""
        return tuple(name for name in ENGINES if getattr(self, name) is not None)

    @property
    def versions(self) -> dict[str, MujocoVersion | None]:
        """Returns each target with its configured version of MuJoCo, or None."""
        version = self.mujoco.version if self.mujoco is not None else None
        return {name: version if name == "mujoco" else None for name in self.chosen}

    @property
    def options_and_flags(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Returns the attributes of MuJoCo's `<option>`, and those of its `<flag>`, that the targets set."""
        attributes = {name: value for _, name, value in self.settings}
        flags = {name: attributes.pop(name) for name in ("eulerdamp",) if name in attributes}
        return attributes, flags

    @property
    def settings(self) -> list[tuple[str, str, Any]]:
        """Returns (target, attribute, value) of each attribute that is set."""
        sections = ((name, getattr(self, name)) for name in self.chosen)
        return [
            (name, attribute, value)
            for name, section in sections
            if isinstance(section, OptionTarget)
            for attribute, value in section.options().items()
        ]

    @model_validator(mode="after")
    def _one_scene(self) -> Self:
        values: dict[str, tuple[str, Any]] = {}
        for name, attribute, value in self.settings:
            first_target, first_value = values.setdefault(attribute, (name, value))
            if first_value != value:
                raise invalid(
                    f"{first_target} has {attribute} {first_value} and {name} has {value}, "
                    f"and both read one scene.xml: give both the same, or build once for each"
                )
        return self

    @model_serializer(mode="wrap")
    def _only_chosen(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        # A new target must change neither the configuration nor the cache key of builds without it.
        return {name: value for name, value in handler(self).items() if name in self.chosen}


class TargetSections(Section):
    """The part of the configuration for stages that keep the limits of engines."""

    target: TargetSection = TargetSection()
    """Engines whose limits the files keep: what one lacks is replaced, or refused by name. A key of one
    chooses it."""
