"""What starts often imports nothing slow; what a build will need is imported beside the network."""

import sys
from threading import Event
from types import SimpleNamespace

import pytest

from linkwright.pipeline.run.early_imports import EarlyImports
from linkwright.pipeline.stages.stage import STAGES
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment, linkwright
from tests.support.places import PROJECT
from tests.support.processes import python
from tests.unit.pipeline.test_cli import HEAVY


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """Writes modules that can be imported, by their names and texts."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)

    return write


def test_broken_module_stops_no_other_import(modules):
    modules(ahead_one="raise ValueError", ahead_two="runs = 0")
    ahead = EarlyImports({"stage": ["ahead_one", "ahead_missing", "ahead_two"]})
    assert "ahead_two" not in sys.modules
    ahead.wait("stage")
    for _ in range(2):
        ahead.start()
        ahead.wait("stage")
    assert sys.modules.pop("ahead_two").runs == 0


def test_a_stage_waits_for_its_own_modules_alone(modules, monkeypatch):
    gate, ahead = Event(), EarlyImports({"soon": ["ahead_soon"], "later": ["ahead_gated"]})
    monkeypatch.setitem(sys.modules, "ahead_gate", SimpleNamespace(over=lambda: gate.wait(60)))
    modules(ahead_soon="", ahead_gated="import ahead_gate\nended = ahead_gate.over()\n")
    with ahead:
        ahead.start()
        ahead.wait("soon")
        assert sys.modules.pop("ahead_soon")
        assert not hasattr(sys.modules.get("ahead_gated"), "ended")
        gate.set()
        ahead.wait("later")
    assert sys.modules.pop("ahead_gated").ended


def test_end_of_a_build_waits_for_the_running_import(modules, monkeypatch):
    reached, ahead = Event(), EarlyImports({"stage": ["ahead_slow", "ahead_late"]})
    gate = SimpleNamespace(reached=reached.set, over=lambda: ahead.ending.wait(60))
    monkeypatch.setitem(sys.modules, "ahead_gate", gate)
    modules(ahead_slow="import ahead_gate\nahead_gate.reached()\nended = ahead_gate.over()\n", ahead_late="")
    with ahead:
        ahead.start()
        assert reached.wait(60)
    assert sys.modules.pop("ahead_slow").ended
    assert "ahead_late" not in sys.modules


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_modules_imported_ahead_are_those_of_the_stage(stage):
    for module in stage.modules:
        words = module.removeprefix("linkwright.").split(".")
        if words[0] == "stages":
            assert words[1] in (stage.name, "show")
            place = PROJECT.joinpath(*words)
            assert place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()
        else:
            assert words[0] in stage.libraries


@pytest.mark.e2e
def test_unchanged_workspace_imports_no_reader_of_replies(tmp_path):
    """The second build asks whether the workspace changed, and imports nothing for the answer."""
    with OnshapeServer(sample_document()) as server:
        source = ["source=onshape", f"source.url='{server.document_url()}'", "name=arm", "until=graph"]
        environ = environment(tmp_path, **server.environ)
        assert called(tmp_path, *source, environ=environ).returncode == 0
        profiled = linkwright(tmp_path, *source, environ=environ | {"PYTHONPROFILEIMPORTTIME": "1"})
    assert profiled.returncode == 0
    imported = {line.rpartition("|")[2].strip() for line in profiled.stderr.splitlines() if "|" in line}
    assert "linkwright.stages.fetch.onshape.asking.freshness" in imported
    assert not {"networkx", "scipy", "mujoco", "trimesh"} & imported


SEEN = "\nimport sys; print(sorted({!r} & {{*sys.modules}}))"
STANDARD = {"dataclasses", "inspect", "json", "difflib"}
"""Modules of the standard library that would take a third of the time of `--help`."""

FACES = """
from linkwright.pipeline import report, run
from linkwright.pipeline.run import build
from linkwright.pipeline.terminal import progress
from linkwright.stages import export, fetch, graph, mesh, validate
"""


@pytest.mark.parametrize(("code", "heavy"), [
    ("main(['--help'])", HEAVY | STANDARD),
    ("main(['--version'])", HEAVY),
    ("main(['bundle', '--help'])", HEAVY | {"httpx"}),
    ("main(['cache', 'info'])", HEAVY | {"httpx", "stamina", "orjson"}),
    ("main(['-sc', 'query=bash'])", HEAVY),
    ("from linkwright.pipeline import motor_files; motor_files.library()", {"yaml", "pydantic"}),
    (FACES, HEAVY - {"pydantic", "yaml", "jinja2"} | {"httpx"}),
], ids=["help", "version", "help of a verb", "cache", "completion", "motors", "faces of stages"])  # fmt: skip
def test_nothing_heavy_is_imported(code, heavy, tmp_path):
    if code.startswith("main"):
        code = f"from linkwright.pipeline.cli import main; print('exit', {code})"
    done = python(
        "-c", code + SEEN.format(heavy), cwd=tmp_path, COMP_LINE="linkwright root=f", HOME=str(tmp_path)
    )
    assert done.stdout.splitlines()[-1:] == ["[]"], done.stdout + done.stderr
    assert "exit" not in code or "exit 0" in done.stdout
