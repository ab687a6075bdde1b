"""Runs the guest process that draws, within limits of time and memory."""

import json
import os
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass

from linkwright.stages.robot.errors import LinkwrightError
from linkwright.stages.robot.system import guest
from linkwright.stages.robot.system.guest import Bounds
from linkwright.stages.show.preview import ENDED, REFUSED, THUMBNAIL, Kind
from linkwright.stages.show.preview.look import Look, packed

GUESTS: Mapping[Kind, str] = {
    "png": "linkwright.stages.show.preview.guest",
    "turn": "linkwright.stages.show.preview.turning",
}
"""Kind of preview → the module of the guest that draws it."""

BOUNDS = Bounds(seconds=60, memory=6 << 30, reply=64 << 20, wall_time_factor=3)
"""Limits of a picture; its time is the processor's."""

TURN_BOUNDS = Bounds(seconds=180, memory=6 << 30, reply=64 << 20, wall_time_factor=2)

_ENVIRON = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
"""Environment of the guest: a single thread, since several threads would sum in another order."""


@dataclass(frozen=True, slots=True)
class Painter:
    """A guest that draws: its module and its limits; None for those that belong to the kind of preview."""

    module: str | None = None
    bounds: Bounds | None = None


class Painting:
    """Pictures that a guest process draws while this process goes on. `seconds`: the time [s] that it
    took."""

    def __init__(self, look: Look, kind: Kind) -> None:
        self.seconds = 0.0
        self._halt = threading.Event()
        self._pictures: Mapping[str, bytes] = {}
        self._thread = threading.Thread(target=self._run, args=(look, kind), name="preview", daemon=True)
        self._thread.start()

    def result(self) -> Mapping[str, bytes]:
        """Waits for the pictures, and returns them by name, as `pictures_of` does."""
        self._thread.join()
        return self._pictures

    def end(self) -> None:
        """Ends the guest if it is still drawing."""
        self._halt.set()
        self._thread.join()

    def _run(self, look: Look, kind: Kind) -> None:
        start = time.perf_counter()
        self._pictures = pictures_of(look, kind, halt=self._halt)
        self.seconds = time.perf_counter() - start


def thumbnail(look: Look) -> bytes | str:
    """Returns the PNG of a thumbnail, or the reason why there is none."""
    drawing = pictures_of(look, "png", Painter("linkwright.stages.show.preview.thumbnail"))
    if THUMBNAIL in drawing:
        return drawing[THUMBNAIL]
    (refusal,) = drawing.values()
    return str(json.loads(refusal)["why"])


def pictures_of(
    look: Look, kind: Kind, by: Painter = Painter(), halt: threading.Event | None = None
) -> dict[str, bytes]:
    """Returns the pictures by name. If drawing fails, the only entry has the reason as JSON, and the name
    `ENDED` if another try may succeed, else `REFUSED`."""
    bounds = by.bounds or (TURN_BOUNDS if kind == "turn" else BOUNDS)
    try:
        return _pictures_in(
            guest.ask(
                by.module or GUESTS[kind], packed(look), bounds, {**_ENVIRON, **_temporary_folder()}, halt
            )
        )
    except guest.Ended as ended:
        return {ENDED: json.dumps({"why": f"drawing it {ended}"}).encode()}
    except LinkwrightError as error:
        return {REFUSED: json.dumps({"why": error.message}).encode()}
    except (ValueError, KeyError, TypeError):
        return {ENDED: json.dumps({"why": "drawing it gave an invalid reply"}).encode()}


def _pictures_in(reply: bytes) -> dict[str, bytes]:
    """Returns the pictures in a reply: a line of JSON with their names and lengths, and their bytes."""
    head, _, body = reply.partition(b"\n")
    pictures, offset = {}, 0
    for name, length in json.loads(head)["files"]:
        pictures[str(name)] = body[offset : offset + int(length)]
        offset += int(length)
    if offset != len(body) or not pictures:
        raise ValueError("the lengths do not add up")
    return pictures


def _temporary_folder() -> dict[str, str]:
    return {name: os.environ[name] for name in ("TMPDIR",) if name in os.environ}
