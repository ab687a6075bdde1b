"""The source `mjcf`: a model file, read and compiled by MuJoCo itself, as a bundle.

What is kept is what MuJoCo made of it (`stages.formats.mjcf`), exact to the bit, and the triangles of each
mesh: neither text nor mesh files, so that nothing after this depends on how MuJoCo finds and reads them.
MuJoCo's own way to write a model down again loses defaults, inertias and digits, and is not used.
"""

from __future__ import annotations

import importlib.metadata
import json
import re
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.robot import guest
from stages.robot.bundle import FileBundle
from stages.robot.errors import Diagnostic, ProtocolError, SourceError

if TYPE_CHECKING:
    from stages.fetch.mjcf.keys import MjcfSourceKeys

READER = 2
"""Grows with every change of what is made of the same files."""

MODEL = "model"
"""The request that stands for the compiled model."""

BOUNDS = guest.Bounds(seconds=120, memory=4 << 30, reply=1 << 30)
"""What MuJoCo may take: a model of 10,000 bodies takes it half a minute."""

_ENVIRON = {"MUJOCO_GL": "disable", "OPENBLAS_NUM_THREADS": "1"}
"""Nothing is drawn, and no large matrix multiplied: what would prepare for it takes as long as all else."""

_KEY = re.compile(r"[A-Za-z0-9_-]{1,60}")
_LONGEST, _MOST_WARNINGS = 500, 100
"""How long a warning of MuJoCo may be, and how many of them are reported."""

_LOOK = "check that MuJoCo read the file as intended"
_SMALLER = (
    "look for large counts or sizes, models in models, or a file that includes itself; "
    "MuJoCo's own viewer may say more (python -m mujoco.viewer --mjcf=...)"
)


def gather(
    source: MjcfSourceKeys, while_waiting: Callable[[], None] = lambda: None
) -> tuple[FileBundle, tuple[Diagnostic, ...]]:
    """The bundle of an MJCF, and what MuJoCo warned of. `while_waiting` is called before MuJoCo begins.

    SourceError where it is no MJCF, a file is missing, MuJoCo refuses it, or does not get through it.
    """
    from stages.fetch.mjcf.files import survey

    path = Path(source.path)
    files = survey(path)
    request = {"path": str(path), "texts": [str(text) for text in files.texts]}
    while_waiting()
    try:
        reply = guest.ask("stages.fetch.mjcf.compile_guest", json.dumps(request).encode(), BOUNDS, _ENVIRON)
        warnings, model, meshes = _read(reply)
    except guest.Ended as ended:
        msg = f"not readable as an MJCF: MuJoCo's compiler {ended}"
        raise SourceError(msg, path.name, _SMALLER) from None
    definition = sha256(model).hexdigest()
    digests = {key: sha256(mesh).hexdigest() for key, mesh in meshes.items()}
    bundle = FileBundle(
        kind="mjcf",
        root={"document": path.name, "microversion": _sum(files.digests), "element": "", "configuration": ""},
        definition=definition,
        requests={MODEL: definition, **{f"mesh/{key}": digests[key] for key in sorted(digests)}},
        blobs={definition: model, **{digests[key]: mesh for key, mesh in meshes.items()}},
    )
    return bundle, tuple(Diagnostic("W-MJCF", text, path.name, _LOOK) for text in warnings)


def identity(source: MjcfSourceKeys) -> dict[str, Any]:
    """What identifies the source, by content, as plain data."""
    from stages.fetch.mjcf.files import survey

    path = Path(source.path)
    return {
        "kind": "mjcf",
        "document": path.name,
        "files": survey(path).digests,
        "mujoco": importlib.metadata.version("mujoco"),
        "reader": READER,
    }


def _read(reply: bytes) -> tuple[list[str], bytes, dict[str, bytes]]:
    """The warnings, the model and the meshes in what the guest answers; Ended where it is no such answer.

    By then the guest may run anything, so nothing is taken on trust; the model is checked by its reader.
    """
    from stages.formats import triangles

    head, _, body = reply.partition(b"\n")
    try:
        header = json.loads(head)
        warnings = [str(text)[:_LONGEST] for text in header["warnings"][:_MOST_WARNINGS]]
        at = int(header["model"])
        model, meshes = body[:at], dict[str, bytes]()
        for key, length in header["meshes"]:
            mesh = body[at : at + length]
            if not _KEY.fullmatch(key):
                raise ValueError(key)
            triangles.check(mesh)
            meshes[key] = mesh
            at += length
    except (KeyError, TypeError, ValueError, RecursionError, ProtocolError):
        msg = "does not answer with a model"
        raise guest.Ended(msg) from None
    return warnings, model, meshes


def _sum(digests: dict[str, str]) -> str:
    return sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()
