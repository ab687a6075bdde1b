"""What does not collide and what does, in the report of the sample's build."""

import json

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("contacts")
    told = [
        "robot=sample",
        "mesh=hull",
        "mesh.colliders={Wrist:box}",
        f"output={folder}/out",
        f"cache.dir={folder}/cache",
    ]
    plan = compose_plan(told, cwd=folder).plan
    first = build(plan)
    return first, build(plan), folder / "out"


def test_the_report_has_each_pair_with_its_reason_and_depth(built):
    first, _, folder = built
    rows = json.loads((folder / "report.json").read_text())["details"]["excludes"]
    assert rows == first.details["excludes"]
    known = {tuple(row["links"]): row for row in rows}
    base = known["base_plate", "lift_column"]
    assert base["reason"] == "Adjacent"
    # They overlap by 93 mm along the column; the shortest way apart is across it.
    assert 60 < base["depth"] < 94
    assert {tuple(sorted(joint)) for joint in JOINED} <= {tuple(sorted(pair)) for pair in known}
    page = (folder / "report.html").read_text()
    assert "Links that do not collide" in page
    assert all(name in page for name in ("base_plate", "lift_column", "Adjacent"))


def test_colliders_have_the_time_that_they_took_also_where_they_are_kept(built):
    first, second, folder = built
    before, after = first.details["colliders"], second.details["colliders"]
    assert len(before) == 11
    assert all(row["seconds"] > 0 and not row["cached"] for row in before)
    assert after == [{**row, "cached": True} for row in before]
    assert second.details["links"] == first.details["links"]
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 1  # of the link with a box, which was judged
    assert "0 of 11 colliders made in this build" in page


JOINED = [("lift_column", "turret"), ("elbow_plate", "parallel_rod")]
"""A joint's links, and a loop's."""


def test_an_unchanged_robot_is_not_analysed_again(built):
    first, second, _ = built
    assert all(stage.cached for stage in second.stages if stage.name != "fetch")
    assert second.details["excludes"] == first.details["excludes"]
    assert all(check.passed for check in first.checks)
