"""Configuration of the objective: what a search minimizes or maximizes."""

import math
import re
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, ConfigDict, Field, Strict, model_validator

from linkwright.pipeline.config.messages import nearest
from linkwright.stages.robot.section import Section, Text, example, invalid

FIGURES = ("mass", "reach", "torque_margin", "checks_failed")
"""The named figures; other figures are paths in robot.json."""

_FIGURE_PATTERN = re.compile(rf"({'|'.join(FIGURES)}|reach\.[^.]+|[^.]+(\.[^.]+)+)")


def _check_number(value: float) -> float:
    if math.isnan(value):
        raise invalid("must be a number; .inf is allowed, .nan is not")
    return value


def _check_figure(name: str) -> str:
    if not _FIGURE_PATTERN.fullmatch(name):
        suggestion = nearest(name, FIGURES)
        text = f"must be one of {', '.join(FIGURES)}, reach.FRAME, or a path in robot.json such as"
        raise invalid(f"{text} links.forearm.mass{f'; {suggestion}' if suggestion else ''}")
    return name


Figure = Annotated[Text, AfterValidator(_check_figure)]

_INFINITIES = {".inf": math.inf, "+.inf": math.inf, "-.inf": -math.inf}
"""YAML's words for infinity, which the command line reads as texts."""


def _as_numbers(value: Any) -> Any:
    """Returns a list with the value, or with its entries; texts for infinity become numbers."""
    words = value if isinstance(value, list | tuple) else [value]
    return [_INFINITIES.get(word, word) if isinstance(word, str) else word for word in words]


FailureValue = Annotated[float, Strict(), Field(allow_inf_nan=True), AfterValidator(_check_number)]
"""A number, which may be infinite."""


class ObjectiveSection(Section):
    """The objective: a number of each robot of a sweep, which a searching sweeper makes small or large."""

    model_config = ConfigDict(ser_json_inf_nan="constants")

    figure: Annotated[Figure | None, example("mass")] = None
    """The figure: `mass` [kg]; `reach` [m], the largest distance of any frame from the root link's origin
    over 256 poses, or `reach.tool` for a single frame; `torque_margin`, the largest share of a joint's force
    that holding the weight takes, at `home` and over 64 poses; `checks_failed`; or the path of a number in
    robot.json, such as `links.forearm.mass`."""

    figures: Annotated[tuple[Figure, ...], example(["mass", "torque_margin"])] = ()
    """Several figures in place of `figure`: a search then needs the same number of directions."""

    target: Annotated[Text | None, Field(alias="_target_"), example("my_cost.cost")] = None
    """Your own function in place of figures, in a module of `plugins`: it is called with the robot
    (`linkwright.Robot`) and `args`, and returns one or several numbers."""

    args: Annotated[dict[Text, Any], example({"payload": 0.5})] = Field(default_factory=dict)
    """Further arguments of the function, after the robot."""

    failed: Annotated[
        tuple[FailureValue, ...],
        BeforeValidator(_as_numbers, json_schema_input_type=float | tuple[float, ...]),
        example([1e6]),
    ] = ()
    """The objective of a robot that cannot be built: a number (also `.inf` or `-.inf`), or a number for each
    figure; by default infinitely bad for the search."""

    @property
    def names(self) -> tuple[str, ...]:
        """The figures; empty where a function takes their place."""
        return self.figures if self.figure is None else (self.figure,)

    @model_validator(mode="after")
    def _check_kind(self) -> Self:
        if sum((self.figure is not None, bool(self.figures), self.target is not None)) != 1:
            raise invalid("must have one of figure, figures and _target_")
        if self.args and self.target is None:
            raise invalid("args belong to a function: give _target_")
        if self.target is None and len(self.failed) not in (0, 1, len(self.names)):
            raise invalid("failed must be one number, or as many as there are figures")
        return self
