"""Actions: what is in the key, what is a hit, and what the modes do."""

import json
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from linkwright.pipeline.caching import actions as caching
from linkwright.pipeline.caching.actions import Action, Cache, folder, opened
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.errors import CacheError, ConfigError

ACTION = Action("mesh", 1, {"tolerance": 0.1}, {"robot": "d1"}, {"numpy": "2.0"})


class Maker:
    """Counts how often it is asked."""

    def __init__(self, **files: bytes) -> None:
        self.files = files or {"a": b"alpha", "b": b"beta"}
        self.calls = 0

    def __call__(self) -> dict[str, bytes]:
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


@pytest.mark.parametrize(
    "other",
    [
        Action("export", 1, {"tolerance": 0.1}, {"robot": "d1"}, {"numpy": "2.0"}),
        Action("mesh", 2, {"tolerance": 0.1}, {"robot": "d1"}, {"numpy": "2.0"}),
        Action("mesh", 1, {"tolerance": 0.2}, {"robot": "d1"}, {"numpy": "2.0"}),
        Action("mesh", 1, {"tolerance": 0.1}, {"robot": "d2"}, {"numpy": "2.0"}),
        Action("mesh", 1, {"tolerance": 0.1}, {"robot": "d1"}, {"numpy": "2.1"}),
    ],
    ids=["stage", "version", "config", "input", "library"],
)
def test_the_key_depends_on(other):
    assert other.key != ACTION.key


def test_the_order_of_a_mapping_in_the_configuration_counts():
    one, two = {"*": 1, "elbow": 2}, {"elbow": 2, "*": 1}
    assert Action("graph", 1, {"joints": one}).key != Action("graph", 1, {"joints": two}).key


def test_the_order_of_inputs_and_libraries_does_not_count():
    one = Action("x", 1, None, {"a": "1", "b": "2"}, {"m": "1", "n": "2"})
    two = Action("x", 1, None, {"b": "2", "a": "1"}, {"n": "2", "m": "1"})
    assert one.key == two.key


def test_a_second_run_makes_nothing_and_gives_the_same_files(cache):
    make = Maker()
    first, cached = cache.run(ACTION, make)
    assert not cached
    second, cached = again(cache).run(ACTION, make)
    assert cached
    assert make.calls == 1
    assert dict(first) == dict(second) == {"a": b"alpha", "b": b"beta"}


def test_a_record_holds_stage_version_outputs_and_seconds(cache):
    cache.run(ACTION, Maker())
    record = json.loads(record_path(cache).read_bytes())
    assert record["stage"] == "mesh"
    assert record["version"] == 1
    assert set(record["outputs"]) == {"a", "b"}
    assert record["seconds"] >= 0


def remove(path):
    path.unlink()


def truncate(path):
    path.chmod(0o644)
    path.write_bytes(path.read_bytes()[:-1])


def flip(path):
    path.chmod(0o644)
    path.write_bytes(b"X" + path.read_bytes()[1:])


@pytest.mark.parametrize("harm", [remove, truncate, flip])
def test_a_harmed_blob_is_a_miss_and_is_made_again(cache, harm):
    cache.run(ACTION, Maker())
    harm(blob_of(cache, "b"))
    make = Maker()
    files, cached = again(cache).run(ACTION, make)
    assert not cached
    assert make.calls == 1
    assert files["b"] == b"beta"
    assert again(cache).run(ACTION, make)[1]


@pytest.mark.parametrize(
    "text",
    [
        "",
        "{",
        "[]",
        "{}",
        '{"outputs": {}, "sizes": {}}',
        '{"outputs": {"a": 1}, "sizes": {"a": 1}}',
        '{"outputs": {"a": "x"}}',
    ],
)
def test_a_corrupt_record_is_a_miss(cache, text):
    cache.run(ACTION, Maker())
    record_path(cache).write_text(text)
    make = Maker()
    assert not again(cache).run(ACTION, make)[1]
    assert make.calls == 1


def test_a_blob_lost_between_lookup_and_reading_is_an_error_that_says_it(cache):
    files, _ = cache.run(ACTION, Maker())
    blob_of(cache, "a").unlink()
    with pytest.raises(CacheError, match="a was lost from the cache"):
        files["a"]


def test_an_action_that_fails_leaves_no_record(cache):
    def fail():
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        cache.run(ACTION, fail)
    make = Maker()
    assert not cache.run(ACTION, make)[1]
    assert make.calls == 1


def test_refresh_makes_once_again_and_overwrites(cache):
    cache.run(ACTION, Maker(a=b"old"))
    make = Maker(a=b"new")
    fresh = again(cache, "refresh")
    assert not fresh.run(ACTION, make)[1]
    assert fresh.run(ACTION, make)[1], "within one build the fresh result is as good as any"
    assert make.calls == 1
    assert again(cache).run(ACTION, Maker())[0]["a"] == b"new"


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
    assert caching.folder(str(tmp_path / "plan"), environ) == tmp_path / "plan"
    assert caching.folder(None, environ) == tmp_path / "env"
    assert caching.folder(None, {}).name == "linkwright"


