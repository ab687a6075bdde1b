"""The checkers of other makers, where they are installed, find no error in what a build writes."""

import json
import os
from pathlib import Path

import pytest

from linkwright.stages.validate.external import TOOLS
from tests.support.command import called
from tests.support.other_robots import AS_IT_IS, ROBOTS, is_here, source_of


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_no_checker_finds_an_error(name: str, tmp_path: Path) -> None:
    """Their warnings are in the report, and are no errors."""
    if not is_here(name):
        pytest.skip("needs the robots of others")
    absent = [one.package for one in TOOLS.values() if one.command(os.environ) is None]
    if absent:
        pytest.skip(f"not installed (pip): {' '.join(absent)}")
    wanted = f"validate.external=[{','.join(TOOLS)}]"
    # With hulls, which take seconds: the tools look at one collider as at another.
    called(tmp_path, *source_of(name), "mesh=hull", "validate=quick", wanted, "output=out", *AS_IT_IS)
    (report,) = tmp_path.glob("out*/report.json")
    external = [one for one in json.loads(report.read_text())["checks"] if one["code"] == "C-EXTERNAL"]
    assert len(external) == 4
    assert [one["detail"] for one in external if one["value"] != 0.0] == []
