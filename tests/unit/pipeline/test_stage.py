"""What each stage's result depends on, and how files become values only where they must."""

import json
import re

import pytest

from linkwright.pipeline.caching.actions import Cache
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.config.plan import RUN_KEYS, Plan
from linkwright.pipeline.stages.context import FILES, NOTES, BuildContext, notes
from linkwright.pipeline.stages.stage import STAGES, libraries, stages_until
from linkwright.stages.fetch.section import SOURCES
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.system.install import installed
from linkwright.stages.robot.text.plural import count
from tests.support.places import PROJECT

KEYS_OF_SOURCES = {name for keys in SOURCES.values() for name in keys.model_fields}
URL = f"https://cad.onshape.com/documents/{'d' * 24}/m/{'a' * 24}/e/{'e' * 24}"


def plan(**more):
    return Plan.parse({"name": "arm", "source": {"kind": "sample"}, **more})


def context(tmp_path, the_plan, **outputs):
    made = BuildContext(the_plan, Cache(Store(tmp_path / "cache")), {})
    for stage, files in outputs.items():
        made.files[stage] = made.cache.keep(files)
    return made


@pytest.fixture
def full(tmp_path):
    return context(
        tmp_path,
        plan(),
        fetch={"manifest.json": b"{}", "replies/1": b"1", NOTES: b"f"},
        graph={"robot.json": b"robot", NOTES: b"g"},
        mesh={"geometry.json": b"geometry", "assets/a.stl": b"solid", NOTES: b"m"},
        export={FILES + "arm.urdf": b"<robot/>", NOTES: b"e"},
    )


def imports(folder):
    texts = [path.read_text() for path in folder.rglob("*.py")]
    return {name for text in texts for name in re.findall(r"^ *(?:import|from) (\w+)", text, re.MULTILINE)}


def test_stages_have_versions_and_their_libraries():
    assert [stage.name for stage in STAGES] == ["fetch", "graph", "mesh", "export", "validate"]
    assert [stage.name for stage in stages_until("mesh")] == ["fetch", "graph", "mesh"]
    numeric = {"numpy", "scipy", "trimesh", "networkx", "mujoco"}
    for stage in STAGES:
        assert isinstance(stage.version, int)
        assert "linkwright" in libraries(stage)
        absent = {library for library in stage.libraries if installed(library) == "absent"}
        assert absent <= {"pin"}, "Pinocchio alone is an extra"
        if stage.name != "fetch":
            assert imports(PROJECT / "stages" / stage.name) & numeric <= set(stage.libraries), stage.name
    assert installed("no-such-distribution-as-this") == "absent"


@pytest.mark.parametrize(
    ("change", "touched"),
    [({"joints": {"*": {"damping": 1.0}}}, {"graph"}), ({"root": {"base": "free"}}, {"graph"}),
     ({"name": "leg"}, {"graph"}), ({"ground": {"kind": "none"}}, {"export"}),
     ({"export": {"urdf": {}, "mjcf": None}}, {"export"}), ({"validate": {"level": "quick"}}, {"validate"}),
     ({"output": "elsewhere", "until": "graph", "cache": {"mode": "refresh"}}, set())],
    ids=lambda value: str(value),
)  # fmt: skip
def test_a_key_of_the_configuration_touches_its_own_stage_only(full, tmp_path, change, touched):
    other = context(tmp_path, plan(**change))
    changed = {s.name for s in STAGES[1:] if s.config(full) != s.config(other)}
    assert changed == touched


@pytest.mark.parametrize(("stage", "path", "touched"), [
    ("fetch", "manifest.json", {"graph"}),
    ("graph", "robot.json", {"mesh", "export", "validate"}),
    ("mesh", "assets/a.stl", {"export"}),
    ("export", FILES + "arm.urdf", {"validate"}),
    ("graph", NOTES, set()),
    ("export", NOTES, set()),
])  # fmt: skip
def test_a_file_touches_the_stages_that_read_it(full, stage, path, touched):
    before = {s.name: dict(s.inputs(full)) for s in STAGES[1:]}
    full.files[stage] = full.cache.keep({**full.files[stage], path: b"other"})
    assert {s.name for s in STAGES[1:] if dict(s.inputs(full)) != before[s.name]} == touched


def test_a_workspace_is_asked_again_and_a_version_is_not(tmp_path):
    configs = {}
    for kind in "wvm":
        source = {"kind": "onshape", "url": URL.replace("/m/", f"/{kind}/")}
        configs[kind] = STAGES[0].config(context(tmp_path, plan(source=source)))
    assert configs["w"] is None
    assert configs["v"] is not None
    assert configs["m"] not in (None, configs["v"])


def test_notes_have_what_the_report_shows():
    record = json.loads(notes("2 links", (Diagnostic("W-X", "odd", "a/b", "fix"),), {"links": 2}, calls=3))
    assert record == {
        "summary": "2 links",
        "diagnostics": [{"code": "W-X", "message": "odd", "where": "a/b", "hint": "fix"}],
        "figures": {"links": 2},
        "calls": 3,
    }
    counts = [count(0, "link"), count(1, "link"), count(2, "mesh", "meshes")]
    assert counts == ["0 links", "1 link", "2 meshes"]


VALUES = {
    "cache": {"mode": "refresh"}, "output": "elsewhere", "overwrite": True, "page": {"faces": 7},
    "source.max_calls": 7, "source.max_wait": 7, "source.offline": True, "source.refresh": True,
    "source.stale": True, "source.trust": True,
}  # fmt: skip


@pytest.mark.parametrize("key", [key for key in RUN_KEYS if key.partition(".")[2] in ("", *KEYS_OF_SOURCES)])
def test_how_a_build_is_run_is_no_part_of_a_cache_key(key, tmp_path):
    _, _, name = key.partition(".")
    sources = [{"kind": "sample"}]
    if name:
        (tmp_path / "arm.urdf").write_text('<robot name="arm"><link name="a"/></robot>')
        candidates = [{"kind": "onshape", "url": URL}, {"kind": "urdf", "path": str(tmp_path / "arm.urdf")}]
        sources = [entry for entry in candidates if name in SOURCES[entry["kind"]].model_fields]
    assert sources
    for source in sources:
        more = {} if name else {key: VALUES[key]}
        other = {**source, name: VALUES[key]} if name else source
        first, second = plan(source=source), plan(source=other, **more)
        assert first != second
        keys = [[stage.config(context(tmp_path, plan)) for stage in STAGES] for plan in (first, second)]
        assert keys[0] == keys[1]
