"""What does not collide and what does, in the report of the sample's build."""

import json

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.build import build

pytestmark = pytest.mark.e2e

JOINED = [("lift_column", "turret"), ("elbow_plate", "parallel_rod")]
"""A joint's links, and a loop's."""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The reports of two builds of the sample in one folder, and the folder."""
    folder = tmp_path_factory.mktemp("contacts")
    keys = ["robot=sample", "mesh=hull", "mesh.colliders={Wrist:box}"]
    plan = compose_plan([*keys, f"output={folder}/out", f"cache.dir={folder}/cache"], cwd=folder).plan
    return build(plan), build(plan), folder / "out"


def test_the_report_has_each_pair_with_its_reason_and_depth(built):
    first, _, folder = built
    rows = json.loads((folder / "report.json").read_text())["details"]["excludes"]
    assert rows == first.details["excludes"]
    by_links = {tuple(row["links"]): row for row in rows}
    base = by_links["base_plate", "lift_column"]
    assert base["reason"] == "Adjacent"
    # They overlap by 93 mm along the column; the shortest way apart is across it.
    assert 60 < base["depth"] < 94
    assert set(JOINED) <= {tuple(sorted(pair)) for pair in by_links}
    page = (folder / "report.html").read_text()
    for words in ("Links that do not collide", "base_plate", "lift_column", "Adjacent"):
        assert words in page


def test_an_unchanged_robot_is_not_analysed_again_and_its_colliders_keep_their_time(built):
    first, second, folder = built
    before, after = first.details["colliders"], second.details["colliders"]
    assert len(before) == 11
    assert all(row["seconds"] > 0 and not row["cached"] for row in before)
    assert after == [{**row, "cached": True} for row in before]
    assert second.details["links"] == first.details["links"]
    assert second.details["excludes"] == first.details["excludes"]
    assert all(stage.cached for stage in second.stages if stage.name != "fetch")
    assert all(check.passed for check in first.checks)
    page = (folder / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 1  # of the link with a box, which was judged
    assert "0 of 11 colliders made in this build" in page
