"""The checkers of other makers, where they are installed, find no error in what a build writes."""

import json
import os

import pytest

from linkwright.stages.validate.external import TOOLS
from linkwright.stages.validate.external.run import TOOL_USES
from tests.support.command import called
from tests.support.other_robots import AS_IT_IS, ROBOTS, is_here, source_of


@pytest.mark.slow
@pytest.mark.parametrize("name", ROBOTS)
def test_no_checker_finds_an_error(name, tmp_path):
    """Their warnings are in the report, and are no errors."""
    if not is_here(name):
        pytest.skip("needs the robots of others")
    present = [tool for tool in TOOLS.values() if tool.command(os.environ) is not None]
    if not present:
        pytest.skip("no checker is installed (pip)")
    wanted = f"validate.external=[{','.join(tool.name for tool in present)}]"
    formats = "export=[urdf,mjcf,usd]" if TOOLS["simready"] in present else "export=[urdf,mjcf]"
    # With hulls, which take seconds: the tools look at one collider as at another.
    called(
        tmp_path, *source_of(name), "mesh=hull", "validate=quick", wanted, formats, "output=out", *AS_IT_IS
    )
    (report,) = tmp_path.glob("out*/report.json")
    external = [check for check in json.loads(report.read_text())["checks"] if check["code"] == "C-EXTERNAL"]
    assert len(external) == sum(len(TOOL_USES[tool.name].endings) for tool in present)
    assert [entry["detail"] for entry in external if entry["value"] != 0.0] == []
