"""Three tools that make a robot of a document in Onshape: how each is installed, and run on the local server.

Each builds as its users build: `linkwright` with a URL, onshape-to-robot with a `config.json`, and
onshape-robotics-toolkit by the script that its own documents show, with sub-assemblies that move.
"""

import json
import os
import subprocess
import venv
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, run_in

ONSHAPE_TO_ROBOT = "onshape-to-robot==1.8.3"
TOOLKIT = "onshape-robotics-toolkit==0.6.0"

SCRIPT = """
import sys
from onshape_robotics_toolkit.connect import Client
from onshape_robotics_toolkit.formats import MJCFSerializer, URDFSerializer
from onshape_robotics_toolkit.graph import KinematicGraph
from onshape_robotics_toolkit.parse import CAD
from onshape_robotics_toolkit.robot import Robot

host, document, workspace, element, kind = sys.argv[1:]
client = Client(base_url=host)
assembly = client.get_assembly(did=document, wtype="w", wid=workspace, eid=element)
cad = CAD.from_assembly(assembly, max_depth=9, client=client)
graph = KinematicGraph.from_cad(cad, use_user_defined_root=True)
robot = Robot.from_graph(graph, client, "robot")
serializer = {"urdf": URDFSerializer, "xml": MJCFSerializer}[kind]()
serializer.save(robot, f"robot.{kind}", download_assets=True)
"""

Command = tuple[list[str], Mapping[str, str], Path]
"""A command, its environment, and the file that it writes."""


@dataclass(frozen=True)
class Tool:
    """A tool: its name, and its command for a server, a folder to work in, and a kind, `urdf` or `xml`."""

    name: str
    command: Callable[[OnshapeServer, Path, str], Command]

    def build(self, server, here, kind):
        """Runs the tool, and returns the file that it wrote; RuntimeError where it wrote none."""
        command, environ, path = self.command(server, here, kind)
        done = run_in(here, *command, environ=environ, timeout=3600)
        if done.returncode or not path.is_file():
            msg = f"{command[0]} failed ({done.returncode}):\n{done.stdout[-2000:]}{done.stderr[-2000:]}"
            raise RuntimeError(msg)
        return path


def linkwright(server, here, kind):
    """Our command, which writes both kinds at once."""
    source = ["source=onshape", f"source.url='{server.document_url()}'"]
    command = [str(COMMAND), *source, "name=robot", "export=[urdf,mjcf]", "until=export"]
    command += ["mesh=hull", "contact.self=none", "page.preview=none"]  # the others fit no colliders
    environ = environment(here, seeded=False, **server.environ)
    return command, environ, here / "outputs" / "robot" / f"robot.{kind}"


def onshape_to_robot(program):
    """The command of onshape-to-robot, which writes one kind a run."""

    def command(server, here, kind):
        home, folder = server.document, f"robot_{kind}"
        config = {
            "document_id": home.id,
            "workspace_id": home.workspace,
            "element_id": home.root.element,
            "output_format": {"urdf": "urdf", "xml": "mujoco"}[kind],
        }
        (here / folder).mkdir(exist_ok=True)
        (here / folder / "config.json").write_text(json.dumps(config))
        environ = environment(here, seeded=False, ONSHAPE_API=server.url, **server.environ)
        return [program, folder], environ, here / folder / f"robot.{kind}"

    return command


def toolkit(python):
    """The command that runs the script of onshape-robotics-toolkit, for one kind a run."""

    def command(server, here, kind):
        (here / "build.py").write_text(SCRIPT)
        home = server.document
        ids = [server.url, home.id, home.workspace, home.root.element]
        environ = environment(here, seeded=False, **server.environ)
        return [python, "build.py", *ids, kind], environ, here / f"robot.{kind}"

    return command


def tools(folder):
    """All three; those of others are installed below the folder, unless ONSHAPE_TO_ROBOT names a command, and
    ONSHAPE_ROBOTICS_TOOLKIT a Python that has the package."""
    program = os.environ.get("ONSHAPE_TO_ROBOT") or str(install(folder / "to_robot"))
    python = os.environ.get("ONSHAPE_ROBOTICS_TOOLKIT") or str(
        _environment(folder / "toolkit", TOOLKIT) / "python"
    )
    return [
        Tool("linkwright", linkwright),
        Tool(ONSHAPE_TO_ROBOT.replace("==", " "), onshape_to_robot(program)),
        Tool(TOOLKIT.replace("==", " "), toolkit(python)),
    ]


def install(folder):
    """Installs onshape-to-robot from the package index into its own environment; returns its command."""
    return _environment(folder, ONSHAPE_TO_ROBOT) / "onshape-to-robot"


def _environment(folder, requirement):
    venv.create(folder, with_pip=True)
    subprocess.run([str(folder / "bin" / "pip"), "install", "--quiet", requirement], check=True)
    return folder / "bin"
