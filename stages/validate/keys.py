"""Configuration of the validate stage: how much is checked."""

import warnings
from typing import Literal

from stages.robot.keys import Keys


class ValidateSection(Keys):
    """Checks of the result."""

    level: Literal["quick", "standard", "strict"] = "standard"
    """Which checks run. quick: the files compile; standard: they also describe the same robot, and a
    simulation of 2 s is stable; strict: as standard, and a warning counts as a failed check."""


with warnings.catch_warnings():
    # The section has the key's name; pydantic's own method `validate` is deprecated.
    warnings.filterwarnings("ignore", message='Field name "validate"')

    class ValidateKeys(Keys):
        """The validate stage's part of the configuration."""

        validate: ValidateSection = ValidateSection()  # type: ignore[assignment]
        """Checks of the result."""
