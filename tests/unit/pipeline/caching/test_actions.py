"""Actions and the store of their files: keys, hits, modes; whole files only, and harm is a miss."""

import contextlib
import json
import os
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from linkwright.pipeline.caching.actions import Action, Cache, folder, opened
from linkwright.pipeline.caching.store import MAX_TEMPORARY_AGE, Store
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError, ConfigError

ACTION = Action("mesh", 1, {"tolerance": 0.1}, {"robot": "d1"}, {"numpy": "2.0"})
DATA = {"a": b"alpha", "b": b"beta"}


class Maker:
    """Counts how often it is asked."""

    def __init__(self, **files):
        self.files = files or DATA
        self.calls = 0

    def __call__(self):
        self.calls += 1
        return self.files


@pytest.fixture
def cache(tmp_path):
    return Cache(Store(tmp_path))


def again(cache, mode="use"):
    """The same cache as another process opens it."""
    return Cache(Store(cache.store.root), mode)


def record_path(cache, action=ACTION):
    return cache.store.root / "ac" / action.key[:2] / f"{action.key}.json"


def blob_of(cache, name):
    digest = json.loads(record_path(cache).read_bytes())["outputs"][name]
    return cache.store.root / "cas" / digest[:2] / digest


def test_key_depends_on_all_but_the_order_of_inputs():
    """The order of a mapping in the configuration counts: globs are read in their order."""
    for change in ({"stage": "export"}, {"version": 2}, {"config": {"tolerance": 0.2}},
                   {"inputs": {"robot": "d2"}}, {"libraries": {"numpy": "2.1"}}):  # fmt: skip
        assert replace(ACTION, **change).key != ACTION.key, change
    first, second = {"*": 1, "elbow": 2}, {"elbow": 2, "*": 1}
    assert Action("graph", 1, {"joints": first}).key != Action("graph", 1, {"joints": second}).key
    first = Action("x", 1, None, {"a": "1", "b": "2"}, {"m": "1", "n": "2"})
    assert first.key == Action("x", 1, None, {"b": "2", "a": "1"}, {"n": "2", "m": "1"}).key


def test_a_second_run_makes_nothing_and_gives_the_same_files(cache):
    make = Maker()
    first, cached = cache.run(ACTION, make)
    assert not cached
    second, cached = again(cache).run(ACTION, make)
    assert (cached, make.calls) == (True, 1)
    assert dict(first) == dict(second) == DATA
    record = json.loads(record_path(cache).read_bytes())
    assert (record["stage"], record["version"], set(record["outputs"])) == ("mesh", 1, {"a", "b"})
    assert record["seconds"] >= 0


def made_again(cache):
    """Whether another process makes the files of the action anew, and then no more."""
    make = Maker()
    files, cached = again(cache).run(ACTION, make)
    return (dict(files), cached, make.calls) == (DATA, False, 1) and again(cache).run(ACTION, make)[1]


@pytest.mark.parametrize("harm", [None, lambda data: data[:-1], lambda data: b"X" + data[1:]])
def test_a_harmed_blob_is_a_miss_and_is_made_again(cache, harm):
    cache.run(ACTION, Maker())
    blob = blob_of(cache, "b")
    data = blob.read_bytes()
    blob.unlink()
    if harm:
        blob.write_bytes(harm(data))
    assert made_again(cache)


@pytest.mark.parametrize("text", [
    "", "{", "[]", "{}", '{"outputs": {}, "sizes": {}}', '{"outputs": {"a": 1}, "sizes": {"a": 1}}',
    '{"outputs": {"a": "x"}}',
])  # fmt: skip
def test_a_corrupt_record_is_a_miss(cache, text):
    cache.run(ACTION, Maker())
    record_path(cache).write_text(text)
    assert made_again(cache)


@pytest.mark.parametrize("seconds", [None, "long"])
def test_a_record_without_its_seconds_is_a_hit_all_the_same(cache, seconds):
    cache.run(ACTION, Maker())
    record = {**json.loads(record_path(cache).read_bytes()), "seconds": seconds}
    record_path(cache).write_text(json.dumps(record))
    files, cached = again(cache).run(ACTION, Maker())
    assert (files.seconds, cached) == (0.0, True)


