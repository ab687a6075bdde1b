"""Defines the configuration `variants`: robots that differ a little from the robot, for learning."""

from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, Strict

from linkwright.stages.robot.section import Number, Section, Text, example, invalid

MAX_VARIANTS = 100_000
"""Largest number of variants in a file: their values are kept in memory."""


def _number_or_auto(value: Any) -> Any:
    """Returns the value, or raises a single error if it is no share, instead of an error for each kind of
    share."""
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not (value == "auto" or (is_number and 0 <= value < 1)):
        raise invalid("must be a number from 0, less than 1, or auto")
    return value


Share = Annotated[
    Annotated[Number, Field(ge=0, lt=1)] | Literal["auto"],
    BeforeValidator(_number_or_auto),
]


def _all_auto() -> dict[str, Share]:
    return {"*": "auto"}


def _word_alone(value: Any) -> Any:
    return _all_auto() if value == "auto" else value


Shares = Annotated[
    dict[Text, Share],
    BeforeValidator(_word_alone, json_schema_input_type=dict[Text, Share] | Literal["auto"]),
]


class VariantSection(Section):
    """Variants of the robot for learning: `variants.npz` beside the MJCF, arrays over MuJoCo's fields."""

    n: Annotated[int, Strict(), Field(ge=0, le=MAX_VARIANTS), example(1024)] = 0
    """Number of variants; 0: no variants, and no file."""

    seed: Annotated[int, Strict(), Field(ge=0), example(7)] = 0
    """Seed of the random numbers. Variant i of a seed is the same whatever n is,
    and whatever else varies."""

    ranges: Annotated[Shares, example({"*.mass": 0.05, "joints.*.damping": "auto"})] = Field(
        default_factory=_all_auto
    )
    """Glob on quantities (links.<link>.mass, .com, .inertia, .friction; joints.<joint>.damping, .friction,
    .armature, .stiffness, .effort; actuators.<actuator>.kp, .kv, .gain, .force) → the share of its value by
    which the quantity varies in both directions, uniformly; auto: depending on where the value comes from.
    Later entries win, and quantities that no entry matches do not vary. `ranges: auto` applies to all
    quantities."""
