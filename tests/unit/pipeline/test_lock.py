"""Locks: never for ever in vain, and a wait is told."""

import threading

import filelock
import pytest

from linkwright.pipeline import lock
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.errors import OutputError
from linkwright.pipeline.output.folder import Output


@pytest.fixture
def _impatient(monkeypatch):
    monkeypatch.setattr(lock, "PATIENCE", 0.05)


@pytest.fixture
def no_lock(tmp_path):
    """The path of a lock file that cannot be made: its place is taken by a folder."""
    path = tmp_path / lock.FOLDER / "arm.lock"
    path.mkdir(parents=True)
    return path


def silent():
    pytest.fail("nothing is waited for")


def while_held(path, shown, act):
    """Runs `act` while the lock is held elsewhere, until something was told."""
    heard = threading.Event()

    def tell(*line):
        shown.extend(line)
        heard.set()

    thread = threading.Thread(target=act, args=(tell,))
    with lock.acquired(path, silent):
        thread.start()
        assert heard.wait(10)
    thread.join(10)
    assert not thread.is_alive()


def test_lock_that_cannot_be_made_is_an_error_at_once(tmp_path, no_lock):
    with pytest.raises(OSError, match="Is a directory"), lock.acquired(no_lock, silent):
        pass
    with pytest.raises(OutputError, match="cannot be written"):
        Output(tmp_path / "arm").prepare()
    assert list(tmp_path.rglob("*")) == [no_lock.parent, no_lock]
    action, cache = Action("mesh", 1), Cache(Store(tmp_path))
    (tmp_path / "locks" / f"{action.key}.lock").mkdir()
    assert cache.run(action, lambda: {"a": b"alpha"})[0]["a"] == b"alpha", "a cache works without locks"


@pytest.mark.usefixtures("_impatient")
def test_wait_for_another_build_of_the_folder_is_reported(tmp_path):
    """And a folder that another build moves in is not judged half way."""
    output = Output(tmp_path / "arm")
    output.prepare()
    for path, act in (
        (lock.beside(output.target), lambda tell: Output(output.target, tell).prepare()),
        (lock.lock_path(output.target), lambda tell: Output(output.target, tell).judge()),
    ):
        shown = []
        while_held(path, shown, act)
        assert shown == ["waiting for another build of arm"]


@pytest.mark.usefixtures("_impatient")
def test_wait_for_the_same_stage_elsewhere_is_reported(tmp_path):
    action, shown, made = Action("mesh", 1), [], []
    cache = Cache(Store(tmp_path))

    def act(tell):
        cache.on_wait = tell
        made.append(cache.run(action, lambda: {"a": b"alpha"}))

    while_held(tmp_path / "locks" / f"{action.key}.lock", shown, act)
    assert shown == ["waiting for another build of the same mesh"]
    assert made[0][0]["a"] == b"alpha"


@pytest.mark.parametrize("where", ["file", "folder"])
def test_lock_that_is_a_link_is_refused(tmp_path, where):
    (tmp_path / "mine").mkdir()
    target = tmp_path / "mine" / "arm.lock"
    target.write_text("mine")
    if where == "file":
        (tmp_path / lock.FOLDER).mkdir()
        (tmp_path / lock.FOLDER / "arm.lock").symlink_to(target)
    else:
        (tmp_path / lock.FOLDER).symlink_to(tmp_path / "mine")
    with pytest.raises(OutputError, match="cannot be written"):
        Output(tmp_path / "arm").prepare()
    assert target.read_text() == "mine"


def test_lock_file_is_dropped_only_while_nobody_holds_it(tmp_path):
    path = lock.beside(tmp_path / "arm")
    with lock.acquired(path, silent):
        assert not lock.drop(path)
    assert path.exists()
    for dropped in (True, False):
        assert lock.drop(path) == dropped
        assert not path.exists(), "what is not there is not made"


def test_a_lock_keeps_its_mode_and_is_free_again_after_an_error(tmp_path):
    path = tmp_path / "shared.lock"
    path.touch()
    path.chmod(0o664)
    with pytest.raises(ZeroDivisionError), lock.acquired(path, silent):
        raise ZeroDivisionError
    with lock.acquired(path, silent):
        pass
    assert path.stat().st_mode & 0o777 == 0o664


def test_lock_removed_meanwhile_is_acquired_again(tmp_path, monkeypatch):
    path = tmp_path / "arm.lock"
    acquire, removed = filelock.FileLock.acquire, []

    def late(self, *arguments, **more):
        handle = acquire(self, *arguments, **more)
        if not removed:
            # As by one that had it just before, and removed it while this one was about to take it.
            path.unlink()
            removed.append(path)
        return handle

    monkeypatch.setattr(filelock.FileLock, "acquire", late)
    with lock.acquired(path, silent):
        assert removed
        assert path.exists()
        assert not lock.drop(path)