def test_a_blob_lost_between_lookup_and_reading_is_an_error(cache):
    files, _ = cache.run(ACTION, Maker())
    blob_of(cache, "a").unlink()
    with pytest.raises(CacheError, match="a was lost from the cache"):
        files["a"]


def test_an_action_that_fails_leaves_no_record(cache):
    with pytest.raises(ZeroDivisionError):
        cache.run(ACTION, lambda: 1 / 0)
    assert made_again(cache)


def test_refresh_and_force_make_once_again_and_overwrite(cache):
    cache.run(ACTION, Maker(a=b"old"))
    make = Maker(a=b"new")
    fresh = again(cache, "refresh")
    assert not fresh.run(ACTION, make)[1]
    assert fresh.run(ACTION, make)[1], "within one build the fresh result is as good as any"
    assert make.calls == 1
    assert again(cache).run(ACTION, Maker())[0]["a"] == b"new"
    files, cached = cache.run(ACTION, Maker(a=b"forced"), force=True)
    assert (dict(files), cached) == ({"a": b"forced"}, False)
    files, cached = again(cache).run(ACTION, Maker(a=b"three"))
    assert (dict(files), cached) == ({"a": b"forced"}, True)


def test_bypass_leaves_the_shared_cache_alone(tmp_path):
    shared = tmp_path / "shared"
    with opened("use", str(shared)) as cache:
        cache.run(ACTION, Maker())
    before = sorted(path.name for path in shared.rglob("*"))
    make = Maker(a=b"other")
    with opened("bypass", str(shared)) as cache:
        private = cache.store.root
        assert cache.run(ACTION, make)[0]["a"] == b"other"
        cache.run(Action("y", 1), make)
    assert make.calls == 2
    assert sorted(path.name for path in shared.rglob("*")) == before
    assert not private.exists()


def test_cache_folder_is_that_of_the_plan_first(tmp_path):
    environ = {"LINKWRIGHT_CACHE": str(tmp_path / "env")}
    assert folder(str(tmp_path / "plan"), environ) == tmp_path / "plan"
    assert folder(None, environ) == tmp_path / "env"
    assert folder(None, {}).name == "linkwright"
    nobody = "~nobody-of-that-name/x"
    for key, words in {
        "cache.dir": (nobody, {}),
        "LINKWRIGHT_CACHE": (None, {"LINKWRIGHT_CACHE": nobody}),
    }.items():
        with pytest.raises(ConfigError, match="an unknown user") as caught:
            folder(*words)
        assert caught.value.where == key


def test_memo_depends_on_kind_key_and_library(cache):
    asked = []

    def make(memo, kind, key):
        return memo(kind, key, lambda: asked.append((kind, key)) or f"{kind}{key}".encode())

    memo = cache.memo("mesh", 1, {"scipy": "1"})
    files, _ = cache.run(ACTION, lambda: {kind: make(memo, kind, {"part": 1}) for kind in ("hull", "weld")})
    assert files["hull"] == b"hull{'part': 1}"
    assert make(memo, "hull", {"part": 1}) == files["hull"]
    assert len(asked) == 2
    make(memo, "hull", {"part": 2})
    make(cache.memo("mesh", 1, {"scipy": "2"}), "hull", {"part": 1})
    assert len(asked) == 4


def test_memo_reports_hits_and_seconds(cache):
    hits, key = [], {"part": 1}

    def slow():
        time.sleep(0.02)
        return b"hull"

    cache.memo("mesh", 1, {}, hits.append)("hull", key, slow)
    again(cache).memo("mesh", 1, {}, hits.append)("hull", key, slow)
    again(cache, "refresh").memo("mesh", 1, {}, hits.append)("hull", key, lambda: b"hull")
    made, kept, refreshed = hits
    assert [stage.cached for stage in hits] == [False, True, False]
    assert (kept.kind, kept.key) == ("hull", key)
    assert kept.seconds == made.seconds >= 0.02
    assert refreshed.seconds < made.seconds


