"""The likeliest mistakes of newcomers: the whole message of each, as they see it.

`mistakes.txt` has, for each mistake, the command as it is typed, its exit status and all that it prints but
the progress. `python -m tests.e2e.test_mistakes` writes the file anew: read each message then as someone
would who never saw the program.
"""

import errno
import importlib.util
import os
import re
import shlex
import tempfile
from contextlib import ExitStack
from pathlib import Path
from unittest.mock import patch

import pytest

from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment
from tests.support.kit import SIDE, TOP, Kit, hinged
from tests.support.users import GLOBAL, SAMPLE, URL, put

TEXTS = Path(__file__).with_suffix("").with_name("mistakes.txt")
ONSHAPE = f'{GLOBAL}defaults:\n  - override /source: onshape\nsource:\n  url: "{{url}}"\n'
ROBOT = "robot/my_arm.yaml"
XACRO = '<robot name="arm" xmlns:xacro="http://www.ros.org/wiki/xacro"><link name="base"/></robot>'
EMPTY = '<robot name="arm"><link name="base"/></robot>'
DAE = (
    '<robot name="arm"><link name="base"><visual><geometry><mesh filename="base.dae"/></geometry></visual>'
    "</link></robot>"
)


def arm():
    """A base, and an arm on a hinge with limits."""
    kit = Kit()
    hinged(kit)
    return kit.document


def loose():
    """Two parts without a mate."""
    kit = Kit()
    kit.based("Arm")
    return kit.document


def hollow():
    """An arm of a part without material."""
    kit = Kit()
    base, part = kit.place("Base", fixed=True), kit.root.add(kit.bar("Arm", density=None))
    kit.root.revolute("Elbow", (part, TOP), (base, SIDE), limits=(-1, 1))
    return kit.document


def unlimited():
    """An arm on a hinge without limits."""
    kit = Kit()
    kit.elbow()
    return kit.document


class World:
    """Where a command runs. `here`: an empty folder; `environ`: its environment."""

    def __init__(self, stack, here):
        self._stack, self.here, self.environ = stack, here, environment(here, seeded=False)
        self.server = None

    def serve(self, document, fault=None, **environ):
        """Serves a document, with the right keys but where `environ` has others; gives the server."""
        self.server = self._stack.enter_context(OnshapeServer(document, fault=fault))
        self.environ |= self.server.environ | environ
        return self.server

    def robot(self, document, more="", fault=None, url=None, **environ):
        """Serves a document, and writes the robot `my_arm` that is built from it."""
        server = self.serve(document, fault, **environ)
        self.files({ROBOT: ONSHAPE.format(url=url(server) if url else server.document_url()) + more})

    def files(self, files):
        put(self.here, files)

    def without(self, module):
        """Hides an optional package."""
        find = importlib.util.find_spec

        def hidden(name, *more):
            return None if name == module else find(name, *more)

        self._stack.enter_context(patch("importlib.util.find_spec", hidden))

    def closed(self):
        """Lets nothing make a folder here, as for a user without the permission; root may write anywhere."""
        make = os.mkdir

        def refused(path, *more, **options):
            if Path(path).is_relative_to(self.here / "outputs"):
                raise PermissionError(errno.EACCES, os.strerror(errno.EACCES), str(path))
            return make(path, *more, **options)

        self._stack.enter_context(patch("os.mkdir", refused))

    def before(self, *arguments):
        called(self.here, *arguments, environ=self.environ, status=0)

    def run(self, arguments):
        return called(self.here, *arguments, environ=self.environ)

    def plain(self, text):
        """The text without what differs between runs: the folder, the server's port and the progress; and
        without the robots and motors of the package, which grow."""
        text = text.replace(str(self.here), "HERE")
        if self.server:
            text = text.replace(self.server.url.partition("//")[2], "cad.onshape.com")
        text = re.sub(r"\b(robots|motors): [\w, ]+;", r"\1: ...;", text)
        text = re.sub(r"^(fetch|graph|mesh|export|validate) .*\n+", "", text, flags=re.MULTILINE)
        return text.replace("http://", "https://").strip()


