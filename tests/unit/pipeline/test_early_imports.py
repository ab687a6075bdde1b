"""Imports beside the network: begun by the first calls that later stages wait for, and by no others."""

import sys
from threading import Event
from types import SimpleNamespace

import pytest

from linkwright.pipeline.run.early_imports import Ahead
from linkwright.pipeline.stages.stage import STAGES
from tests.fake_onshape.sample import sample_document
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import called, environment, linkwright
from tests.support.places import PROJECT


@pytest.fixture
def modules(tmp_path, monkeypatch):
    """Writes modules that can be imported, by their names and texts."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(**texts):
        for name, text in texts.items():
            (tmp_path / f"{name}.py").write_text(text)

    return write


def test_modules_are_imported_once_and_what_is_wrong_with_one_stops_no_other(modules):
    modules(ahead_one="raise ValueError", ahead_two="runs = 0")
    ahead = Ahead({"stage": ["ahead_one", "ahead_missing", "ahead_two"]})
    assert "ahead_two" not in sys.modules
    ahead.wait("stage")
    for _ in range(2):
        ahead.start()
        ahead.wait("stage")
    assert sys.modules.pop("ahead_two").runs == 0


def test_a_stage_waits_for_its_own_modules_alone(modules, monkeypatch):
    gate, ahead = Event(), Ahead({"soon": ["ahead_soon"], "later": ["ahead_gated"]})
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


def test_a_build_that_ends_waits_for_the_import_that_runs_and_begins_no_other(modules, monkeypatch):
    reached, ahead = Event(), Ahead({"stage": ["ahead_slow", "ahead_late"]})
    gate = SimpleNamespace(reached=reached.set, over=lambda: ahead.ending.wait(60))
    monkeypatch.setitem(sys.modules, "ahead_gate", gate)
    modules(ahead_slow="import ahead_gate\nahead_gate.reached()\nended = ahead_gate.over()\n", ahead_late="")
    with ahead:
        ahead.start()
        assert reached.wait(60)
    assert sys.modules.pop("ahead_slow").ended
    assert "ahead_late" not in sys.modules


@pytest.mark.parametrize("stage", STAGES, ids=lambda stage: stage.name)
def test_what_is_imported_ahead_is_what_the_stage_imports_when_it_runs(stage):
    for module in stage.modules:
        words = module.removeprefix("linkwright.").split(".")
        if words[0] == "stages":
            assert words[1] in (stage.name, "show")
            place = PROJECT.joinpath(*words)
            assert place.with_suffix(".py").is_file() or (place / "__init__.py").is_file()
        else:
            assert words[0] in stage.libraries


@pytest.mark.e2e
def test_only_a_build_that_must_read_replies_imports_what_reads_them(tmp_path):
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
