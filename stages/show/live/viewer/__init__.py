"""Writes the HTML of the live view: the simulated robot in 3D, in a page that opens from disk, fetching
nothing.

The script is a single module, made of the files in `script/` in order: each declares names for the files
after it, and no name is declared twice. MuJoCo and three.js are compressed in `engine/`, and the page
contains them unchanged.
"""

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
    "stage", "engine", "values", "make", "elements", "panel", "link_card", "pointer", "view", "page", "start",
)  # fmt: skip
"""The files of the script in order."""

ENGINE_LICENCES = ("mujoco.LICENSE.gz", "mujoco.LICENSES_THIRD_PARTY.md.gz")

INERT = "application/octet-stream;base64"
"""The type of a script element that a browser does not run."""


@dataclass(frozen=True, slots=True)
class LiveView:
    """The HTML of the live view, for three places of a page."""

    style: str
    """The style sheet, for the head of the page."""

    body: str
    """The robot; a picture may replace the comment `<!-- preview -->` in it."""

    scripts: str
    """The licences and the scripts, for the end of the page."""


def view(pack: bytes | None, engine: Literal["whole", "shared", "none"], shared_path: str = "") -> LiveView:
    """Returns the HTML of the view of a robot in a pack; empty without a pack. `engine`: whole in the page,
    shared in a file at `shared_path`, or none, so that the robot only moves by its sliders."""
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
    """Returns the content of `linkwright-engine.js`: the engine for several pages, which also opens from
    disk."""
    content = {
        "wasm": _piece("mujoco.wasm.gz"),
        "glue": _piece("mujoco.js.gz"),
        "licences": [_piece(name) for name in ENGINE_LICENCES],
    }
    return f"globalThis.linkwrightEngine = {json.dumps(content)};\n".encode()


@cache
def script() -> str:
    """Returns the view's own script."""
    return "\n".join(_text(f"script/{name}.js") for name in SCRIPTS)


@cache
def version(file: str) -> str:
    """Returns the version of the library in a file of the engine."""
    number = json.loads(_text("engine/engine.json"))[file]["version"]
    return str(number)


def _text(path: str) -> str:
    return (ROOM / path).read_text(encoding="utf-8")


@cache
def _piece(name: str) -> str:
    """Returns a file of the engine in base64."""
    return b64encode((ROOM / "engine" / name).read_bytes()).decode()


def _inert(name: str, content: str) -> str:
    return f'<script type="{INERT}" id="{name}">{content}</script>'


def _licences(files: Sequence[str]) -> str:
    """Returns the libraries in the page and their licences, folded; the texts are inflated on opening."""
    words = f"MuJoCo {version('mujoco.wasm.gz')} (Apache-2.0) and three.js {version('three.js.gz')} (MIT)"
    if len(files) == 1:
        words = f"three.js {version('three.js.gz')} (MIT)"
    content = " ".join(_piece(name) for name in files)
    return (
        '<details class="live-licences" data-licences>'
        f"<summary>This page contains {words}: licences</summary>"
        f'<pre></pre><script type="{INERT}">{content}</script></details>'
    )