def refusal(status, message, **headers):
    """A server that refuses each call."""
    return lambda *call: Fault(status, f'{{"message": "{message}"}}'.encode(), headers)


def file(text, name=ROBOT):
    return lambda world: world.files({name: text})


def served(document, more="", fault=None, url=None, **environ):
    return lambda world: world.robot(document(), more, fault, url, **environ)


def old_version(world):
    """A build of a version, and then an edit of the document's workspace."""
    world.robot(document := arm(), url=lambda server: server.document_url("v"))
    world.before("robot=my_arm", "until=graph")
    world.server.edit(document.edited("Robot"))


def old_snapshot(world):
    world.files({ROBOT: SAMPLE})
    world.before("snapshot")
    world.files({ROBOT: f"{SAMPLE}mass: {{parts: {{Forearm: {{mass: 0.5}}}}}}\n"})


def old_format(world):
    world.files({ROBOT: SAMPLE})
    world.before("snapshot")
    text = (world.here / "snapshots" / "my_arm.txt").read_text()
    world.files({"snapshots/my_arm.txt": text.replace("linkwright snapshot 1", "linkwright snapshot 0")})


def namesakes(world):
    world.files({"robot/left.yaml": f"{SAMPLE}name: arm\n", "robot/right.yaml": f"{SAMPLE}name: arm\n"})


def without(module, files):
    def prepare(world):
        world.files(files)
        world.without(module)

    return prepare


def tab(kind):
    """The address of the document's tab that is no assembly."""
    return lambda server: server.document_url(element=server.document.studios[0].element)


CAMERA = "into: {name: forarm}, formats: [mjcf], xml: \"<site name='cam'/>\""
WRONG_SECRET = {"ONSHAPE_SECRET_KEY": "not-the-secret-key"}
NO_KEYS = {"ONSHAPE_ACCESS_KEY": "", "ONSHAPE_SECRET_KEY": ""}
PLACES = {
    "no key": served(arm, **NO_KEYS),
    "a wrong key": served(arm, **WRONG_SECRET),
    "a key without the permission": served(arm, fault=refusal(403, "Insufficient permissions.")),
    "a key in the robot's file": file(f"{SAMPLE}source: {{access_key: abc}}\n"),
    "the quota is used up": served(arm, fault=refusal(402, "API call limit exceeded.")),
    "too many calls": served(arm, fault=refusal(429, "Too many requests.", **{"Retry-After": "3600"})),
    "a document that is not shared": served(arm, fault=refusal(404, "Not found.")),
    "a wrong host": file(ONSHAPE.format(url=URL.replace("cad.onshape.com", "cad.onshape.co"))),
    "an address without a tab": file(ONSHAPE.format(url=URL.partition("/e/")[0])),
    "the address of a part studio": served(arm, url=tab("studio")),
    "the address of a version": old_version,
    "an address without quotes": lambda world: None,
    "an address alone": lambda world: None,
    "no mates": served(loose),
    "no material": served(hollow),
    "a joint without limits": served(unlimited),
    "limits in degrees": served(arm, more="joints: {elbow: {limits: [-90, 90]}}\n"),
    "a typo in a joint's glob": served(arm, more="joints: {elbwo: {effort: 3}}\n"),
    "an unknown motor": file(f"{SAMPLE}actuators: {{lift: {{motor: sts3251}}}}\n"),
    "an unknown element": file(f"{SAMPLE}elements: {{cam: {{{CAMERA}}}}}\n"),
    "an unknown key": file(f"{SAMPLE}mesh: {{tolerence: 0.001}}\n"),
    "a tab in YAML": file(f"{SAMPLE}joints:\n\telbow: {{effort: 3}}\n"),
    "no space after a colon": file(f"{SAMPLE}name:my_arm\n"),
    "wrong indentation": file(f"{SAMPLE}mesh:\n  tolerance: 0.001\n max_vertices: 3\n"),
    "a key twice": file(f"{SAMPLE}joints: {{}}\njoints: {{}}\n"),
    "a key without a value": file(f"{SAMPLE}mesh:\njoints:\n  elbow:\n"),
    "no first line": file(SAMPLE.removeprefix(GLOBAL)),
    "a group spelt wrong": file(f"{SAMPLE}  - override /meshes: hull\n"),
    "an option spelt wrong": file(f"{SAMPLE}  - override /mesh: hul\n"),
    "a group without its slash": file(SAMPLE.replace("/source", "source")),
    "a group without override": file(SAMPLE.replace("override /source", "source")),
    "two robots of one name": namesakes,
    "one robot in two folders": lambda world: world.files(
        {"robot/my_arm.yaml": SAMPLE, "ours/robot/my_arm.yaml": SAMPLE}
    ),
    "a robot's name alone": file(SAMPLE),
    "a robot's name spelt wrong": file(SAMPLE),
    "another folder": lambda world: None,
    "a verb that is not needed": file(SAMPLE),
    "dashes in front of a key": file(SAMPLE),
    "spaces around the sign": file(SAMPLE),
    "a space in a path": file(EMPTY, "my arm.urdf"),
    "a file's name spelt wrong": file(EMPTY, "so101.urdf"),
    "an MJCF taken for a URDF": file("<mujoco/>", "arm.xml"),
    "a mesh that is not found": file(DAE.replace("base.dae", "package://so101/base.stl"), "arm.urdf"),
    "an extra that is missing": without("pxr", {}),
    "another extra that is missing": without("collada", {"arm.urdf": DAE, "base.dae": "<COLLADA/>"}),
    "a xacro that is not trusted": file(XACRO, "arm.urdf.xacro"),
    "no write access": lambda world: world.closed(),
    "an old snapshot": old_snapshot,
    "a snapshot of another format": old_format,
    "a view of what is not built": lambda world: None,
}
"""Mistake → what is there when the command is typed."""


