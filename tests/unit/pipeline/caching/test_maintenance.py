"""`linkwright cache`: what is told, what is dropped first, and what a harmed disk leaves."""

import os
import time

import pytest

from linkwright.pipeline.caching import maintenance
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.cli import run
from linkwright.pipeline.output.folder import Output
from linkwright.stages.fetch.onshape.api.ledger import Ledger
from tests.support.kill import killed_at

OLD = 100 * 86400.0


@pytest.fixture
def cache(tmp_path):
    return Cache(Store(tmp_path / "cache"))


def age(root, seconds=OLD):
    """Makes everything look as if it was last used that long ago."""
    then = time.time() - seconds
    for path in [*root.glob("ac/*/*"), *root.glob("cas/*/*")]:
        os.utime(path, (then, then))


def make(cache, number, size=1000):
    """An action with one output of its own and one that all share."""
    files, _ = cache.run(
        Action("test", 1, number), lambda: {"own": b"%d," % number * size, "shared": b"shared" * size}
    )
    return files


def kept(cache, number):
    return cache.find(Action("test", 1, number).key) is not None


def test_summary_counts_and_unreadable_records_go_first(cache, tmp_path):
    assert maintenance.summary(tmp_path / "none") == maintenance.CacheSummary(0, 0, 0, 0)
    make(cache, 1)
    make(cache, 2)
    cache.replies().put("/x", b"{}")
    summary = maintenance.summary(cache.store.root)
    assert (summary.blobs, summary.records, summary.replies) == (4, 3, 1)
    assert summary.size > 10_000
    broken = cache.store.root / "ac" / "ab" / "broken.json"
    broken.parent.mkdir(exist_ok=True)
    broken.write_text("{")
    maintenance.collect(cache.store.root, summary.size)
    assert not broken.exists(), "what cannot be read is the first to go"
    assert kept(cache, 1)


def test_least_recently_used_record_goes_first(cache):
    for number in range(4):
        make(cache, number)
    root = cache.store.root
    age(root)
    assert kept(cache, 0)  # which makes it new
    size = maintenance.summary(root).size
    done = maintenance.collect(root, size - 1)
    assert (done.records, done.blobs, done.paid) == (1, 1, 0)
    assert done.size == maintenance.summary(root).size == size - done.freed < size
    done = maintenance.collect(root, 0)
    assert [kept(cache, number) for number in range(4)] == [True, False, False, False]
    assert done.size == maintenance.summary(root).size > 0


def test_what_was_paid_for_goes_last(cache):
    root, replies = cache.store.root, cache.replies()
    replies.put("/x", b"{}" * 1000)
    age(root, 2 * OLD)
    younger = set(root.glob("*/*/*"))
    make(cache, 1)
    then = time.time() - OLD
    for path in set(root.glob("*/*/*")) - younger:
        os.utime(path, (then, then))
    maintenance.collect(root, 5000)
    assert not kept(cache, 1)
    assert replies.get("/x") == b"{}" * 1000
    age(cache.store.root)
    done = maintenance.collect(cache.store.root, 0)
    assert (done.records, done.paid) == (1, 1)
    assert replies.get("/x") is None


def test_what_no_record_names_goes_once_it_is_old(cache):
    root = cache.store.root
    digest = cache.store.put(b"nobody's")
    assert maintenance.collect(root, 10**9).blobs == 0
    age(root)
    assert cache.store.put(b"nobody's") == digest  # a build is about to name it
    assert maintenance.collect(root, 10**9).blobs == 0
    age(root)
    assert maintenance.collect(root, 10**9).blobs == 1
    assert cache.store.get(digest) is None


