"""What report.html says of the robot's variants."""

from linkwright.pipeline.page.files import variants
from linkwright.stages.export import export
from linkwright.stages.robot.model.geometry import Geometry
from tests.support.building import plan_of
from tests.unit.export.test_variants import hinges


def test_without_variants_there_is_no_section():
    assert export(hinges(), Geometry((), {}), plan_of()).details.get("variants") is None
    assert variants({}) == ""


def test_each_origin_has_a_row_with_its_share():
    plan = plan_of(actuators={"*": "position"}, variants={"n": 9, "seed": 4})
    details = export(hinges(), Geometry((), {}), plan).details["variants"]
    shown = variants(details)
    assert "9 variants of the seed 4" in shown
    assert shown.index("±10 %") < shown.index("±30 %")
    assert [row["origin"] for row in details["rows"]] == ["source", "estimated"]
    assert "links.base.mass" in shown
    more = len(details["rows"][0]["of"]) - 6
    assert f" and {more} more" in shown
