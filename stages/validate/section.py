"""Defines the configuration of the validate stage: how much is checked."""

import warnings
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from linkwright.stages.robot.section import Positive, Section, Text, example, invalid
from linkwright.stages.targets.section import TargetSections


def _with_target(entry: Mapping[str, Any]) -> Mapping[str, Any]:
    path = entry.get("_target_")
    parts = path.split(".") if isinstance(path, str) else []
    if len(parts) < 2 or not all(part.isidentifier() for part in parts):
        raise invalid("must have a _target_ such as my_checks.light: a module, a dot, and a name in it")
    return entry


class ValidateSection(Section):
    """Checks of the result."""

    level: Literal["quick", "standard", "strict"] = "standard"
    """Which checks run. quick: the files compile; standard: the files also describe the same robot, and
    simulations of it are stable; strict: as standard, but some simulations are longer, the steps per second
    are measured, and a warning counts as a failed check."""

    payload: Annotated[dict[Text, Positive], example({"tool": 0.5})] = Field(default_factory=dict)
    """Masses [kg] that the robot must carry in addition to its own, by the link or frame that carries them:
    for a link at its centre of mass, for a frame at its origin. The check of torques includes them; no file
    has them."""

    checks: Annotated[
        tuple[Annotated[dict[Text, Any], AfterValidator(_with_target)], ...],
        example([{"_target_": "my_checks.light", "most": 2.5}]),
    ] = ()
    """Checks of your own. `_target_` names a function of a module of `plugins`, which is called with the
    compiled model (`linkwright.CompiledModel`) and the other keys and yields checks
    (`linkwright.Check`); or a class, made with the keys and called with the model. Their codes begin
    with `X-`."""

    external: tuple[Literal["simcheck", "mjcf_doctor", "urdf_validator", "simready"], ...] = ()
    """Checkers of other makers that look at the files too; each must be installed. A file takes 2 to 15 s.
    What they say is in the report, and their errors fail the build. simready: the profile Robot-Body 3.0.0,
    of the USD."""


with warnings.catch_warnings():
    # The section has the key's name; pydantic's own method `validate` is deprecated.
    warnings.filterwarnings("ignore", message='Field name "validate"')

    class ValidateSections(TargetSections):
        """The validate stage's part of the configuration."""

        validate: ValidateSection = ValidateSection()  # type: ignore[assignment]
        """Checks of the result."""
