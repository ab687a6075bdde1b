"""Many processes on one cache, and processes that are killed."""

import json
import os
import random
import subprocess
import sys
import time

import pytest

from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store
from linkwright.pipeline.digest import sha256
from tests.support.kill import killed_at
from tests.support.places import PROJECT

WORKER = """
import random, sys
from pathlib import Path
from linkwright.pipeline.caching.actions import Action, Cache
from linkwright.pipeline.caching.store import Store

root, ledger, seed, actions = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
cache = Cache(Store(root))
order = list(range(actions))
random.Random(seed).shuffle(order)
print("ready", flush=True)
for number in order:
    def make():
        with ledger.open("a") as file:
            file.write(f"{number}\\n")
        inner = cache.memo("part", 1, {})("double", {"n": number // 2}, lambda: b"%d" % (number // 2))
        return {"big": b"%d," % number * 200_000, "inner": inner}
    files, _ = cache.run(Action("test", 1, number), make)
    assert files["big"] == b"%d," % number * 200_000
"""


def worker(folder, seed, actions):
    words = [folder / "cache", folder / "ledger", seed, actions]
    return subprocess.Popen(
        [sys.executable, "-c", WORKER, *map(str, words)], cwd=PROJECT, text=True,
        env={**os.environ, "PYTHONPATH": str(PROJECT)}, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip


def assert_whole(root):
    """Every blob has its digest's bytes, and every record's blobs are there."""
    for blob in (root / "cas").glob("*/*"):
        assert sha256(blob.read_bytes()) == blob.name
    cache = Cache(Store(root))
    for record in (root / "ac").glob("*/*.json"):
        json.loads(record.read_bytes())
        assert cache.find(record.stem) is not None


def test_six_processes_make_each_action_once(tmp_path):
    for process in [worker(tmp_path, seed, 12) for seed in range(6)]:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert sorted(map(int, (tmp_path / "ledger").read_text().split())) == list(range(12))
    assert_whole(tmp_path / "cache")


@pytest.mark.slow
def test_writers_killed_at_random_leave_whole_files_and_the_next_finishes(tmp_path):
    chance = random.Random(7)
    for attempt in range(8):
        process = worker(tmp_path, attempt, 200)
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0, 0.15))
        process.kill()
        process.communicate()
        assert_whole(tmp_path / "cache")
    process = worker(tmp_path, 99, 20)
    assert process.wait(timeout=60) == 0
    process.communicate()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_kill_at_every_step_of_an_action_leaves_a_miss_or_a_whole_hit(tmp_path):
    action, outputs = Action("test", 1), {"a": b"alpha" * 100_000, "b": b"beta"}

    def work(root):
        cache = Cache(Store(root))
        cache.run(action, lambda: outputs)
        cache.run(Action("next", 1), lambda: outputs)

    work(tmp_path / "warm")  # so that what is imported late is not counted as a step
    step, outcomes = 1, set()
    while killed_at(step, lambda: work(tmp_path / str(step))):  # noqa: B023
        root = tmp_path / str(step)
        assert_whole(root)
        files = Cache(Store(root)).find(action.key)
        outcomes.add(files is not None)
        assert files is None or dict(files) == outputs
        work(root)
        assert dict(Cache(Store(root)).find(action.key)) == outputs
        step += 1
    assert step > 10
    assert outcomes == {True, False}, "the kills must fall before and after the publication"
