"""Guest process in which MuJoCo reads and compiles an untrusted MJCF: some inputs crash its compiler, or
exhaust time and memory."""

from __future__ import annotations

import json
from pathlib import Path

import mujoco

from linkwright.stages.fetch.mjcf.compiled.meshes import Meshes
from linkwright.stages.fetch.mjcf.compiled.model import convert
from linkwright.stages.fetch.mjcf.compiled.textures import Textures
from linkwright.stages.formats.mjcf import bounds as mjcf_bounds
from linkwright.stages.mujoco.compile import NotCompiled, refusals, spec_of_mjcf
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import SourceError

_HINT = "MuJoCo's own viewer gives the same error (python -m mujoco.viewer --mjcf=...)"


def answer(request: bytes) -> bytes:
    """Compiles a model and returns it as bytes.

    The request is {"path": a model's file, "texts": its files that may be XML}. The reply is a line of JSON
    with MuJoCo's `warnings`, the length of the `model`, the `meshes` as [key, length] and the lengths of the
    `images`; the bytes of the model, meshes and images follow.

    Raises SourceError if the file exceeds a size limit, or MuJoCo cannot compile it.
    """
    fields = json.loads(request)
    path = Path(fields["path"])
    mjcf_bounds.require_within_limits([Path(text) for text in fields["texts"]])
    model, spec, warnings = _compile_mjcf(path)
    meshes, textures = Meshes(model), Textures(model)
    body = codec.dump(convert(model, spec, meshes, textures, path.name))
    blobs = {key: meshes.blobs[digest] for key, digest in sorted(meshes.keys.items())}
    lengths = [[key, len(blob)] for key, blob in blobs.items()]
    images = [textures.images[digest] for digest in sorted(textures.images)]
    sizes = [len(image) for image in images]
    head = {"warnings": warnings, "model": len(body), "meshes": lengths, "images": sizes}
    return b"".join([json.dumps(head).encode(), b"\n", body, *blobs.values(), *images])


def _compile_mjcf(path: Path) -> tuple[mujoco.MjModel, mujoco.MjSpec, list[str]]:
    """Returns the model (visual geoms included), its spec, and MuJoCo's warnings."""
    with collected_warnings() as collected:
        try:
            with refusals():
                spec = spec_of_mjcf(path)
                spec.compiler.discardvisual = False
                # <size nkey> reserves room: keyframes that nobody wrote, all at qpos0.
                spec.nkey = 0
                model = spec.compile()
        except NotCompiled as error:
            msg = f"MuJoCo cannot compile it: {_in_one_line(str(error), path)}"
            raise SourceError(msg, path.name, _HINT) from None
    return model, spec, [_in_one_line(text, path) for text in sorted(set(collected))]


def _in_one_line(text: str, path: Path) -> str:
    """Returns MuJoCo's message in one line, without the path of the model's folder."""
    for folder in (str(path.resolve().parent), str(path.absolute().parent), str(path.parent)):
        if len(folder) > 1:
            text = text.replace(f"{folder}/", "")
    words = " ".join(text.split())
    return words.removeprefix("XML Error: ").removeprefix("Error: ")[:500]
