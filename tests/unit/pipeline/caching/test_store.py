"""The store: whole files only, and harm is a miss."""

import contextlib
import os
import time

import pytest

from linkwright.pipeline.caching.store import STALE, Store
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "cache")


def blob_path(store, digest):
    return store.root / "cas" / digest[:2] / digest


def test_a_blob_lies_under_its_sha256_and_is_read_only(store):
    digest = store.put(b"hello")
    assert digest == sha256(b"hello")
    assert blob_path(store, digest).read_bytes() == b"hello"
    assert blob_path(store, digest).stat().st_mode & 0o777 == 0o444


def test_a_blob_with_other_bytes_than_its_digest_is_missing(store):
    digest = store.put(b"hello")
    blob_path(store, digest).chmod(0o644)
    blob_path(store, digest).write_bytes(b"hullo")
    assert store.get(digest) is None
    assert not store.intact(digest, 5)


def test_putting_a_harmed_blob_again_repairs_it(store):
    digest = store.put(b"hello")
    blob_path(store, digest).chmod(0o644)
    blob_path(store, digest).write_bytes(b"hell")
    store.put(b"hello")
    assert store.get(digest) == b"hello"


def test_a_record_that_is_no_json_object_is_missing(store):
    key = "ab" * 32
    store.publish(key, {"stage": "x"})
    assert store.record(key) == {"stage": "x"}
    for harm in (b"", b'{"stage": "x', b"[1]", b"\xff\xfe"):
        (store.root / "ac" / "ab" / f"{key}.json").write_bytes(harm)
        assert store.record(key) is None


def test_reading_a_record_marks_it_as_used(store):
    key = "ab" * 32
    store.publish(key, {})
    path = store.root / "ac" / "ab" / f"{key}.json"
    os.utime(path, (1, 1))
    store.record(key)
    assert path.stat().st_mtime > time.time() - 60


def test_leftovers_of_killed_processes_are_swept_and_fresh_ones_are_not(store):
    old, fresh, folder = (store.root / "tmp" / name for name in ("old", "fresh", "folder"))
    old.write_bytes(b"")
    fresh.write_bytes(b"")
    folder.mkdir()
    (folder / "inside").write_bytes(b"")
    past = time.time() - STALE - 60
    os.utime(old, (past, past))
    os.utime(folder, (past, past))
    Store(store.root)
    assert [path.name for path in (store.root / "tmp").iterdir()] == ["fresh"]


def test_a_scratch_folder_is_gone_afterwards_also_after_an_error(store):
    with contextlib.suppress(ZeroDivisionError), store.scratch() as folder:
        (folder / "x").write_bytes(b"x")
        assert folder.exists()
        raise ZeroDivisionError
    assert not folder.exists()


def test_a_cache_folder_that_cannot_be_made_is_named_with_a_way_out(tmp_path):
    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(CacheError) as caught:
        Store(tmp_path / "file" / "cache")
    assert str(tmp_path / "file" / "cache") in str(caught.value)
    assert "cache.dir" in str(caught.value)
    assert "LINKWRIGHT_CACHE" in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_cache_folder_that_may_not_be_written_is_named(tmp_path):
    folder = tmp_path / "cache"
    Store(folder)
    (folder / "tmp").chmod(0o555)
    with pytest.raises(CacheError, match="cache"):
        Store(folder)
