"""What starts often imports nothing that is slow to import."""

import pytest

from tests.support.processes import python
from tests.unit.pipeline.test_cli import HEAVY

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