def test_what_is_harmed_is_found_and_made_again(cache):
    root = cache.store.root
    digest = make(cache, 1).digests["own"]
    make(cache, 2)
    assert maintenance.verify(root) == maintenance.Verification(3, (), 0, 0)
    path = root / "cas" / digest[:2] / digest
    path.chmod(0o644)
    path.write_bytes(path.read_bytes()[:-1] + b"?")
    assert maintenance.verify(root) == maintenance.Verification(3, (digest,), 1, 0)
    assert maintenance.verify(root) == maintenance.Verification(2, (), 0, 0)
    fresh = Cache(Store(root))
    assert make(fresh, 1)["own"].startswith(b"1,1,")
    assert kept(fresh, 2)


def test_a_collection_that_is_killed_leaves_a_cache_that_works(cache):
    root = cache.store.root
    for step in range(1, 200, 7):
        for number in range(3):
            make(Cache(Store(root)), number)
        age(root)
        ended = not killed_at(step, lambda: maintenance.collect(root, 0))
        fresh = Cache(Store(root))
        for number in range(3):
            assert make(fresh, number)["own"].startswith(b"%d," % number)
        if ended:
            break
    assert ended


def test_lock_files_go_where_nobody_holds_them(cache, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LINKWRIGHT_CACHE", str(cache.store.root))
    make(cache, 1)
    output = Output("outputs/arm")
    output.prepare()
    Output("outputs/arm.sweep/job").prepare()
    with cache.store.lock("busy"):
        assert run(["cache", "gc"]) == 0
        assert [path.name for path in tmp_path.rglob("*.lock")] == ["busy.lock"]
    make(cache, 2)
    output.prepare()
    assert len(list(tmp_path.rglob("*.lock"))) == 3


class TestCommand:
    @pytest.fixture(autouse=True)
    def _own_cache(self, tmp_path, monkeypatch):
        monkeypatch.setenv("LINKWRIGHT_CACHE", str(tmp_path / "cache"))

    def test_info_shows_calls_by_a_key_that_is_not_shown(self, cache, tmp_path, capsys):
        assert run(["cache", "info"]) == 0
        assert "no API call counted" in capsys.readouterr().out
        make(cache, 1)
        ledger = Ledger(tmp_path / "cache" / "ledger", "0123456789abcdef", 2026)
        for kind in ("elements", "elements", "massproperties"):
            ledger.note(kind, 200)
        ledger.note("elements", 402)
        assert run(["cache", "info"]) == 0
        shown = capsys.readouterr().out
        assert str(tmp_path / "cache") in shown
        assert "01234567  2026      3  2 elements, 1 massproperties; the quota is used up (402)" in shown
        assert "89abcdef" not in shown

    def test_gc_and_verify_report_their_results(self, cache, tmp_path, capsys):
        digest = make(cache, 1).digests["own"]
        age(cache.store.root)
        assert run(["cache", "gc"]) == 0
        assert "dropped 0 records and 0 files" in capsys.readouterr().out
        path = cache.store.root / "cas" / digest[:2] / digest
        path.chmod(0o644)
        path.write_bytes(b"?")
        assert run(["cache", "verify", f"cache.dir={tmp_path / 'cache'}"]) == 1
        assert digest in capsys.readouterr().out
        assert run(["cache", "verify"]) == 0
        assert "all intact" in capsys.readouterr().out
        make(cache, 1)
        assert run(["cache", "gc", "--max-size=0"]) == 0
        assert "used within the last hour" in capsys.readouterr().out
        age(cache.store.root)
        assert run(["cache", "gc", "--max-size", "1.5k"]) == 0
        assert "dropped 1 record" in capsys.readouterr().out

    @pytest.mark.parametrize("arguments", [
        [], ["clean"], ["info", "gc"], ["gc", "--max-size"], ["gc", "--max-size=big"],
        ["gc", "--max-size=-1G"], ["info", "--max-size=1G"], ["info", "--jsn"],
    ])  # fmt: skip
    def test_wrong_usage_of_cache_ends_with_2(self, arguments, capsys):
        assert run(["cache", *arguments]) == 2
        assert "linkwright cache" in capsys.readouterr().err
        assert run(["cache", "--help"]) == 0
        assert "--max-size" in capsys.readouterr().out
