"""Actions: what is in the key, what is a hit, and what the modes do."""

import json
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest

from linkwright.pipeline.caching.actions import Action, Cache, folder, opened
from linkwright.pipeline.caching.store import Store
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


def test_the_key_depends_on_all_but_the_order_of_inputs_and_libraries():
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


def test_bypass_neither_reads_nor_writes_the_shared_cache_and_leaves_nothing(tmp_path):
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


def test_the_plan_wins_over_the_environment_and_that_over_the_platform(tmp_path):
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


def test_memo_keys_by_kind_key_and_library_and_may_run_inside_an_action(cache):
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


def test_a_memo_tells_what_was_there_before_and_how_long_it_took(cache):
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


def test_replies_are_kept_by_request_survive_refresh_and_the_last_counts(cache):
    request = "/assemblies/d/x/m/y/e/z?configuration=default"
    assert cache.replies().get(request) is None
    for reply in (b"[]", b"{}"):
        cache.replies().put(request, reply)
    assert again(cache, "refresh").replies().get(request) == b"{}"
    assert cache.replies().get(request + "&x=1") is None


def test_facts_are_remembered_until_they_change_and_are_no_replies(cache):
    assert cache.replies().recall("/x") is None
    cache.replies().remember("/x", {"microversion": "a"})
    cache.replies().remember("/x", {"microversion": "b", "at": 1.5})
    assert again(cache).replies().recall("/x") == {"microversion": "b", "at": 1.5}
    assert cache.replies().get("/x") is None
    cache.replies().put("/x", b"{}")
    assert cache.replies().recall("/x") == {"microversion": "b", "at": 1.5}


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
