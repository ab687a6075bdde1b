"""Secrets that must never be written: the API keys, in any encoding."""

import contextlib
import json
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from linkwright.pipeline.errors import Diagnostic, SecretFound
from linkwright.pipeline.key_path import key_of
from linkwright.stages.fetch.onshape.api.credentials import known

SHORTEST = 8
"""Least length of a secret: a shorter text may occur in ordinary words, which must not be blanked."""

BLANK = "***"

Place = tuple[int | str, ...]


class Secrets:
    """The API keys in the environment and in `.env`: plain, base64 and escaped."""

    def __init__(self, environ: Mapping[str, str], folder: Path | None = None) -> None:
        """`folder` holds `.env`; default: the working folder."""
        found = {text: name for text, name in known(environ, folder).items() if len(text) >= SHORTEST}
        # The longest first: a secret may contain another.
        self._forms = sorted(found, key=lambda text: (-len(text), text))
        # A secret that contains another is found by the shorter secret.
        least = [one for one in self._forms if not any(other in one for other in found if other != one)]
        self._sought = [(text, text.encode(), found[text]) for text in least]

    def blanked(self, text: str) -> str:
        """The text with every secret in it blanked."""
        for secret in self._forms:
            text = text.replace(secret, BLANK)
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

    def __bool__(self) -> bool:
        return bool(self._forms)

    def problems(self, tree: Mapping[str, Any]) -> list[Diagnostic]:
        """One problem for each key of a configuration that holds a secret."""
        return [self._problem(name, self.blanked(key_of(place))) for place, name in self._leaks(tree)]

    def typed(self, arguments: Iterable[str]) -> tuple[list[str], list[Diagnostic]]:
        """The arguments of a command line without secrets, and a problem for each argument with one."""
        clean: list[str] = []
        problems: list[Diagnostic] = []
        for argument in arguments:
            name = self._in(argument)
            if name:
                problems.append(self._problem(name, self.blanked(argument.partition("=")[0])))
            else:
                clean.append(argument)
        return clean, problems

    def check(self, files: Mapping[str, bytes]) -> None:
        """SecretFound for the first of `files`, which are about to be written, that holds a secret."""
        for path, data in files.items():
            name = self._in(path) or next((name for _, raw, name in self._sought if raw in data), "")
            if name:
                text = f"would hold the value of {name}; nothing was written"
                hint = (
                    "remove it from the robot's source (the name of a part, a property, a file), and "
                    "create a new key in Onshape: everyone who can read the source has this key"
                )
                where = self.blanked(f"{path}{self._spot(data)}")
                raise SecretFound(text, where, hint)

    def _problem(self, name: str, where: str) -> Diagnostic:
        text = f"holds the value of {name}, which would be written to files"
        hint = "remove it: the key is read only from the environment or from .env"
        return Diagnostic("E-SECRET", text, where, hint)

    def _in(self, text: str) -> str:
        """The name of the variable whose value is in a text, or ""."""
        return next((name for secret, _, name in self._sought if secret in text), "")

    def _leaks(self, tree: Any, place: Place = ()) -> Iterator[tuple[Place, str]]:
        """The places of secrets in plain data, each with the name of its variable."""
        if isinstance(tree, str):
            name = self._in(tree)
            if name:
                yield place, name
        elif isinstance(tree, Mapping):
            for key, value in tree.items():
                inner = (*place, str(key))
                name = self._in(str(key))
                if name:
                    yield inner, name
                else:
                    yield from self._leaks(value, inner)
        elif isinstance(tree, list | tuple):
            for index, value in enumerate(tree):
                yield from self._leaks(value, (*place, index))

    def _spot(self, data: bytes) -> str:
        """The place of a secret in a file: the key in JSON, else the line; "" where it is in the path."""
        with contextlib.suppress(ValueError, RecursionError):
            place = next((place for place, _ in self._leaks(json.loads(data))), ())
            if place:
                return f", {key_of(place)}"
        for number, line in enumerate(data.splitlines(), 1):
            if any(raw in line for _, raw, _ in self._sought):
                return f", line {number}"
        return ""
