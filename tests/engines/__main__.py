"""`python -m tests.engines [NAME ...]`: what engines make of built robots, against MuJoCo of the same robots.

Each engine has an environment of its own, which is made where it is not there, and is given robots that are
built for it. A row says whether the file loads, how far masses, poses of links and a second of motion are
from MuJoCo's, and whether that holds. Ends with exit status 1 where a row that must hold does not: all but
those of `LACKS` in `tests/engines/table.py`.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from tests.engines.builds import built, is_here
from tests.engines.table import ENGINES, LACKS, ROBOTS

HERE = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class Row:
    """`off`: None where there was no number to compare; `why`: what is known of a row that does not hold."""

    engine: str
    version: str
    robot: str
    format: str
    thing: str
    off: float | None
    holds: bool
    said: str
    why: str

    @property
    def wrong(self):
        return not (self.holds or self.why)

    def __str__(self):
        off = "-" if self.off is None else f"{self.off:.1e}"
        end = "holds" if self.holds else "DOES NOT HOLD" if self.wrong else "does not hold"
        if self.holds and self.why:
            end = "holds, where it need not"
        told = "; ".join(filter(None, (self.why, self.said)))
        start = f"{self.engine:12} {self.robot:10} {self.format:6} {self.thing:22} {off:>8}  {end}"
        return f"{start}: {told}" if told else start


def main(given=None):
    parser = argparse.ArgumentParser(prog="python -m tests.engines", description=__doc__)
    names = [engine.name for engine in ENGINES]
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"of {', '.join(names)}; all without any")
    parser.add_argument("--robots", default=",".join(ROBOTS), help=f"some of {', '.join(ROBOTS)}")
    parser.add_argument("--environments", type=Path, help="where environments are, and stay")
    parser.add_argument("--builds", type=Path, help="where built robots are, and stay")
    asked = parser.parse_args(given)
    unknown = {*asked.names} - {*names} | {*asked.robots.split(",")} - {*ROBOTS}
    if unknown:
        parser.error(f"there is no {', '.join(sorted(unknown))}")
    chosen = [engine for engine in ENGINES if engine.name in (asked.names or names)]
    with tempfile.TemporaryDirectory() as scratch:
        environments = asked.environments or Path(scratch) / "environments"
        builds = asked.builds or Path(scratch) / "builds"
        rows = list(_measured(chosen, asked.robots.split(","), environments.resolve(), builds.resolve()))
    wrong = [row for row in rows if row.wrong]
    date = datetime.now(UTC).date()
    print(f"{date}: {len(rows)} rows, {sum(row.holds for row in rows)} hold, {len(wrong)} that must do not")
    return 1 if wrong else 0


def _measured(engines, robots, home, builds):
    for engine in engines:
        if engine.python and f"{sys.version_info.major}.{sys.version_info.minor}" != engine.python:
            print(f"{engine.name}: skipped, it has wheels for Python {engine.python} only", flush=True)
            continue
        python = environment(engine, home)
        for robot in (robot for robot in engine.robots if robot in robots):
            if not is_here(robot):
                print(f"{engine.name} {robot}: skipped, the robot is not here", flush=True)
                continue
            folder = built(robot, engine.keys, builds)
            for row in driven(engine, python, robot, folder):
                print(row, flush=True)
                yield row


def environment(engine, home):
    """The Python of its environment, which is made where it lacks."""
    folder = home / engine.name
    python = folder / "bin" / "python"
    if not python.exists():
        subprocess.run([sys.executable, "-m", "venv", str(folder)], check=True)
        install = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*install, *engine.requirements], check=True)
    return python


def driven(engine, python, robot, folder):
    """What its driver measured; one row of what went wrong where it ended otherwise."""
    out = folder / f"{engine.name}.json"
    out.unlink(missing_ok=True)
    script = HERE / f"drive_{engine.driver}.py"
    command = [str(python), str(script), str(folder), str(folder / "reference.json"), str(out)]
    # Accelerators, where there are some, would be measured in place of the CPU.
    environ = {**os.environ, "JAX_PLATFORMS": "cpu", "CUDA_VISIBLE_DEVICES": ""}
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environ)
    (folder / f"{engine.name}.log").write_text(done.stdout + done.stderr)
    if not out.exists():
        last = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        return [
            _row(engine, "", robot, {"format": "", "thing": "", "off": None, "holds": False, "said": last})
        ]
    found = json.loads(out.read_text())
    return [_row(engine, found["version"], robot, row) for row in found["rows"]]


def _row(engine, version, robot, row):
    place = engine.name, robot, row["format"], row["thing"]
    why = next((lack.why for lack in LACKS if lack.of(place)), "")
    return Row(engine.name, version, robot, **row, why=why)


if __name__ == "__main__":
    sys.exit(main())
