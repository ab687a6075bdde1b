"""Reads overrides with Hydra's parser."""

import re
from collections.abc import Iterable
from typing import Any

from hydra._internal.core_plugins.basic_sweeper import BasicSweeper
from hydra.core.override_parser.types import Glob, QuotedString
from hydra.errors import HydraException

from linkwright.pipeline.config.hydra.loader import parsed
from linkwright.pipeline.config.hydra.node import hydra_text
from linkwright.pipeline.config.hydra.words import READING, in_words
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.presets import GROUPS, Presets


class Reading:
    """Reads overrides; the options of groups are those of `presets`."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets

    def values(self, text: str) -> list[str]:
        """The values of an override, several in a sweep; ValueError, with the problem and perhaps a hint,
        where it cannot be read."""
        try:
            override = parsed(text)
        except HydraException as error:
            text = str(error).splitlines()[0]
            words = in_words(text, READING)
            raise ValueError(words.text if words else text) from None
        except RecursionError:
            msg = "it is nested too deeply"
            raise ValueError(msg) from None
        if not override.is_sweep_override():
            return [override.get_value_element_as_str()]
        value: Any = override.value()
        if isinstance(value, Glob):
            group = override.key_or_group
            groups = [*GROUPS, *self._presets.own_groups()]
            if group not in groups:
                msg, hint = "glob() chooses among the options of a group", f"groups: {', '.join(groups)}"
                raise ValueError(msg, hint)
            there = self._presets.options(group)
            options = value.filter(there)
            if not options:
                raise ValueError("no option matches", f"options: {', '.join(there)}")
            return [one if re.fullmatch(r"[\w/-]+", one) else hydra_text(one) for one in options]
        if not override.is_discrete_sweep():
            msg = "a sweep needs a list of values"
            raise ValueError(msg)
        return list(override.sweep_string_iterator())

    def data(self, text: str) -> Any:
        """The value of an override that is not swept, as plain data."""
        return _plain(parsed(text).value())

    def given(self, overrides: Iterable[str], keys: Iterable[str]) -> set[str]:
        """Those of the `keys` that the overrides set."""
        found, keys = set(), list(keys)
        for override in map(parsed, overrides):
            value = None if override.is_delete() else override.value()
            for key in keys:
                below = key.removeprefix(override.key_or_group)
                inside = isinstance(value, dict) and below[:1] == "." and below[1:] in value
                if not override.is_delete() and (not below or inside):
                    found.add(key)
        return found

    def addresses(self, overrides: Iterable[Override]) -> set[str]:
        """The addresses that the overrides give as `source.url`, also those of a sweep."""
        found: set[str] = set()
        for override in map(parsed, [one.hydra for one in overrides]):
            key = override.key_or_group
            if override.is_delete() or key not in ("source", "source.url"):
                continue
            swept = override.is_sweep_override()
            texts = override.sweep_string_iterator() if swept else [override.get_value_element_as_str()]
            for value in [self.data(f"++{key}={text}") for text in texts]:
                address = value.get("url") if isinstance(value, dict) else value
                found |= {address} if isinstance(address, str) else set()
        return found

    def jobs(self, overrides: Iterable[Override]) -> list[list[str]]:
        """The overrides of each job, split and ordered as by Hydra's sweeper."""
        wanted = [parsed(override.hydra) for override in overrides if not override.for_hydra_itself]
        return [list(job) for batch in BasicSweeper.split_arguments(wanted, None) for job in batch]


def _plain(value: Any) -> Any:
    if isinstance(value, QuotedString):
        return value.text
    if isinstance(value, dict):
        return {str(_plain(key)): _plain(one) for key, one in value.items()}
    return [_plain(one) for one in value] if isinstance(value, list) else value
