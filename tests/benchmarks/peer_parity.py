"""`python -m tests.benchmarks.peer_parity`: the same document by us and by onshape-to-robot.

Runs that tool on the local server, on a document that has all its prefixes, for a URDF and an MJCF, and
compares them with our robot: masses, centres of mass, inertia, axes and frames at many values of the
joints. Ends with exit status 1 where they differ by more than its six digits. `--peer
COMMAND` (or ONSHAPE_TO_ROBOT) names an installed peer; else it is installed into a folder of its own.
`--keep` writes its files to tests/unit/graph/onshape/peer_output, where unit tests read them.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

from tests.benchmarks.peer_tools import install
from tests.fake_onshape.prefixed import LIKE_THEIRS, prefixed
from tests.fake_onshape.server import OnshapeServer
from tests.support.building import plan_of, robot_of
from tests.support.command import environment
from tests.support.peer_robots import differences, of_mjcf, of_urdf, ours
from tests.support.places import PROJECT

KEPT = PROJECT / "tests/unit/graph/onshape/peer_output"
FILES = {"urdf": "robot.urdf", "mujoco": "robot.xml"}
CLOSE = 1e-5
"""What six printed digits leave of a length below 1 m, or of a number relative to itself."""


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--peer", default=os.environ.get("ONSHAPE_TO_ROBOT", ""), help="the peer's command")
    parser.add_argument("--keep", action="store_true", help=f"write its files to {KEPT.name}")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        peer = asked.peer or str(install(Path(folder) / "peer"))
        made = {kind: theirs(peer, kind, Path(folder) / kind) for kind in FILES}
    if asked.keep:
        for kind, name in FILES.items():
            (KEPT / name).write_text(made[kind])
    robot = robot_of(prefixed(), plan_of(conventions="onshape_to_robot"))
    rng = np.random.default_rng(0)
    worst: dict[str, float] = {}
    for _ in range(20):
        q = {dof.name: float(rng.uniform(-1, 1)) for dof in robot.dofs}
        seen = ours(robot, q)
        seen.links = {LIKE_THEIRS.get(name, name): link for name, link in seen.links.items()}
        for kind, read in (("urdf", of_urdf), ("mujoco", of_mjcf)):
            for quantity, off in differences(seen, read(made[kind], q)).items():
                worst[quantity] = max(off, worst.get(quantity, 0.0))
    for quantity, off in sorted(worst.items(), key=lambda item: -item[1])[:10]:
        print(f"{off:.1e}  {quantity}")
    print(f"{len(worst)} quantities at 20 configurations, the worst {max(worst.values()):.1e} apart")
    return 0 if max(worst.values()) < CLOSE else 1


def theirs(command, kind, here):
    """What the peer writes in one format."""
    document = prefixed()
    (here / "robot").mkdir(parents=True)
    with OnshapeServer(document) as server:
        config = {
            "document_id": document.id,
            "workspace_id": document.workspace,
            "element_id": document.root.element,
            "output_format": kind,
        }
        (here / "robot" / "config.json").write_text(json.dumps(config))
        environ = environment(here, ONSHAPE_API=server.url, **server.environ)
        done = subprocess.run(
            [command, "robot"], cwd=here, env=environ, capture_output=True, text=True, check=False
        )
    if done.returncode:
        msg = f"{command} failed ({done.returncode}):\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
        raise RuntimeError(msg)
    return (here / "robot" / FILES[kind]).read_text()


if __name__ == "__main__":
    sys.exit(main())
