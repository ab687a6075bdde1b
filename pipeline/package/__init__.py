"""Builds robots from Python: `linkwright.build("robot=my_arm")`.

The wheel ships this folder as `linkwright`; what the package offers is in `pipeline/api`. Importing it loads
nothing else: each name is loaded when it is first used, once our packages are known to be ours.
"""

import sys

if sys.argv[:1] == ["-m"]:
    from . import own_path

    if own_path.is_command():
        own_path.leave_out_working_folder()

TYPE_CHECKING = False
"""What type checkers take for true; `typing` is not imported, so that the command begins at once."""

if TYPE_CHECKING:
    from linkwright.pipeline.api import *  # noqa: F403
else:

    def __getattr__(name: str) -> object:
        from .shadows import shadows

        message = shadows()
        if message:
            raise ImportError(message)
        from linkwright.pipeline import face

        value = globals()[name] = getattr(face, name)
        return value

    def __dir__() -> list[str]:
        return sorted({*globals(), *__getattr__("__all__")})
