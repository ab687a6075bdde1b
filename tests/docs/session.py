"""A page as a terminal: a folder, an environment, and the blocks of the page, run one after the other."""

import io
import os
import re
import subprocess
import sys
from contextlib import chdir, redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from unittest.mock import patch

from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, called, environment
from tests.support.users import GLOBAL, write

URL = "https://cad.onshape.com/documents/.../w/.../e/..."
KEYS = re.compile(r"ONSHAPE_ACCESS_KEY=\.\.\.\s+ONSHAPE_SECRET_KEY=\.\.\.")
LIMIT = 900
"""[s] that the commands of a block may take."""

SO101 = """<robot name="so101">
  <link name="base"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="elbow" type="revolute"><parent link="base"/><child link="arm"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
</robot>"""
"""The arm that lies in the folder of each page."""

QUICK = ("until=export", "mesh=hull", "page.preview=none")
"""What makes the build of a snippet quick."""

SHELL = """trap 'env -0 > "$LINKWRIGHT_SHELL.env"; pwd > "$LINKWRIGHT_SHELL.cwd"' EXIT
set -e
"""


class Wrong(AssertionError):
    """A block that does not do what the page shows."""


class Session:
    """Runs blocks in an empty folder below `root`; a context, for as long as its local Onshape runs."""

    def __init__(self, root, cache):
        self.root = root
        self.cache = cache
        self.server = OnshapeServer(sample_document())
        self.names = {"__name__": "__main__"}
        self.folders = 0

    def __enter__(self):
        self.server.__enter__()
        self.environ = environment(self.root, seeded=False, LINKWRIGHT_CACHE=str(self.cache))
        self.environ.pop("LINKWRIGHT_PAGE", None)  # a page as users have it
        self.environ["LINKWRIGHT_HOST"] = self.server.url
        self.environ["PATH"] = f"{COMMAND.parent}{os.pathsep}{self.environ['PATH']}"
        self.environ["COLUMNS"] = "100"
        self.begin_folder()
        return self

    def __exit__(self, *error):
        self.server.__exit__(*error)

    def begin_folder(self):
        """Goes to a new folder, which has only the arm."""
        self.folders += 1
        self.folder = self.here = self.root / f"folder{self.folders}"
        self.here.mkdir()
        (self.here / "so101.urdf").write_text(SO101)

    def run(self, block):
        """Runs a block, unless another test does; the output, of a block that has one."""
        marks = block.marks
        if {"not run", "tested by", "published", "build", "test"} & marks.keys():
            return None
        if "needs" in marks and not find_spec(marks["needs"]):
            return None
        if "your robot" in marks:
            self.add_robot(marks["your robot"])
        if "folder" in marks:
            self.begin_folder()
        if "file" in marks or "add to" in marks:
            return self.save(block)
        run = {
            "sh": self.shell, "console": self.console, "python": self.python, "yaml": self.yaml,
        }.get(block.language)  # fmt: skip
        return run(block) if run else None

    def filled(self, text):
        """The text with the local Onshape in place of the placeholders."""
        keys = self.server.environ
        typed = " ".join(f"{name}={keys[name]}" for name in ("ONSHAPE_ACCESS_KEY", "ONSHAPE_SECRET_KEY"))
        return KEYS.sub(typed, text.replace(URL, self.server.document_url()))

    def add_robot(self, name):
        """Puts a robot from the local Onshape where the reader has one, and the key into the environment."""
        text = f"{GLOBAL}defaults: [override /source: onshape, override /mesh: visual]\n"
        write(self.here, **{name: f"{text}source: {{url: '{self.server.document_url()}'}}\n"})
        self.environ |= self.server.environ

    def save(self, block):
        name = block.marks.get("file") or block.marks["add to"]
        file = self.here / name
        file.parent.mkdir(parents=True, exist_ok=True)
        with file.open("a" if "add to" in block.marks else "w", encoding="utf-8") as stream:
            stream.write(self.filled(block.text))
        if re.fullmatch(r"robot/\w+\.yaml", name):
            self.called(self.here, block, "--cfg", "job", f"robot={file.stem}")

    def shell(self, block):
        status = int(block.marks.get("exit", 0))
        return self._bash(block, block.text, status)

    def console(self, block):
        """Each command with the output below it."""
        steps = re.findall(r"^\$ (.*(?:\n> .*)*)\n((?:(?!\$ ).*\n)*)", block.text, re.MULTILINE)
        for number, (command, shown) in enumerate(steps, 1):
            status = int(block.marks.get("exit", 0)) if number == len(steps) else 0
            compare(block, shown, self._bash(block, command.replace("\n> ", "\n"), status))

    def _bash(self, block, text, status):
        state = self.root / "shell"
        environ = {**self.environ, "LINKWRIGHT_SHELL": str(state)}
        done = subprocess.run(
            ["bash", "-c", SHELL + self.filled(text)], cwd=self.here, env=environ, text=True, timeout=LIMIT,
            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False,
        )  # fmt: skip
        if done.returncode != status:
            raise Wrong(f"{block.place}: exit status {done.returncode}, expected {status}\n{done.stdout}")
        pairs = (entry.partition("=") for entry in Path(f"{state}.env").read_text().split("\0") if entry)
        left_out = {"LINKWRIGHT_SHELL", "_", "SHLVL", "PWD", "OLDPWD"}
        self.environ = {name: value for name, _, value in pairs if name not in left_out}
        self.here = Path(Path(f"{state}.cwd").read_text().removesuffix("\n"))
        return self.shown(done.stdout)

    def shown(self, output):
        """The output as a reader sees it, whose Onshape is not on this computer."""
        return output.replace(self.server.document_url(), URL).replace(str(self.folder), "~")

    def python(self, block):
        output = io.StringIO()
        code = compile(self.filled(block.text), block.place, "exec")
        environ = patch.dict(os.environ, self.environ, clear=True)
        path = patch.object(sys, "path", [str(self.here), *sys.path])
        with chdir(self.here), environ, path, redirect_stdout(output):
            exec(code, self.names)
        return self.shown(output.getvalue())

    def yaml(self, block):
        """Builds a snippet as a part of a robot's file."""
        robot = block.marks.get("robot", "sample")
        if block.text.startswith(GLOBAL):
            text = block.text
        else:
            text = f"{GLOBAL}defaults: [/robot/{robot}, _self_]\n{block.text}"
        folder = self.root / f"snippet{block.line}"
        if "override /robot:" in text:
            write(folder, my_arm=f"{GLOBAL}defaults: [/robot/{robot}, _self_]\n")
            (folder / "experiment").mkdir()
            (folder / "experiment" / "wide.yaml").write_text(self.filled(text))
            choice = "experiment=wide"
        else:
            write(folder, my_arm=self.filled(text))
            choice = "robot=my_arm"
        arguments = ("--cfg", "job") if "composes" in block.marks else QUICK
        self.called(folder, block, *arguments, choice)

    def called(self, folder, block, *arguments):
        done = called(folder, *arguments, environ={**self.environ, "LINKWRIGHT_PAGE": "plain"})
        if done.returncode:
            raise Wrong(f"{block.place}: {' '.join(arguments)}\n{done.stdout}{done.stderr}")


def run(session, blocks):
    """Runs blocks in their order, and compares the outputs that the page shows."""
    output = None
    for block in blocks:
        shows = block.language in ("", "text") and ("output" in block.marks or block.follows)
        if shows and output is not None:
            compare(block, block.text, output)
        elif "output" in block.marks:
            raise Wrong(f"{block.place}: no block before it has an output")
        output = session.run(block) if not shows else output


def compare(block, shown, output):
    """Raises `Wrong` unless the output is what is shown: a line `...` stands for any lines, and `...` in a
    line for any text."""
    lines = [line.rstrip() for line in shown.strip("\n").splitlines()]
    pattern = "".join(r"(?:.*\n)*" if line.strip() == "..." else _line(line) for line in lines)
    text = "".join(f"{line.rstrip()}\n" for line in output.strip("\n").splitlines())
    if not re.fullmatch(pattern, text):
        raise Wrong(f"{block.place}: the page shows\n\n{shown}\nbut the output is\n\n{text}")


def _line(line):
    return r".*".join(map(re.escape, line.split("..."))) + r"\n"
