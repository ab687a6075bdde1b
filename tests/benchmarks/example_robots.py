"""`python -m tests.benchmarks.example_robots [FOLDER]`: every URDF of example-robot-data through all stages.

For each: whether plain MuJoCo loads the file as it is; what the source had to be told (bad inertias
projected, missing meshes skipped), and why without that; checks of the validate stage that pass; how far
our URDF and MJCF are from Pinocchio's reading of the file, at random values; links and joints whose names our
URDF lacks; seconds; or why it is refused. FOLDER: where example-robot-data lies (its `robots`), unless the
package is installed. Ends with exit status 1 where fewer than `GOAL` convert, or one of them is not its file.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import mujoco

from linkwright.pipeline.config.plan import Plan
from linkwright.stages.fetch.urdf.gather import gather
from linkwright.stages.graph import build_robot
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mujoco.warnings import collected_warnings
from linkwright.stages.robot.errors import LinkwrightError
from tests.support.building import plan_of, write
from tests.support.checked import checked
from tests.support.urdfs import lost_names, parity, same_bounds

GOAL = 66
CLOSE = 1e-9
SETTLES = {
    "E-INERTIA": ("bad_inertia", "project"),
    "E-MASS": ("bad_inertia", "project"),
    "E-MESH": ("missing_meshes", "skip"),
}
"""The setting of the source that gets a robot past a problem, by the start of its code."""


@dataclass(frozen=True, slots=True)
class Row:
    """What became of one file. `settings`: those tried, with the codes that made them necessary."""

    name: str
    plain: bool
    settings: str = ""
    passed: str = ""
    failed: str = ""
    apart: float = 0.0
    lost: int = 0
    bounds: str = ""
    seconds: float = 0.0
    refused: str = ""

    @property
    def good(self):
        return not (self.refused or self.failed or self.bounds or self.lost) and self.apart < CLOSE

    def __str__(self):
        start = f"{self.name:48} {'loads' if self.plain else '-':6}"
        if self.refused:
            return f"{start} refused: {self.refused}"
        end = "; ".join(filter(None, (self.settings, self.failed, self.bounds)))
        return f"{start} {self.passed:7} {self.apart:8.1e} {self.lost:4} {self.seconds:6.1f} s  {end}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folder", nargs="?", type=Path, help="where example-robot-data lies")
    parser.add_argument("--only", default="", help="files whose path has this in it")
    asked = parser.parse_args()
    share = asked.folder or installed()
    files = [path for path in sorted(share.rglob("*.urdf")) if asked.only in str(path)]
    print(f"{'file':48} {'MuJoCo':6} {'checks':7} {'apart':>8} {'lost':>4} {'time':>8}  notes")
    rows = []
    for path in files:
        rows.append(_row(path, share))
        print(rows[-1], flush=True)
    made = [row for row in rows if not row.refused]
    good = [row for row in made if row.good]
    print(
        f"{len(rows)} files: plain MuJoCo loads {sum(row.plain for row in rows)}; {len(made)} convert, "
        f"{sum(not row.settings for row in made)} of them as they are; {len(good)} with all checks "
        f"and parity (the worst {max((row.apart for row in made), default=0.0):.1e}), "
        f"{sum(not row.lost for row in made)} with all names; {len(rows) - len(made)} refused"
    )
    return 0 if len(good) >= min(GOAL, len(rows)) and len(good) == len(made) else 1


def installed():
    import example_robot_data

    return Path(example_robot_data.robots_loader.getModelPath("."))


def _row(path, share):
    name = str(path.relative_to(share).with_suffix("")).removeprefix("robots/").replace("_description", "")
    row = {"name": name, "plain": _loads(path)}
    begin = time.perf_counter()
    settings: dict[str, str] = {}
    reasons: Counter[str] = Counter()
    while True:
        try:
            made = _made(path, settings)
            break
        except LinkwrightError as error:
            codes = Counter(problem.code for problem in error.problems)
            remedies = {SETTLES[start] for code in codes for start in SETTLES if code.startswith(start)}
            if not codes or set(remedies) <= set(settings.items()):
                first = error.problems[0] if error.problems else error
                text = f"{first.where}: {first.message}".splitlines()[0]
                counted = ", ".join(f"{count} {code}" for code, count in sorted(codes.items()))
                return Row(**row, refused=f"{counted or type(error).__name__}: {text[:110]}")
            settings |= dict(remedies)
            reasons |= codes
    settings_text = ", ".join(f"{key}={value}" for key, value in sorted(settings.items()))
    if settings_text:
        settings_text += f" ({', '.join(f'{count} {code}' for code, count in sorted(reasons.items()))})"
    return Row(**row, settings=settings_text, **made, seconds=time.perf_counter() - begin)


def _loads(path):
    with collected_warnings():
        try:
            mujoco.MjModel.from_xml_path(str(path))
        except ValueError:
            return False
    return True


def _made(path, settings):
    """All stages but the cache, and what they are worth; AssemblyError or SourceError where it is refused."""
    plan: Plan = plan_of(source={"kind": "urdf", "path": str(path), **settings})
    with tempfile.TemporaryDirectory() as scratch:
        here = Path(scratch)
        bundle, _ = gather(plan.source, {})
        robot = build_robot(bundle, plan)
        geometry = make_geometry(robot, bundle, plan, lambda kind, key, make: make())
        files = write(robot, here, plan, geometry).files
        checks = checked(here, robot, plan)
        text = bundle.body(bundle.definition)
        apart = parity(text, robot, files, here).worst
        bounds = same_bounds(text, robot, files["robot.urdf"])
        lost = len(lost_names(text, files["robot.urdf"]))
    failed = [f"{check.name}: {check.detail[:100]}" for check in checks if check.fails]
    return {
        "passed": f"{len(checks) - len(failed)}/{len(checks)}",
        "failed": "; ".join(failed[:3]),
        "apart": apart,
        "lost": lost,
        "bounds": "; ".join(bounds[:3]),
    }


if __name__ == "__main__":
    sys.exit(main())
