"""Asks the guest process to check files, within limits of time and memory."""

import json
from collections.abc import Sequence

from linkwright.pipeline.checking.verdict import Verdict
from linkwright.pipeline.checking.wire import load
from linkwright.pipeline.errors import OutputError
from linkwright.stages.robot.errors import SourceError
from linkwright.stages.robot.system import guest

GUEST = "linkwright.pipeline.checking.guest"

BOUNDS = guest.Bounds(seconds=900, memory=8 << 30, reply=256 << 20)
"""Limits of any check. The guest sets lower limits for itself, from the sizes of the files."""

_ENVIRON = {"MUJOCO_GL": "disable", "OPENBLAS_NUM_THREADS": "1"}
"""Environment without rendering and threaded linear algebra: to start these takes as long as the checks."""

_HINT = (
    "look for large counts or sizes, models in models, or a file that includes itself; a file without these "
    "shows a bug in what reads it"
)


def checked(place: str, level: str, targets: Sequence[str] = ()) -> Verdict:
    """Returns the verdict on a folder or file, or with `targets` on whether these engines can load it. Raises
    OutputError if it cannot be read, or not within the limits."""
    request = json.dumps({"place": place, "level": level, "targets": list(targets)}).encode()
    try:
        return load(guest.ask(GUEST, request, BOUNDS, _ENVIRON))
    except guest.Ended as ended:
        raise OutputError(f"it cannot be checked: what reads it {ended}", place, _HINT) from None
    except SourceError as error:
        raise OutputError(error.message, error.where, error.hint) from None
    except (ValueError, KeyError, TypeError, RecursionError):
        raise OutputError("it cannot be checked: the reply is not a verdict", place, _HINT) from None
