"""The table of sources: a new one is a folder and a line, and no room knows another."""

import ast
import subprocess
import sys

import pytest

from linkwright.stages.fetch import sources
from linkwright.stages.fetch.section import SOURCES
from tests.support.places import PROJECT

FETCH = PROJECT / "stages" / "fetch"

TOY_SECTION = """
from typing import Literal
from linkwright.stages.fetch.source_section import SourceSection
from linkwright.stages.robot.section import Text

class ToySourceSection(SourceSection):
    kind: Literal["toy"] = "toy"
    path: Text
"""
TOY_SOURCE = """
from linkwright.stages.fetch.robot_file import RobotFileSource
from linkwright.stages.fetch.source import Fetched
from linkwright.stages.robot.bundle import FileBundle

class ToySource(RobotFileSource):
    description, example = "a toy is a file", "robots/arm.toy"

    def pinned(self, environ):
        return {"kind": "toy", "path": self._keys.path}

    def fetch(self, context):
        return Fetched(FileBundle("toy", {"document": "arm.toy"}, "d", {"model": "d"}, {"d": b"toy"}))
"""
TOY_BUILD = """
import linkwright.stages.fetch as stage
from linkwright.stages.fetch import sources
from toyroom.source import ToySource
sources.SOURCES["toy"] = lambda: ToySource
from types import SimpleNamespace
from toyroom.section import ToySourceSection
from linkwright.stages.fetch.source import FetchContext

plan = SimpleNamespace(source=ToySourceSection(path="arm.toy"))
stage.preflight(plan, {})
fetched = stage.fetch(plan, FetchContext({}, {}))
print(stage.pinned(plan), stage.spends(plan), stage.describe(plan), stage.summary(fetched.bundle))
"""


def test_a_new_source_is_one_folder_and_one_line(tmp_path):
    room = tmp_path / "toyroom"
    room.mkdir()
    (room / "__init__.py").touch()
    (room / "section.py").write_text(TOY_SECTION)
    (room / "source.py").write_text(TOY_SOURCE)
    (tmp_path / "arm.toy").touch()
    environ, command = {"PYTHONPATH": f"{PROJECT}:{tmp_path}"}, [sys.executable, "-c", TOY_BUILD]
    run = subprocess.run(command, cwd=tmp_path, env=environ, capture_output=True, text=True)
    words = "{'kind': 'toy', 'path': 'arm.toy'} False {'kind': 'toy'} arm.toy and 0 meshes"
    assert (run.stdout.strip(), run.stderr) == (words, "")


def test_each_source_has_its_keys_and_its_preset():
    assert list(SOURCES) == list(sources.SOURCES)
    presets = {path.stem for path in (PROJECT / "conf" / "source").glob("*.yaml")}
    assert presets == set(SOURCES)
    for kind, keys in SOURCES.items():
        assert keys.model_fields["kind"].default == kind
        assert sources.source_class(kind).__module__ == keys.__module__.replace(".section", ".source")


@pytest.mark.parametrize("room", ["onshape", "urdf", "mjcf", "bundle"])
def test_no_room_imports_another(room):
    rooms = {"onshape", "urdf", "mjcf", "bundle"} - {room}
    for path in (FETCH / room).rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ImportFrom | ast.Import):
                names = [getattr(node, "module", None) or "", *(alias.name for alias in node.names)]
                pieces = [name.removeprefix("linkwright.").split(".") for name in names]
                assert not [p for p in pieces if p[:2] == ["stages", "fetch"] and rooms & {*p[2:3]}], path
