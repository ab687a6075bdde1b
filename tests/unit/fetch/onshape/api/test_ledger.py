"""The count of billed calls: by key and year, over many processes, whatever kills them."""

import json
import os
import stat
import subprocess
import sys

import pytest

from linkwright.stages.fetch.onshape.api.ledger import Ledger, endpoint, years
from tests.support.kill import killed_at
from tests.support.places import PROJECT


def test_a_request_belongs_to_an_endpoint():
    for request, name in (
        ("/assemblies/d/D/w/W/e/E?configuration=a%2Fb", "assembly definition"),
        ("/assemblies/d/D/m/M/e/E/features", "features"),
        ("/assemblies/d/D/m/M/e/E/massproperties?x=1", "assembly massproperties"),
        ("/partstudios/d/D/v/V/e/E/massproperties?massAsGroup=false", "massproperties"),
        ("/partstudios/d/D/v/V/e/E/tessellatedfaces", "tessellatedfaces"),
        ("/parts/d/D/m/M/e/E/partid/J%2F/massproperties", "massproperties"),
        ("/documents/d/D/w/W/currentmicroversion", "currentmicroversion"),
        ("/documents/d/D/m/M/elements", "elements"),
    ):
        assert endpoint(request) == name


def test_billed_calls_count_and_an_empty_quota_is_kept(tmp_path):
    ledger = Ledger(tmp_path / "ledger", "0123456789abcdef", 2026)
    assert ledger.counted() == 0
    for status in (200, 204, 307, 404, 429, 500, 200):
        ledger.note("elements", status, left=8999)
    ledger.note("massproperties", 200)
    state = ledger.read()
    assert (state.counted, state.exhausted) == (5, False)
    assert dict(state.calls) == {"elements": 4, "massproperties": 1}
    ledger.note("elements", 402)
    assert (ledger.counted(), ledger.read().exhausted) == (5, True)
    assert [path.name for path in (tmp_path / "ledger").iterdir()] == ["0123456789abcdef-2026.json"]


def test_keys_and_years_have_ledgers_of_their_own(tmp_path):
    Ledger(tmp_path, "aa", 2025).note("elements", 200)
    Ledger(tmp_path, "aa", 2026).note("elements", 200)
    Ledger(tmp_path, "bb").note("elements", 200)
    (tmp_path / "notes.txt").write_text("not a ledger")
    ledgers = years(tmp_path)
    assert [(year.who, year.counted) for year in ledgers] == [("aa", 1), ("aa", 1), ("bb", 1)]
    assert [year.year for year in ledgers[:2]] == [2025, 2026]
    assert years(tmp_path / "none") == []


def test_a_line_cut_short_or_an_unwritable_ledger_is_no_error(tmp_path):
    ledger = Ledger(tmp_path, "aa", 2026)
    ledger.note("elements", 200)
    path = tmp_path / "aa-2026.json"
    path.write_bytes(path.read_bytes() + b'{"at": 1, "endp')
    ledger.note("elements", 200)
    path.write_bytes(path.read_bytes() + b"[]\n\n7\n")
    assert ledger.counted() == 2
    ledger = Ledger(path / "no folder", "aa")
    ledger.note("elements", 200)
    assert ledger.counted() == 0


@pytest.mark.parametrize(
    ("shared", "mode"), [(0o755, 0o600), (0o700, 0o600), (0o775, 0o660), (0o2770, 0o660)]
)
def test_a_ledger_is_private_unless_a_group_has_the_cache(tmp_path, shared, mode):
    cache = tmp_path / "cache"
    cache.mkdir()
    cache.chmod(shared)
    ledger = Ledger(cache / "ledger", "aa", 2026)
    before = os.umask(0o022)
    try:
        ledger.note("elements", 200)
        path = cache / "ledger" / "aa-2026.json"
        assert stat.S_IMODE(path.stat().st_mode) == mode
        path.chmod(0o644)  # as earlier versions made it
        ledger.note("elements", 200)
    finally:
        os.umask(before)
    assert stat.S_IMODE(path.stat().st_mode) == mode
    assert ledger.counted() == 2


def test_many_processes_lose_no_call(tmp_path):
    code = (
        "import sys; from pathlib import Path\n"
        "from linkwright.stages.fetch.onshape.api.ledger import Ledger\n"
        "ledger = Ledger(Path(sys.argv[1]), 'aa', 2026)\n"
        "for _ in range(200): ledger.note('elements', 200, 17)"
    )
    environ = {**os.environ, "PYTHONPATH": str(PROJECT)}
    running = [subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], env=environ) for _ in range(4)]
    assert [process.wait() for process in running] == [0] * 4
    assert Ledger(tmp_path, "aa", 2026).counted() == 800
    lines = (tmp_path / "aa-2026.json").read_text().splitlines()
    assert all(json.loads(line)["left"] == 17 for line in lines)


def test_a_kill_at_any_moment_leaves_a_ledger_that_counts_on(tmp_path):
    ledger = Ledger(tmp_path / "ledger", "aa", 2026)
    step, ended = 0, False
    while not ended:
        step += 1
        before = ledger.counted()
        ended = not killed_at(step, lambda: ledger.note("elements", 200))
        assert ledger.counted() in (before, before + 1)
    assert step > 1
    before = ledger.counted()
    ledger.note("elements", 200)
    assert ledger.counted() == before + 1