def test_memo_keys_by_kind_key_and_library_and_may_run_inside_an_action(cache):
    asked = []

    def make(memo, kind, key):
        return memo(kind, key, lambda: asked.append((kind, key)) or f"{kind}{key}".encode())

    memo = cache.memo("mesh", 1, {"scipy": "1"})

    def stage():
        return {"hull": make(memo, "hull", {"part": 1}), "weld": make(memo, "weld", {"part": 1})}

    files, _ = cache.run(ACTION, stage)
    assert files["hull"] == b"hull{'part': 1}"
    assert make(memo, "hull", {"part": 1}) == files["hull"]
    assert len(asked) == 2
    make(memo, "hull", {"part": 2})
    make(cache.memo("mesh", 1, {"scipy": "2"}), "hull", {"part": 1})
    assert len(asked) == 4


def test_a_memo_tells_what_was_there_before_and_how_long_it_took_when_it_was_made(cache):
    told, key = [], {"part": 1}

    def slow():
        time.sleep(0.02)
        return b"hull"

    cache.memo("mesh", 1, {}, told.append)("hull", key, slow)
    again(cache).memo("mesh", 1, {}, told.append)("hull", key, slow)
    again(cache, "refresh").memo("mesh", 1, {}, told.append)("hull", key, lambda: b"hull")
    made, kept, refreshed = told
    assert [one.cached for one in told] == [False, True, False]
    assert (kept.kind, kept.key) == ("hull", key)
    assert kept.seconds == made.seconds >= 0.02
    assert refreshed.seconds < made.seconds


@pytest.mark.parametrize("seconds", [None, "long"])
def test_a_record_without_its_seconds_is_a_hit_all_the_same(cache, seconds):
    cache.run(ACTION, Maker())
    record = {**json.loads(record_path(cache).read_bytes()), "seconds": seconds}
    record_path(cache).write_text(json.dumps(record))
    files, cached = again(cache).run(ACTION, Maker())
    assert (files.seconds, cached) == (0.0, True)


def test_a_forced_action_replaces_the_record(cache):
    cache.run(ACTION, Maker(a=b"one"))
    files, cached = cache.run(ACTION, Maker(a=b"two"), force=True)
    assert (dict(files), cached) == ({"a": b"two"}, False)
    files, cached = again(cache).run(ACTION, Maker(a=b"three"))
    assert (dict(files), cached) == ({"a": b"two"}, True)


def test_replies_are_kept_by_request_and_survive_refresh(cache):
    request = "/assemblies/d/x/m/y/e/z?configuration=default"
    assert cache.replies().get(request) is None
    cache.replies().put(request, b"{}")
    assert again(cache, "refresh").replies().get(request) == b"{}"
    assert cache.replies().get(request + "&x=1") is None


def test_a_later_reply_takes_the_place_of_the_first(cache):
    cache.replies().put("/x", b"{}")
    cache.replies().put("/x", b"[]")
    assert again(cache).replies().get("/x") == b"[]"


def test_facts_are_remembered_until_they_change_and_are_no_replies(cache):
    assert cache.replies().recall("/x") is None
    cache.replies().remember("/x", {"microversion": "a"})
    cache.replies().remember("/x", {"microversion": "b", "at": 1.5})
    assert again(cache).replies().recall("/x") == {"microversion": "b", "at": 1.5}
    assert cache.replies().get("/x") is None
    cache.replies().put("/x", b"{}")
    assert cache.replies().recall("/x") == {"microversion": "b", "at": 1.5}


def test_one_at_a_time_is_alone_with_a_subject(cache):
    inside, most = [], []

    def work(_):
        with cache.replies().alone("/x"), cache.replies().alone("/y"):
            inside.append(1)
            most.append(len(inside))
            time.sleep(0.005)
            inside.pop()

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(work, range(8)))
    assert most == [1] * 8


@pytest.mark.parametrize(
    ("configured", "environ", "where"),
    [
        ("~nobody-of-that-name/x", {}, "cache.dir"),
        (None, {"LINKWRIGHT_CACHE": "~nobody-of-that-name/x"}, "LINKWRIGHT_CACHE"),
    ],
)
def test_a_cache_in_the_home_of_nobody_is_refused(configured, environ, where):
    with pytest.raises(ConfigError, match="an unknown user") as caught:
        folder(configured, environ)
    assert caught.value.where == where


def test_what_does_not_last_is_given_and_made_again(cache):
    made = []

    def make():
        made.append(1)
        return {"value": b"by chance"}

    for _ in range(2):
        files, cached = cache.run(ACTION, make, lasts=lambda files: files["value"] != b"by chance")
        assert (files["value"], cached) == (b"by chance", False)
    assert len(made) == 2
