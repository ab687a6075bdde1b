"""`python -m tests.benchmarks.peer`: a cold build, side by side with onshape-to-robot.

One robot of 120 parts in 8 part studios, about 600 triangles a part, on one local server that waits
100 ms before each reply. Both commands start as a user starts them, in an empty folder with an empty
cache: `linkwright ... until=export` (URDF and MJCF), and `onshape-to-robot` with its default
configuration (URDF; it cannot write both in one run). Before the clock runs both build once without
waiting, so that the server's own work (its replies are made when first asked for) is no one's time.

Prints wall times (the median where a command ran several times: the peer runs once, since it mostly
waits), the calls that the server counted, what each made, and the ratios; ends with exit status 1
where a goal is missed. `--peer COMMAND` (or ONSHAPE_TO_ROBOT) names an installed peer; else
it is installed from the package index into a folder of its own.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
import venv
import xml.etree.ElementTree as ET
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tests.benchmarks.many_parts import LINKS, PARTS, STUDIOS, many_parts
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, run_in

PEER = "onshape-to-robot==1.8.3"
LATENCY_S = 0.1
TIME_GOAL, CALLS_GOAL = 20, 15


@dataclass(frozen=True)
class Made:
    """One cold build: wall time [s], calls that count, and what its URDF holds."""

    seconds: float
    calls: int
    links: int
    joints: int
    mass: float
    meshes: int


Build = Callable[[OnshapeServer, Path], tuple[list[str], Mapping[str, str], Path]]
"""From a server and an empty folder to the command, its environment, and the URDF that it makes."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--peer", default=os.environ.get("ONSHAPE_TO_ROBOT", ""), help="the peer's command")
    parser.add_argument("--times", type=int, default=5, help="how often we build; the median counts")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        peer = asked.peer or str(install(Path(folder) / "peer"))
        with OnshapeServer(many_parts()) as server:
            ours = measure(server, linkwright, asked.times)
            theirs = measure(server, onshape_to_robot(peer), 1)
    print(f"{PARTS} parts, {STUDIOS} part studios, {LATENCY_S * 1000:.0f} ms latency, cold")
    print(f"{'':20} {'seconds':>8} {'calls':>6} {'links':>6} {'joints':>7} {'meshes':>7} {'mass kg':>9}")
    for name, made in (("linkwright", ours), (PEER.replace("==", " "), theirs)):
        print(
            f"{name:20} {made.seconds:8.2f} {made.calls:6} {made.links:6} {made.joints:7} {made.meshes:7} "
            f"{made.mass:9.4f}"
        )
    time_ratio, calls_ratio = theirs.seconds / ours.seconds, theirs.calls / ours.calls
    print(f"ratio: 1/{time_ratio:.1f} of the time (goal 1/{TIME_GOAL}),", end=" ")
    print(f"1/{calls_ratio:.1f} of the calls (goal 1/{CALLS_GOAL})")
    same = (ours.links, ours.joints) == (theirs.links, theirs.joints) == (LINKS, LINKS - 1)
    if not same or abs(ours.mass - theirs.mass) > 1e-4 * ours.mass:
        print("the two robots are not the same: the comparison means nothing", file=sys.stderr)
        return 1
    return 0 if time_ratio >= TIME_GOAL and calls_ratio >= CALLS_GOAL else 1


def measure(server, build, times):
    """The median of some cold builds, after one that is not measured."""
    server.latency_s = 0.0
    _run(server, build)
    server.latency_s = LATENCY_S
    made = sorted((_run(server, build) for _ in range(times)), key=lambda measured: measured.seconds)
    return made[len(made) // 2]


def _run(server, build):
    server.reset()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        command, environ, urdf = build(server, here)
        start = time.perf_counter()
        done = run_in(here, *command, environ=environ, timeout=3600)
        seconds = time.perf_counter() - start
        if done.returncode or not urdf.is_file():
            msg = f"{command[0]} failed ({done.returncode}):\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
            raise RuntimeError(msg)
        robot = ET.parse(urdf).getroot()
        return Made(
            seconds,
            server.count,
            links=len(robot.findall("link")),
            joints=len(robot.findall("joint")),
            mass=sum(float(mass.get("value")) for mass in robot.iter("mass")),
            meshes=len({mesh.get("filename") for mesh in robot.iter("mesh")}),
        )


def linkwright(server, here):
    """The command, its environment, and the URDF that it makes."""
    source = ["source=onshape", f"source.url='{server.document_url()}'"]
    command = [str(COMMAND), *source, "name=robot", "export=[urdf,mjcf]", "until=export"]
    command += ["mesh=hull", "contact.self=none"]  # the peer makes no colliders of its own
    return command, environment(here, **server.environ), here / "outputs" / "robot" / "robot.urdf"


def onshape_to_robot(command):
    """The same of the peer."""

    def build(server, here):
        home = server.document
        config = {
            "document_id": home.id,
            "workspace_id": home.workspace,
            "element_id": home.root.element,
            "output_format": "urdf",
        }
        (here / "robot").mkdir()
        (here / "robot" / "config.json").write_text(json.dumps(config))
        environ = environment(here, ONSHAPE_API=server.url, **server.environ)
        return [command, "robot"], environ, here / "robot" / "robot.urdf"

    return build


def install(folder):
    """The peer, from the package index, in an environment of its own; its command."""
    venv.create(folder, with_pip=True)
    subprocess.run([str(folder / "bin" / "pip"), "install", "--quiet", PEER], check=True)
    return folder / "bin" / "onshape-to-robot"


if __name__ == "__main__":
    sys.exit(main())
