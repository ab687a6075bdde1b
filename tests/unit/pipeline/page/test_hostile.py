"""No name breaks out of a page, and no secret gets into it, wherever these stand."""

import json
from dataclasses import replace

import pytest

from linkwright.pipeline.changes.build_changes import BuildChanges
from linkwright.pipeline.page.document import page
from linkwright.pipeline.page.sweep.document import page as sweep_page
from linkwright.pipeline.report import StageReport
from linkwright.pipeline.secrets import Secrets
from linkwright.stages.mesh.view.views import PICTURES
from linkwright.stages.robot.check import Check, Finding, Table
from linkwright.stages.robot.errors import Diagnostic
from tests.support.page_reader import Reader
from tests.support.places import PROJECT
from tests.unit.pipeline.page.test_colliders import EVERY, PIXEL, SHAPES, Geometry, details
from tests.unit.pipeline.page.test_document import REPORT, SHOWN
from tests.unit.pipeline.page.test_sections import TABLES
from tests.unit.pipeline.page.test_sweep_page import job

HOSTILE = "</script><img src=x onerror=alert(1)>\"'><svg onload=alert(1)>"
SECRET = "s3cr3t-&-value"
KEYS = {"ONSHAPE_SECRET_KEY": SECRET}


def poisoned(value, word):
    """`value` with `word` as a part of every text but of codes, levels and such, which are ours."""
    if isinstance(value, str):
        return f"{value} {word}"
    if isinstance(value, dict):
        return {key: poisoned(item, word) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return type(value)(poisoned(item, word) for item in value)
    return value


def report(word, key):
    """A report that has `word` wherever a text may come from outside, and `key` in paths and versions."""
    table = Table(("point", "what", "", "how"), ((1, word, "missing", word), (2, word, "passed", word)))
    checks = (
        Check(
            f"{word}: reach {word}", False, word, 1.0, 2.0, "C-REACH", "warning", (Finding(word, word, word),)
        ),
        Check(f"a.xml: mass {word}", False, word, code="C-MASS", findings=(Finding(word, word, word),)),
        Check(f"a.xml: sim-readiness {word}", True, word, code="C-READINESS", level="warning", table=table),
    )
    colliders = tuple(replace(figures, link=word, parts=(word,), note=word) for figures in EVERY)
    shapes = tuple(replace(shape, link=word) for shape in SHAPES)
    exclude = {"links": [word, word], "reason": "Always", "depth": 1.0, "colliders": [[word], [word]]}
    reader = {
        "reader": word, "version": "1", "format": "urdf", "thing": word, "does": word, "of": [word],
        "source": word,
    }  # fmt: skip
    return replace(
        REPORT,
        name=word,
        title=word,
        folder=f"outputs/{word}",
        source={"kind": word, "url": f"https://x/{word}"},
        stages=(StageReport("fetch", True, 0.0, word),),
        diagnostics=tuple(Diagnostic(code, word, word, word) for code in ("W-LIMIT", "I-FYI", "E-MASS")),
        checks=checks,
        outline=(word,),
        outputs={f"{key}.urdf": "ab" * 32, f"assets/{key}.stl": "cd" * 32},
        versions={"linkwright": word, key: "1"},
        details={
            **details(Geometry(shapes, {}, colliders=colliders)),
            "excludes": [exclude, exclude | {"reason": "Adjacent"}],
            "order": {
                file: {name: [poisoned(row, word) for row in rows] for name, rows in tables.items()}
                for file, tables in TABLES.items()
            },
            "readers": [reader],
        },
        error={"type": "AssemblyError", "message": word, "where": word, "hint": word, "problems": [
            {"code": "E-MASS", "message": word, "where": word, "hint": word}
        ] * 6},
    )  # fmt: skip


def build_page(word, secrets=None):
    # A file whose path has a secret is never written, and a key that has one is refused.
    key = "key" if secrets else word
    made = report(word, key)
    tables = [
        {"title": title, "header": ["link", "mass"], "rows": [[word, word]]}
        for title in ("Joints", "Masses", "Other")
    ]
    shown = {
        **SHOWN,
        "tables.json": json.dumps(tables),
        PICTURES: json.dumps({"side": 240, "pictures": [{"link": word, "png": PIXEL}], "left_out": [word]}),
    }
    changes = BuildChanges(robot=((f"link {word}", word),), more=3, files=(f"new: {word}",))
    return page(made, shown, dict.fromkeys(made.outputs, 1), Secrets(secrets or {}), changes=changes)


def sweep(word, secrets=None):
    key = "key" if secrets else word
    jobs = [job(n, message=word, **{f"joints.{key}.damping": f"{word}{n}"}) for n in range(3)]
    jobs += [job(3, 1, {}, word, mesh=word)]
    jobs = [
        {**entry, "folder": word, "checks": entry["checks"] and {**entry["checks"], "failed": [word] * 6}}
        for entry in jobs
    ]
    blanked = Secrets(secrets or {})
    return sweep_page(blanked.blanked(word), blanked.within(jobs), lambda _: True, ("summary.json",))


@pytest.mark.parametrize("word", [HOSTILE, "<script>alert(1)</script>"], ids=["markup", "script"])
@pytest.mark.parametrize("made", [build_page, sweep], ids=["build", "sweep"])
def test_a_hostile_name_breaks_out_nowhere(made, word):
    plain, data = made("word"), made(word)
    usual, read = Reader(plain), Reader(data)
    # The same elements, whatever the name is: all of it is text.
    assert [mark for mark in read.marks if mark != "wbr"] == [mark for mark in usual.marks if mark != "wbr"]
    assert word.encode() not in data
    assert b"onerror=alert(1)>" not in data.replace(b"&gt;", b"")
    assert read.text.count(word) >= usual.text.count("word") / 2
    assert not [target for target in read.links if "javascript:" in target]


def test_every_template_escapes_what_it_shows():
    """A template whose name does not say that it is HTML would show a name as it is."""
    names = [path.name for path in (PROJECT / "pipeline" / "page" / "html" / "templates").iterdir()]
    assert len(names) > 15
    assert [name for name in names if not name.endswith(".html.jinja")] == []


@pytest.mark.parametrize("made", [build_page, sweep], ids=["build", "sweep"])
def test_a_secret_gets_nowhere(made):
    assert SECRET in Reader(made(SECRET)).text
    data = made(SECRET, KEYS)
    assert b"s3cr3t" not in data
    assert Reader(data).text.count("***") > 10
