"""Reads overrides with Hydra's parser."""

import itertools
import re
from collections.abc import Iterable
from typing import Any

from hydra.core.override_parser.types import Glob, QuotedString
from hydra.errors import HydraException

from linkwright.pipeline.config.hydra.loader import parsed
from linkwright.pipeline.config.hydra.node import quote_text
from linkwright.pipeline.config.hydra.words import PARSER_RULES, translate
from linkwright.pipeline.config.overrides import Override
from linkwright.pipeline.config.presets import GROUPS, Presets


class Reading:
    """Reads overrides with Hydra's parser; `presets` has the options of groups."""

    def __init__(self, presets: Presets) -> None:
        self._presets = presets

    def values(self, text: str) -> list[str]:
        """Returns the values of an override, several in a sweep. Raises ValueError, with the problem and
        perhaps a hint, if it cannot be read."""
        try:
            override = parsed(text)
        except HydraException as error:
            text = str(error).splitlines()[0]
            words = translate(text, PARSER_RULES)
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
            all_options = self._presets.options(group)
            options = value.filter(all_options)
            if not options:
                raise ValueError("no option matches", f"options: {', '.join(all_options)}")
            return [option if re.fullmatch(r"[\w/-]+", option) else quote_text(option) for option in options]
        if override.is_interval_sweep():
            return [str(value.start), str(value.end)]
        return list(override.sweep_string_iterator())

    def intervals(self, overrides: Iterable[Override]) -> list[Override]:
        """Returns the overrides that sweep over an interval of numbers."""
        return [
            override
            for override in overrides
            if override.swept and parsed(override.hydra).is_interval_sweep()
        ]

    def data(self, text: str) -> Any:
        """Returns the value of an override that is not swept, as plain data."""
        return _plain(parsed(text).value())

    def typed_keys(self, overrides: Iterable[str], keys: Iterable[str]) -> set[str]:
        """Returns the keys, among `keys`, that the overrides set."""
        set_keys, keys = set(), list(keys)
        for override in map(parsed, overrides):
            value = None if override.is_delete() else override.value()
            for key in keys:
                rest = key.removeprefix(override.key_or_group)
                is_in_value = isinstance(value, dict) and rest[:1] == "." and rest[1:] in value
                if not override.is_delete() and (not rest or is_in_value):
                    set_keys.add(key)
        return set_keys

    def addresses(self, overrides: Iterable[Override]) -> set[str]:
        """Returns all values of `source.url` in the overrides, also in a sweep."""
        addresses: set[str] = set()
        for override in map(parsed, [override.hydra for override in overrides]):
            key = override.key_or_group
            if override.is_delete() or key not in ("source", "source.url"):
                continue
            swept = override.is_sweep_override()
            texts = override.sweep_string_iterator() if swept else [override.get_value_element_as_str()]
            for value in [self.data(f"++{key}={text}") for text in texts]:
                address = value.get("url") if isinstance(value, dict) else value
                addresses |= {address} if isinstance(address, str) else set()
        return addresses

    def jobs(self, overrides: Iterable[Override]) -> list[list[str]]:
        """Returns the overrides of each job, split and ordered as by Hydra's sweeper: the last override of a
        key wins. Unlike there, `joints.*.damping=1` and `joints.*.friction=2` are both kept, although both
        are overrides of `joints` for Hydra."""
        texts = {
            (override.hydra.partition("=")[0], override.key): override.texts
            for override in overrides
            if not override.for_hydra_itself
        }
        return [list(job) for job in itertools.product(*texts.values())]


def _plain(value: Any) -> Any:
    if isinstance(value, QuotedString):
        return value.text
    if isinstance(value, dict):
        return {str(_plain(key)): _plain(item) for key, item in value.items()}
    return [_plain(item) for item in value] if isinstance(value, list) else value
