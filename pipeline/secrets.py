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
        from stages.fetch.credentials import ACCESS, OLD_TOKEN, SECRET, TOKEN, Credentials, find

        texts = [environ.get(name, "").strip() for name in (ACCESS, SECRET, TOKEN, OLD_TOKEN)]
        keys = [Credentials(texts[0], texts[1]), *(Credentials(token=token) for token in texts[2:])]
        with contextlib.suppress(ConfigError):
            keys.append(find(environ))
        found = {text for key in keys for text in key.private}
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
