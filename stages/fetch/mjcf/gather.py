"""Makes a bundle of a model file that MuJoCo itself reads and compiles.

The bundle has the compiled model (`stages.formats.mjcf.model`), exact to the bit, and the triangles of each
mesh and its textures, but no file of the model, so later stages do not depend on how MuJoCo finds and reads
files.
MuJoCo's own export of a model is not used: it loses defaults, inertias and digits.
"""

from __future__ import annotations

import importlib.metadata
import json
import re
from collections.abc import Callable
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from linkwright.stages.fetch.mjcf.files import survey
from linkwright.stages.fetch.robot_file import IMAGE, MESH
from linkwright.stages.formats import png, triangles
from linkwright.stages.robot.bundle import FileBundle
from linkwright.stages.robot.errors import Diagnostic, ProtocolError, SourceError
from linkwright.stages.robot.system import guest

if TYPE_CHECKING:
    from linkwright.stages.fetch.mjcf.section import MjcfSourceSection

READER = 5
"""Version of the reader, to be raised with every change of the result for the same files."""

MODEL = "model"
"""The request for the compiled model."""

BOUNDS = guest.Bounds(seconds=120, memory=4 << 30, reply=1 << 30)
"""Limits of the guest process: MuJoCo takes half a minute for a model of 10,000 bodies."""

_ENVIRON = {"MUJOCO_GL": "disable", "OPENBLAS_NUM_THREADS": "1"}
"""Environment without rendering and threaded linear algebra, whose start takes as long as the rest."""

_KEY = re.compile(r"[A-Za-z0-9_-]{1,60}")
_MAX_LENGTH, _MAX_WARNINGS = 500, 100
"""Largest length of a reported warning of MuJoCo, and largest number of warnings."""

_CHECK_HINT = "check that MuJoCo read the file as intended"
_LIMITS_HINT = (
    "look for large counts or sizes, models in models, or a file that includes itself; "
    "MuJoCo's own viewer may show more (python -m mujoco.viewer --mjcf=...)"
)


def gather(
    source: MjcfSourceSection, while_waiting: Callable[[], None] = lambda: None
) -> tuple[FileBundle, tuple[Diagnostic, ...]]:
    """Makes the bundle of an MJCF; returns it with MuJoCo's warnings. `while_waiting` is called before MuJoCo
    begins.

    Raises SourceError if the file is not an MJCF, a file is missing, or MuJoCo cannot compile it within its
    limits.
    """
    path = Path(source.path)
    files = survey(path)
    request = {"path": str(path), "texts": [str(text) for text in files.texts]}
    while_waiting()
    try:
        reply = guest.ask(
            "linkwright.stages.fetch.mjcf.compile_guest", json.dumps(request).encode(), BOUNDS, _ENVIRON
        )
        warnings, model, meshes, images = _read(reply)
    except guest.Ended as ended:
        msg = f"not readable as an MJCF: MuJoCo's compiler {ended}"
        raise SourceError(msg, path.name, _LIMITS_HINT) from None
    definition = sha256(model).hexdigest()
    digests = {key: sha256(mesh).hexdigest() for key, mesh in meshes.items()}
    bundle = FileBundle(
        kind="mjcf",
        root={
            "document": path.name,
            "microversion": _digest_of_digests(files.digests),
            "element": "",
            "configuration": "",
        },
        definition=definition,
        requests={
            MODEL: definition,
            **{f"{MESH}{key}": digests[key] for key in sorted(digests)},
            **{f"{IMAGE}{digest}": digest for digest in sorted(images)},
        },
        blobs={definition: model, **{digests[key]: mesh for key, mesh in meshes.items()}, **images},
    )
    return bundle, tuple(Diagnostic("W-MJCF", text, path.name, _CHECK_HINT) for text in warnings)


def identity(source: MjcfSourceSection) -> dict[str, Any]:
    """Returns the identity of the source, by content, as plain data."""
    path = Path(source.path)
    return {
        "kind": "mjcf",
        "document": path.name,
        "files": survey(path).digests,
        "mujoco": importlib.metadata.version("mujoco"),
        "reader": READER,
    }


def _read(reply: bytes) -> tuple[list[str], bytes, dict[str, bytes], dict[str, bytes]]:
    """Returns the warnings, the model, the meshes by key and the images by digest in the guest's reply.
    Raises Ended if the reply is invalid.

    The guest may have run any code, so its reply is not trusted; the reader checks the model.
    """
    head, _, body = reply.partition(b"\n")
    try:
        header = json.loads(head)
        warnings = [str(text)[:_MAX_LENGTH] for text in header["warnings"][:_MAX_WARNINGS]]
        offset = int(header["model"])
        model, meshes = body[:offset], dict[str, bytes]()
        for key, length in header["meshes"]:
            mesh = body[offset : offset + length]
            if not _KEY.fullmatch(key):
                raise ValueError(key)
            triangles.require_compact(mesh)
            meshes[key] = mesh
            offset += length
        images = dict[str, bytes]()
        for length in header["images"]:
            image = body[offset : offset + length]
            if png.problem(image):
                raise ValueError(length)
            images[sha256(image).hexdigest()] = image
            offset += length
        if not all(triangles.textures(mesh) <= images.keys() for mesh in meshes.values()):
            raise KeyError(IMAGE)
    except (KeyError, TypeError, ValueError, RecursionError, ProtocolError):
        msg = "does not answer with a model"
        raise guest.Ended(msg) from None
    return warnings, model, meshes, images


def _digest_of_digests(digests: dict[str, str]) -> str:
    return sha256(json.dumps(digests, sort_keys=True).encode()).hexdigest()
