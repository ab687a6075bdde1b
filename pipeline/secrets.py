"""Finds and blanks secrets that must never be written: the API keys, in any encoding."""

import contextlib
import json
import os
from collections.abc import Iterable, Iterator, Mapping, MutableMapping
from pathlib import Path
from typing import Any

from linkwright.pipeline.errors import Diagnostic, SecretFound
from linkwright.pipeline.key_path import key_of
from linkwright.stages.fetch.onshape.api.credentials import PRIVATE, known_secrets

MIN_LENGTH = 8
"""Least length of a secret: a shorter text may be a part of ordinary words, which must not be blanked."""

REPLACEMENT = "***"

Place = tuple[int | str, ...]

_WITHHELD: dict[str, str] = {}
"""The API keys that are removed from the environment at present, so that no other process gets them."""


class Secrets:
    """The API keys in the environment and in `.env`: plain, base64 and escaped."""

    def __init__(self, environ: Mapping[str, str], folder: Path | None = None) -> None:
        """Reads the keys; `folder` contains `.env`, by default the working folder."""
        # No other variable is read: a build that read it would run again after its change.
        variables = {name: environ.get(name) or _WITHHELD.get(name, "") for name in PRIVATE}
        secrets = known_secrets(variables, folder).items()
        names = {text: name for text, name in secrets if len(text) >= MIN_LENGTH}
        # The longest first: a secret may contain another.
        self._forms = sorted(names, key=lambda text: (-len(text), text))
        # A secret that contains another is found by the shorter secret.
        minimal_forms = [
            form for form in self._forms if not any(other in form for other in names if other != form)
        ]
        self._patterns = [(text, text.encode(), names[text]) for text in minimal_forms]

    def blanked(self, text: str) -> str:
        """Blanks all secrets in a text."""
        for secret in self._forms:
            text = text.replace(secret, REPLACEMENT)
        return text

    def within(self, tree: Any) -> Any:
        """Blanks all secrets in the texts of plain data; the keys of mappings stay as they are."""
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
        """Returns a problem for each key of a configuration that contains a secret."""
        return [self._problem(name, self.blanked(key_of(place))) for place, name in self._leaks(tree)]

    def split_arguments(self, arguments: Iterable[str]) -> tuple[list[str], list[Diagnostic]]:
        """Returns the arguments of a command line without secrets, and a problem for each argument with
        one."""
        clean: list[str] = []
        problems: list[Diagnostic] = []
        for argument in arguments:
            name = self._variable_in(argument)
            if name:
                problems.append(self._problem(name, self.blanked(argument.partition("=")[0])))
            else:
                clean.append(argument)
        return clean, problems

    def check(self, files: Mapping[str, bytes]) -> None:
        """Raises SecretFound if one of `files`, which are about to be written, contains a secret."""
        for path, data in files.items():
            name = self._variable_in(path) or next(
                (name for _, raw, name in self._patterns if raw in data), ""
            )
            if name:
                text = f"would hold the value of {name}; nothing was written"
                hint = (
                    "remove it from the robot's source (the name of a part, a property, a file), and "
                    "create a new key in Onshape: everyone who can read the source has this key"
                )
                where = self.blanked(f"{path}{self._place_in_file(data)}")
                raise SecretFound(text, where, hint)

    def _problem(self, name: str, where: str) -> Diagnostic:
        text = f"holds the value of {name}, which would be written to files"
        hint = "remove it: the key is read only from the environment or from .env"
        return Diagnostic("E-SECRET", text, where, hint)

    def _variable_in(self, text: str) -> str:
        """Returns the name of the variable whose value is in a text, or ""."""
        return next((name for secret, _, name in self._patterns if secret in text), "")

    def _leaks(self, tree: Any, place: Place = ()) -> Iterator[tuple[Place, str]]:
        """Yields the places of secrets in plain data, each with the name of its variable."""
        if isinstance(tree, str):
            name = self._variable_in(tree)
            if name:
                yield place, name
        elif isinstance(tree, Mapping):
            for key, value in tree.items():
                inner_place = (*place, str(key))
                name = self._variable_in(str(key))
                if name:
                    yield inner_place, name
                else:
                    yield from self._leaks(value, inner_place)
        elif isinstance(tree, list | tuple):
            for index, value in enumerate(tree):
                yield from self._leaks(value, (*place, index))

    def _place_in_file(self, data: bytes) -> str:
        """Returns the place of a secret in a file: the key in JSON, else the line; "" if it is in the
        path."""
        with contextlib.suppress(ValueError, RecursionError):
            place = next((place for place, _ in self._leaks(json.loads(data))), ())
            if place:
                return f", {key_of(place)}"
        for number, line in enumerate(data.splitlines(), 1):
            if any(raw in line for _, raw, _ in self._patterns):
                return f", line {number}"
        return ""


@contextlib.contextmanager
def withhold_keys(environ: MutableMapping[str, str] = os.environ) -> Iterator[None]:
    """Removes the API keys from the environment while the block runs, so that processes started in it do not
    get them. `Secrets` of this process still knows them."""
    removed_keys = {name: environ.pop(name) for name in PRIVATE if name in environ}
    old_keys = dict(_WITHHELD)
    _WITHHELD.update(removed_keys)
    try:
        yield
    finally:
        environ.update(removed_keys)
        _WITHHELD.clear()
        _WITHHELD.update(old_keys)
