"""Asks the guest that draws, within limits of time and memory."""

import json
import os
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.errors import LinkwrightError
from linkwright.stages.robot.system import guest
from linkwright.stages.robot.system.guest import Bounds
from linkwright.stages.show.preview import ENDED, REFUSED, Kind
from linkwright.stages.show.preview.look import Look, packed

GUEST = "linkwright.stages.show.preview.guest"

BOUNDS = Bounds(seconds=60, memory=6 << 30, reply=64 << 20, shared=3)
"""Limits of a picture, the time that of its processor."""

TURN_BOUNDS = Bounds(seconds=180, memory=6 << 30, reply=64 << 20, shared=2)

_ENVIRON = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""One thread: the order of the sums of several is not ours."""


@dataclass(frozen=True, slots=True)
class Painter:
    """Who is asked, within which limits."""

    module: str = GUEST
    bounds: Bounds | None = None


class Painting:
    """Pictures that a guest draws beside this process; `seconds`: how long that took."""

    def __init__(self, look: Look, kind: Kind) -> None:
        self.seconds = 0.0
        self._halt = threading.Event()
        self._made: Mapping[str, bytes] = {}
        self._thread = threading.Thread(target=self._run, args=(look, kind), name="preview", daemon=True)
        self._thread.start()

    def result(self) -> Mapping[str, bytes]:
        """The pictures by name, as `drawn`."""
        self._thread.join()
        return self._made

    def end(self) -> None:
        """Ends the guest where it draws."""
        self._halt.set()
        self._thread.join()

    def _run(self, look: Look, kind: Kind) -> None:
        start = time.perf_counter()
        self._made = drawn(look, kind, halt=self._halt)
        self.seconds = time.perf_counter() - start


def drawn(
    look: Look, kind: Kind, by: Painter = Painter(), halt: threading.Event | None = None
) -> dict[str, bytes]:
    """The pictures by name; where there are none `REFUSED`, or `ENDED` where it may work another time."""
    bounds = by.bounds or (TURN_BOUNDS if kind == "turn" else BOUNDS)
    try:
        return _read(guest.ask(by.module, packed(look, kind), bounds, {**_ENVIRON, **_temporary()}, halt))
    except guest.Ended as ended:
        return {ENDED: json.dumps({"why": f"drawing it {ended}"}).encode()}
    except LinkwrightError as error:
        return {REFUSED: json.dumps({"why": error.message}).encode()}
    except (ValueError, KeyError, TypeError):
        return {ENDED: json.dumps({"why": "drawing it gave an invalid reply"}).encode()}


def _read(reply: bytes) -> dict[str, bytes]:
    """The pictures in a reply: a line of JSON with their names and lengths, and their bytes."""
    head, _, body = reply.partition(b"\n")
    found, at = {}, 0
    for name, length in json.loads(head)["files"]:
        found[str(name)] = body[at : at + int(length)]
        at += int(length)
    if at != len(body) or not found:
        raise ValueError("the lengths do not add up")
    return found


def _temporary() -> dict[str, str]:
    return {name: os.environ[name] for name in ("TMPDIR",) if name in os.environ}
