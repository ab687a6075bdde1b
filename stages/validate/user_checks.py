"""The user's own checks: functions that are called with a compiled model, and what they find."""

import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from linkwright.stages.robot.check import Check
from linkwright.stages.validate.compiled import CompiledModel

PREFIX = "X-"
"""How the codes of the user's own checks begin."""


@dataclass(frozen=True, slots=True)
class OwnCheck:
    """`target`: its name as configured, `module.name`. `code`: a function, called with the model and the
    `keys`; or a class, made with the keys and called with the model."""

    target: str
    code: Callable[..., Any]
    keys: Mapping[str, Any] = field(default_factory=dict)

    def check(self, compiled: CompiledModel) -> Iterator[Check]:
        """Its results, under names that begin with the file's and codes that begin with `X-`; one that says
        what went wrong where it raises, or where what it gives is no check."""
        title = self.target.rpartition(".")[2]
        code = PREFIX + title.upper().replace("_", "-")
        try:
            found = list(self._results(compiled))
        except Exception as error:
            text = f"{self.target} raised {type(error).__name__}: {error}{_place(error)}"
            yield Check(f"{compiled.path.name}: {title}", False, text, code=code)
            return
        for one in found:
            own = one.code if one.code.startswith(PREFIX) else code
            prefix = f"{compiled.path.name}: "
            name = one.name if one.name.startswith(prefix) else f"{prefix}{one.name or title}"
            # What a library of arrays calls true is no JSON.
            yield replace(one, name=name, code=own, passed=bool(one.passed))

    def _results(self, compiled: CompiledModel) -> Iterator[Check]:
        if isinstance(self.code, type):
            made = self.code(**self.keys)(compiled)
        else:
            made = self.code(compiled, **self.keys)
        if isinstance(made, Check):
            made = [made]
        if made is None or isinstance(made, str) or not isinstance(made, Iterable):
            msg = f"it gave {made!r}, and shall yield checks (linkwright.Check)"
            raise TypeError(msg)
        for one in made:
            if not isinstance(one, Check):
                msg = f"it gave {one!r}, and shall yield checks (linkwright.Check)"
                raise TypeError(msg)
            yield one


def _place(error: Exception) -> str:
    """The innermost line of the user's own code that an error came from."""
    here = Path(__file__).name
    every = traceback.extract_tb(error.__traceback__)
    frames = [frame for frame in every if Path(frame.filename).name != here]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
