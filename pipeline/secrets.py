"""What must never be written: the API key, blanked in everything that a build leaves behind."""

import contextlib
from collections.abc import Mapping
from typing import Any

from pipeline.errors import ConfigError

SHORTEST = 8
"""Length below which a text is no key: blanking it would take apart words that mean something else."""


class Secrets:
    """The keys in the environment and in `.env`."""

    def __init__(self, environ: Mapping[str, str]) -> None:
        from stages.fetch.credentials import ACCESS, SECRET, find

        found = {environ.get(ACCESS, ""), environ.get(SECRET, "")}
        with contextlib.suppress(ConfigError):
            key = find(environ)
            found |= {key.access, key.secret}
        # The longest first: one may hold another.
        self._found = sorted((one for one in found if len(one) >= SHORTEST), key=lambda one: (-len(one), one))

    def blanked(self, text: str) -> str:
        """The text with every secret in it blanked."""
        for secret in self._found:
            text = text.replace(secret, "***")
        return text

    def within(self, tree: Any) -> Any:
        """Plain data with the secrets in its texts blanked; the keys of mappings stay as they are."""
        if isinstance(tree, str):
            return self.blanked(tree)
        if isinstance(tree, Mapping):
            return {key: self.within(value) for key, value in tree.items()}
        if isinstance(tree, list | tuple):
            return [self.within(value) for value in tree]
        return tree
