"""Configuration of the validate stage: how much is checked."""

import warnings
from typing import Literal

from stages.robot.keys import Keys


class ValidateSection(Keys):
    """Which checks are made."""

    level: Literal["quick", "standard", "strict"] = "standard"
    """quick: the files compile; standard: they agree with the robot; strict: warnings are errors too."""


with warnings.catch_warnings():
    # The section has the key's name; pydantic's own method `validate` is deprecated.
    warnings.filterwarnings("ignore", message='Field name "validate"')

    class ValidateKeys(Keys):
        """The validate stage's part of the configuration."""

        validate: ValidateSection = ValidateSection()  # type: ignore[assignment]
        """Which checks are made."""
