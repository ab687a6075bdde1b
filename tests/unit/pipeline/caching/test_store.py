"""The store: whole files only, and harm is a miss."""

import contextlib
import os
import time

import pytest

from linkwright.pipeline.caching.store import MAX_TEMPORARY_AGE, Store
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.errors import CacheError

KEY = "ab" * 32


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "cache")


@pytest.fixture
def record(store):
    store.publish(KEY, {"stage": "x"})
    return store.root / "ac" / "ab" / f"{KEY}.json"


@pytest.mark.parametrize("harm", [b"hullo", b"hell"])
def test_a_blob_lies_under_its_sha256_and_a_harmed_one_is_missing(store, harm):
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


def test_reading_a_record_marks_it_as_used_and_what_is_no_object_is_missing(store, record):
    os.utime(record, (1, 1))
    assert store.record(KEY) == {"stage": "x"}
    assert record.stat().st_mtime > time.time() - 60
    for harm in (b"", b'{"stage": "x', b"[1]", b"\xff\xfe"):
        record.write_bytes(harm)
        assert store.record(KEY) is None


def test_leftovers_of_killed_processes_are_swept_and_fresh_ones_are_not(store):
    old, fresh, folder = (store.root / "tmp" / name for name in ("old", "fresh", "folder"))
    folder.mkdir()
    for path in (old, fresh, folder / "inside"):
        path.write_bytes(b"")
    past = time.time() - MAX_TEMPORARY_AGE - 60
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
    for words in (str(tmp_path / "file" / "cache"), "cache.dir", "LINKWRIGHT_CACHE"):
        assert words in str(caught.value)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may write everywhere")
def test_a_cache_folder_that_may_not_be_written_is_named(store):
    (store.root / "tmp").chmod(0o555)
    with pytest.raises(CacheError, match="cache"):
        Store(store.root)
