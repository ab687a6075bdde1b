"""Reads the date for a USD's metadata from the environment."""

from collections.abc import Mapping
from datetime import UTC, datetime
from typing import TYPE_CHECKING, TypeVar

from linkwright.stages.robot.errors import ConfigError

if TYPE_CHECKING:
    from linkwright.stages.export.section import ExportSections

Keys = TypeVar("Keys", bound="ExportSections")

DATE_VARIABLE = "SOURCE_DATE_EPOCH"
"""Environment variable with the seconds since 1970, as reproducible-builds.org defines it."""


def with_date(keys: Keys, environ: Mapping[str, str]) -> Keys:
    """Returns the keys with the day (UTC) of SOURCE_DATE_EPOCH as `export.usd.date`, if a USD is written and
    this key is not set. Raises ConfigError if the variable is not a number of seconds."""
    usd = keys.export.usd
    if usd is None or usd.date is not None or DATE_VARIABLE not in environ:
        return keys
    text = environ[DATE_VARIABLE]
    try:
        day = datetime.fromtimestamp(int(text), UTC).strftime("%Y-%m-%d")
    except (ValueError, OverflowError, OSError):
        msg = f"{DATE_VARIABLE} is not a number of seconds since 1970: {text!r}"
        raise ConfigError(
            msg, "export.usd.date", "set it to such a number, unset it, or give export.usd.date"
        ) from None
    export = keys.export.model_copy(update={"usd": usd.model_copy(update={"date": day})})
    return keys.model_copy(update={"export": export})
