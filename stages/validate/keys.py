"""What the validate stage is told: how hard to look."""

import warnings
from typing import Literal

from stages.robot.keys import Keys


class ValidateSection(Keys):
    """Which checks are made."""

    level: Literal["quick", "standard", "strict"] = "standard"
    """quick: the files compile; standard: they are the robot; strict: warnings are errors."""


with warnings.catch_warnings():
    # The section is called as it is in the tree; pydantic's own `validate` is long deprecated.
    warnings.filterwarnings("ignore", message='Field name "validate"')

    class ValidateKeys(Keys):
        """The validate stage's part of the configuration."""

        validate: ValidateSection = ValidateSection()  # type: ignore[assignment]
        """Which checks are made."""
