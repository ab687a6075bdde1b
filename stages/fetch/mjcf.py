"""The source `mjcf`: a model file, read and compiled by MuJoCo itself, as a bundle.

What is kept is what MuJoCo made of it (`stages.robot.mjcf`), exact to the bit, and the triangles of each
mesh: neither text nor mesh files, so that nothing after this depends on how MuJoCo finds and reads them.
MuJoCo's own way to write a model down again loses defaults, inertias and digits, and is not used.
"""

from __future__ import annotations

import importlib.metadata
import json
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stages.robot.bundle import Bundle
from stages.robot.errors import Diagnostic, SourceError

if TYPE_CHECKING:
    import mujoco

    from stages.fetch.keys import MjcfKeys

READER = 2
"""Grows with every change of what is made of the same files."""

MODEL = "model"
"""The request that stands for the compiled model."""

_LOOK = "see whether the file means what MuJoCo made of it"
_HINT = "MuJoCo's own viewer says the same of it (python -m mujoco.viewer --mjcf=...)"


def gather(source: MjcfKeys) -> tuple[Bundle, tuple[Diagnostic, ...]]:
    """The bundle of an MJCF, and what MuJoCo warned of.

    SourceError where it is no MJCF, a file is missing, or MuJoCo refuses it.
    """
    from stages.fetch.mjcfmodel import Meshes, taken
    from stages.robot import codec

    path = Path(source.path)
    told = identity(source)
    model, spec, warnings = _compiled(path)
    meshes = Meshes(model)
    body = codec.dump(taken(model, spec, meshes, path.name))
    definition = sha256(body).hexdigest()
    requests = {MODEL: definition, **{f"mesh/{key}": digest for key, digest in sorted(meshes.keys.items())}}
    bundle = Bundle(
        kind="mjcf",
        api="",
        root={"document": path.name, "microversion": _sum(told), "element": "", "configuration": ""},
        definition=definition,
        studios=(),
        requests=requests,
        blobs={definition: body, **meshes.blobs},
    )
    return bundle, warnings


def identity(source: MjcfKeys) -> dict[str, Any]:
    """What tells the source from every other, by content, as plain data."""
    from stages.fetch.mjcffiles import digests

    path = Path(source.path)
    return {
        "kind": "mjcf",
        "document": path.name,
        "files": digests(path),
        "mujoco": importlib.metadata.version("mujoco"),
        "reader": READER,
    }


def _sum(told: dict[str, Any]) -> str:
    return sha256(json.dumps(told["files"], sort_keys=True).encode()).hexdigest()


def _compiled(path: Path) -> tuple[mujoco.MjModel, mujoco.MjSpec, tuple[Diagnostic, ...]]:
    """The model with what is only seen in it, what it was compiled from, and MuJoCo's warnings."""
    import mujoco

    from stages.robot.listening import listening

    with listening() as heard:
        try:
            spec = mujoco.MjSpec.from_file(str(path))
            spec.compiler.discardvisual = False
            model = spec.compile()
        except (ValueError, RuntimeError, MemoryError, mujoco.FatalError) as error:
            msg = f"MuJoCo refuses it: {_said(str(error), path)}"
            raise SourceError(msg, path.name, _HINT) from None
    warnings = (Diagnostic("W-MJCF", _said(text, path), path.name, _LOOK) for text in sorted(set(heard)))
    return model, spec, tuple(warnings)


def _said(text: str, path: Path) -> str:
    """MuJoCo's words in one line, without the folder that the model is in."""
    for folder in (str(path.resolve().parent), str(path.absolute().parent), str(path.parent)):
        if len(folder) > 1:
            text = text.replace(f"{folder}/", "")
    words = " ".join(text.split())
    return words.removeprefix("XML Error: ").removeprefix("Error: ")[:500]