def texts():
    """Mistake → the command, and what it answers."""
    entries = TEXTS.read_text(encoding="utf-8").split("\n== ")[1:] if TEXTS.exists() else []
    return {title: text.strip() for title, _, text in (entry.partition("\n") for entry in entries)}


def shown(title, command, here):
    """The command and its answer, as the file has them."""
    with ExitStack() as stack:
        world = World(stack, here)
        PLACES[title](world)
        done = world.run(shlex.split(command)[1:])
        assert "Traceback" not in done.stdout + done.stderr
        text = "\n".join(filter(None, map(world.plain, (done.stdout, done.stderr))))
        return f"$ {command}\n{text}\n(exit status {done.returncode})"


@pytest.mark.parametrize("title", PLACES)
def test_a_mistake_is_answered_with_this_message(tmp_path, title):
    expected = texts()[title]
    command = expected.partition("\n")[0].removeprefix("$ ")
    assert shown(title, command, tmp_path) == expected


def test_each_message_says_what_to_do_and_is_that_of_a_mistake():
    entries = texts()
    assert list(entries) == list(PLACES)
    for title, text in entries.items():
        *lines, status = text.splitlines()
        assert re.fullmatch(r"\(exit status [0-3]\)", status), title
        hints = [line for line in lines if line.startswith(("  →", "    →", "      "))]
        assert hints or title == "the address of a version", title


def _write():
    entries = texts()
    parts = [TEXTS.read_text(encoding="utf-8").partition("\n== ")[0].rstrip()]
    for title in PLACES:
        command = entries[title].partition("\n")[0].removeprefix("$ ")
        with tempfile.TemporaryDirectory() as folder:
            parts.append(f"== {title}\n{shown(title, command, Path(folder))}")
    TEXTS.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


if __name__ == "__main__":
    _write()
