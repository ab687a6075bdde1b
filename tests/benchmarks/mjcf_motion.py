"""`python -m tests.benchmarks.mjcf_motion FOLDER...`: every MJCF of the folders, built and moved as the file.

For each file that MuJoCo loads and in which something moves: whether it builds, how far the motion of the
scene that we write is from that of the file over a second, from qpos0 and from each of its keyframes, without
controls and with seeded ones, which checks fail, and what the build reports as lost. Where contacts make the
file itself move otherwise once its masses are rounded in the last digit that we write, that is shown as its
own chaos. Colliders are the file's own meshes (`mesh.collider: raw`), since a fitted collider touches
elsewhere. Joints, actuators and bodies are found by their names. Ends with exit status 1 where a file does
not build, or moves otherwise and names no loss.
"""

import argparse
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import mujoco

from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.errors import LinkwrightError
from tests.support.mjcfs import built
from tests.support.same_motion import LIMIT, Apart, farthest

LOSSES = ("W-MJCF-LEFT",)
"""Codes of what moves a robot otherwise."""


NOT_MOVED = Apart(0.0, "", 0.0)


@dataclass(frozen=True, slots=True)
class Row:
    """One file: how far its farthest run is from it; `losses`: what the build reports; `failed`: checks of
    the validate stage; `refused`: why it does not build."""

    name: str
    apart: Apart = NOT_MOVED
    losses: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    seconds: float = 0.0
    refused: str = ""

    @property
    def good(self):
        return not self.refused and (self.apart.same or self.apart.chaotic or bool(self.losses))

    def __str__(self):
        if self.refused:
            return f"{self.name:44} refused: {self.refused}"
        off, where = self.apart.off, "" if self.apart.same else f"from {self.apart.start}"
        if self.apart.chaotic:
            where += f", where the file itself moves {self.apart.own:.1e} otherwise by the last digit"
        start = f"{self.name:44} {off:8.1e} {self.seconds:6.1f} s"
        return "  ".join(filter(None, (start, where, *self.losses, *self.failed)))


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path, help="where MJCFs lie")
    parser.add_argument("--only", default="", help="files whose path has this in it")
    asked = parser.parse_args()
    rows = []
    print(f"{'file':44} {'apart':>8} {'time':>8}  notes")
    for folder, path in _files(asked.folders, asked.only):
        rows.append(_row(folder, path))
        print(rows[-1], flush=True)
    made = [row for row in rows if not row.refused]
    same, chaotic = (sum(getattr(row.apart, name) for row in made) for name in ("same", "chaotic"))
    print(
        f"{len(rows)} files: {len(made)} build, {same} move as the file within {LIMIT:g}, {chaotic} as far "
        "as its own chaos lets them, "
        f"{sum(row.good for row in made) - same - chaotic} others name what is lost; "
        f"{sum(not row.failed for row in made)} pass every check"
    )
    return 0 if all(row.good for row in rows) else 1


def _files(folders, only):
    """The MJCFs in which something moves, each with its folder."""
    for folder in folders:
        for path in sorted(folder.rglob("*.xml")):
            if only in str(path):
                model = _loaded(path)
                if model is not None and model.nv:
                    yield folder, path


def _loaded(path):
    with collected_warnings():
        try:
            return mujoco.MjModel.from_xml_path(str(path))
        except ValueError:
            return None


def _row(folder, path):
    name = str(path.relative_to(folder).with_suffix(""))
    begin = time.perf_counter()
    try:
        with tempfile.TemporaryDirectory() as scratch:
            found, failed = built(path, Path(scratch))
            apart = farthest(_loaded(path), _loaded(Path(scratch) / "scene.xml"))
    except LinkwrightError as error:
        first = error.problems[0] if error.problems else error
        return Row(name, refused=f"{error.message}: {first.where}: {first.message}"[:200])
    losses = tuple(f"{problem.code}: {problem.message}" for problem in found if problem.code in LOSSES)
    return Row(name, apart, losses, failed, time.perf_counter() - begin)


if __name__ == "__main__":
    sys.exit(main())