def test_replies_and_facts_of_a_request_are_kept_apart(cache):
    request, facts = "/assemblies/d/x/m/y/e/z?configuration=default", {"microversion": "b", "at": 1.5}
    assert cache.replies().get(request) is cache.replies().recall(request) is None
    for last in ({"microversion": "a"}, facts):
        cache.replies().remember(request, last)
    assert again(cache, "refresh").replies().recall(request) == facts
    assert cache.replies().get(request) is None
    for reply in (b"[]", b"{}"):
        cache.replies().put(request, reply)
    assert again(cache, "refresh").replies().get(request) == b"{}"
    assert cache.replies().recall(request) == facts
    assert cache.replies().get(request + "&x=1") is None


def test_a_subject_is_worked_on_by_one_thread_at_a_time(cache):
    inside, most = [], []

    def work(_):
        with cache.replies().lock("/x"), cache.replies().lock("/y"):
            inside.append(1)
            most.append(len(inside))
            time.sleep(0.005)
            inside.pop()

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(work, range(8)))
    assert most == [1] * 8


def test_a_result_that_does_not_last_is_made_again(cache):
    make = Maker(value=b"by chance")
    for _ in range(2):
        files, cached = cache.run(ACTION, make, lasts=lambda files: files["value"] != b"by chance")
        assert (files["value"], cached) == (b"by chance", False)
    assert make.calls == 2


KEY = "ab" * 32


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "cache")


@pytest.fixture
def record(store):
    store.publish(KEY, {"stage": "x"})
    return store.root / "ac" / "ab" / f"{KEY}.json"


@pytest.mark.parametrize("harm", [b"hullo", b"hell"])
def test_harmed_blob_is_missing_until_it_is_put_again(store, harm):
    digest = store.put(b"hello")
    assert digest == sha256(b"hello")
    path = store.root / "cas" / digest[:2] / digest
    assert path.read_bytes() == b"hello"
    assert path.stat().st_mode & 0o777 == 0o444
    path.chmod(0o644)
    path.write_bytes(harm)
    assert store.get(digest) is None
    assert not store.intact(digest, 5)
    store.put(b"hello")
    assert store.get(digest) == b"hello", "to put it again repairs it"


def test_record_is_marked_as_used_when_it_is_read(store, record):
    os.utime(record, (1, 1))
    assert store.record(KEY) == {"stage": "x"}
    assert record.stat().st_mtime > time.time() - 60
    for harm in (b"", b'{"stage": "x', b"[1]", b"\xff\xfe"):
        record.write_bytes(harm)
        assert store.record(KEY) is None


def test_old_leftovers_of_killed_processes_are_removed(store):
    old, fresh, folder = (store.root / "tmp" / name for name in ("old", "fresh", "folder"))
    folder.mkdir()
    for path in (old, fresh, folder / "inside"):
        path.write_bytes(b"")
    past = time.time() - MAX_TEMPORARY_AGE - 60
    os.utime(old, (past, past))
    os.utime(folder, (past, past))
    Store(store.root)
    assert [path.name for path in (store.root / "tmp").iterdir()] == ["fresh"]


def test_scratch_folder_is_gone_after_an_error(store):
    with contextlib.suppress(ZeroDivisionError), store.scratch() as folder:
        (folder / "x").write_bytes(b"x")
        assert folder.exists()
        raise ZeroDivisionError
    assert not folder.exists()


def test_cache_folder_that_cannot_be_made_is_named(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(CacheError) as caught:
        Store(tmp_path / "file" / "cache")
    for words in (str(tmp_path / "file" / "cache"), "cache.dir", "LINKWRIGHT_CACHE"):
        assert words in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_cache_folder_that_may_not_be_written_is_named(store):
    (store.root / "tmp").chmod(0o555)
    with pytest.raises(CacheError, match="cache"):
        Store(store.root)
