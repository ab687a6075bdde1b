"""Locks: never for ever in vain, and a wait is told."""

import threading

import pytest

from pipeline import lock
from pipeline.cache import Action, Cache
from pipeline.errors import OutputError
from pipeline.output import Output
from pipeline.store import Store


@pytest.fixture
def _impatient(monkeypatch):
    monkeypatch.setattr(lock, "PATIENCE", 0.05)


@pytest.fixture
def no_lock(tmp_path):
    """The path of a lock file that cannot be made: its place is taken by a folder."""
    path = tmp_path / ".arm.lock"
    path.mkdir()
    return path


def silent():
    pytest.fail("nothing is waited for")


def while_held(path, told, act):
    """Runs `act` while the lock is held elsewhere, until something was told."""
    heard = threading.Event()

    def tell(*line):
        told.extend(line)
        heard.set()

    thread = threading.Thread(target=act, args=(tell,))
    with lock.held(path, silent):
        thread.start()
        assert heard.wait(10)
    thread.join(10)
    assert not thread.is_alive()


def test_a_lock_that_cannot_be_made_is_an_error_at_once(no_lock):
    with pytest.raises(OSError, match="Is a directory"), lock.held(no_lock, silent):
        pass


def test_an_output_whose_lock_cannot_be_made_is_refused(tmp_path, no_lock):
    with pytest.raises(OutputError, match="cannot be written"):
        Output(tmp_path / "arm").prepare()
    assert list(tmp_path.iterdir()) == [no_lock]


def test_a_cache_without_locks_works_all_the_same(tmp_path):
    action = Action("mesh", 1)
    cache = Cache(Store(tmp_path))
    (tmp_path / "locks" / f"{action.key}.lock").mkdir()
    assert cache.run(action, lambda: {"a": b"alpha"})[0]["a"] == b"alpha"


@pytest.mark.usefixtures("_impatient")
def test_a_build_that_waits_for_another_of_its_folder_says_so_and_goes_on(tmp_path):
    told = []
    while_held(tmp_path / ".arm.lock", told, lambda tell: Output(tmp_path / "arm", tell).prepare())
    assert told == ["waiting for another build of arm"]


@pytest.mark.usefixtures("_impatient")
def test_a_build_that_waits_for_the_work_of_another_says_so_and_takes_its_own_turn(tmp_path):
    action, told, made = Action("mesh", 1), [], []
    cache = Cache(Store(tmp_path))

    def act(tell):
        cache.tell = tell
        made.append(cache.run(action, lambda: {"a": b"alpha"}))

    while_held(tmp_path / "locks" / f"{action.key}.lock", told, act)
    assert told == ["waiting for another build of the same mesh"]
    assert made[0][0]["a"] == b"alpha"


def test_a_lock_is_free_again_after_an_error(tmp_path):
    with pytest.raises(ZeroDivisionError), lock.held(tmp_path / "lock", silent):
        raise ZeroDivisionError
    with lock.held(tmp_path / "lock", silent):
        pass
