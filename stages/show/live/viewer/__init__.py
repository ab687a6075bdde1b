"""The view in the page: the robot in 3D, simulating, in a file that opens from disk and fetches nothing.

The script is one module of the files in `script/`, one after the other: each declares what those after it
use, no name twice. MuJoCo and three.js lie compressed in `engine/`, and get into the page as they are."""

import json
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Literal

ROOM = Path(__file__).parent

SCRIPTS = (
    "libraries", "pack", "algebra", "kinematics", "closing", "triangles", "robot_mesh", "picking", "overlays",
    "stage", "engine", "values", "elements", "panel", "link_card", "pointer", "view", "page", "start",
)  # fmt: skip
"""The files of the script, in their order."""

ENGINE_LICENCES = ("mujoco.LICENSE.gz", "mujoco.LICENSES_THIRD_PARTY.md.gz")

INERT = "application/octet-stream;base64"
"""The type of a script element that a browser keeps and does not run."""


@dataclass(frozen=True, slots=True)
class LiveView:
    """HTML for three places of a page: `style` in its head, `body` where the robot is shown (the comment
    `<!-- preview -->` in it is the place of a picture), and `scripts` at its end, under the licences."""

    style: str
    body: str
    scripts: str


def view(pack: bytes | None, engine: Literal["whole", "shared", "none"], shared_path: str = "") -> LiveView:
    """The view of a robot as `live.pack` packed it; nothing without a pack. `engine`: in the page, in a file
    beside it at `shared_path`, or none, which leaves the sliders."""
    if pack is None:
        return LiveView("", "", "")
    body = Template(_text("view.html")).substitute(
        engine="none" if engine == "none" else "waits",
        shared=escape(shared_path),
        version=escape(version("mujoco.wasm.gz")),
    )
    pieces = [
        _inert("robot-pack", b64encode(pack).decode()),
        _inert("linkwright-three", _piece("three.js.gz")),
    ]
    licences = ["three.LICENSE.gz"]
    if engine == "whole":
        pieces += [_inert("linkwright-wasm", _piece("mujoco.wasm.gz"))]
        pieces += [_inert("linkwright-glue", _piece("mujoco.js.gz"))]
        licences = [*ENGINE_LICENCES, *licences]
    elif engine == "shared":
        pieces.append(f'<script src="{escape(shared_path)}"></script>')
    scripts = [_licences(licences), *pieces, f'<script type="module">\n{script()}</script>']
    return LiveView(_text("view.css"), body, "\n".join(scripts))


def engine_script() -> bytes:
    """`linkwright-engine.js`: the engine for several pages, a script that opens from disk too."""
    content = {
        "wasm": _piece("mujoco.wasm.gz"),
        "glue": _piece("mujoco.js.gz"),
        "licences": [_piece(name) for name in ENGINE_LICENCES],
    }
    return f"globalThis.linkwrightEngine = {json.dumps(content)};\n".encode()


@cache
def script() -> str:
    """The view's own script."""
    return "\n".join(_text(f"script/{name}.js") for name in SCRIPTS)


@cache
def version(file: str) -> str:
    """Of what a file of the engine is."""
    found = json.loads(_text("engine/engine.json"))[file]["version"]
    return str(found)


def _text(path: str) -> str:
    return (ROOM / path).read_text(encoding="utf-8")


@cache
def _piece(name: str) -> str:
    """A file of the engine in base64."""
    return b64encode((ROOM / "engine" / name).read_bytes()).decode()


def _inert(name: str, content: str) -> str:
    return f'<script type="{INERT}" id="{name}">{content}</script>'


def _licences(files: Sequence[str]) -> str:
    """What the page is made of and under which licence, folded; the texts are inflated on opening."""
    words = f"MuJoCo {version('mujoco.wasm.gz')} (Apache-2.0) and three.js {version('three.js.gz')} (MIT)"
    if len(files) == 1:
        words = f"three.js {version('three.js.gz')} (MIT)"
    content = " ".join(_piece(name) for name in files)
    return (
        '<details class="live-licences" data-licences>'
        f"<summary>This page contains {words}: licences</summary>"
        f'<pre></pre><script type="{INERT}">{content}</script></details>'
    )
