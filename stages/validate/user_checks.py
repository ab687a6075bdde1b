"""Runs the user's own checks, which are called with a compiled model, and labels their results."""

import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel

PREFIX = "X-"
"""Prefix of the codes of the user's own checks."""


@dataclass(frozen=True, slots=True)
class UserCheck:
    """A check that the user wrote."""

    target: str
    """The configured name, `module.name`."""

    function: Callable[..., Any]
    """Called with the model and the `arguments`; or a class, constructed with the arguments and called with
    the model."""

    arguments: Mapping[str, Any] = field(default_factory=dict)
    """Keyword arguments from the configuration."""

    def check(self, compiled: CompiledModel) -> Iterator[Check]:
        """Runs the check and yields its results, with names that start with the file's and codes that start
        with `X-`. If it raises, or returns anything but checks, it yields a single failed result."""
        title = self.target.rpartition(".")[2]
        code = PREFIX + title.upper().replace("_", "-")
        try:
            results = list(self._results(compiled))
        except Exception as error:
            text = f"{self.target} raised {type(error).__name__}: {error}{_place(error)}"
            yield Check(f"{compiled.path.name}: {title}", False, text, code=code)
            return
        for result in results:
            result_code = result.code if result.code.startswith(PREFIX) else code
            prefix = f"{compiled.path.name}: "
            name = result.name if result.name.startswith(prefix) else f"{prefix}{result.name or title}"
            # NumPy's booleans cannot be written as JSON.
            yield replace(result, name=name, code=result_code, passed=bool(result.passed))

    def _results(self, compiled: CompiledModel) -> Iterator[Check]:
        if isinstance(self.function, type):
            returned = self.function(**self.arguments)(compiled)
        else:
            returned = self.function(compiled, **self.arguments)
        if isinstance(returned, Check):
            returned = [returned]
        if returned is None or isinstance(returned, str) or not isinstance(returned, Iterable):
            raise TypeError(_refusal(returned))
        for result in returned:
            if not isinstance(result, Check):
                raise TypeError(_refusal(result))
            yield result


def _refusal(value: object) -> str:
    return f"it gave {value!r}, but must yield checks (linkwright.Check)"


def _place(error: Exception) -> str:
    """Returns the innermost line outside this module that an error came from, as a text; "" if the user's
    code was not reached."""
    stack = traceback.extract_tb(error.__traceback__)
    # The user's file may have the same name as this file, but not the same path.
    frames = [frame for frame in stack if frame.filename != __file__]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
