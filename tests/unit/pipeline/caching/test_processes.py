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


def worker(root, ledger, seed, actions):
    return subprocess.Popen(
        [sys.executable, "-c", WORKER, str(root), str(ledger), str(seed), str(actions)],
        cwd=PROJECT,
        env={**os.environ, "PYTHONPATH": str(PROJECT)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


def assert_whole(root):
    """Every blob has its digest's bytes, and every record's blobs are there."""
    for blob in (root / "cas").glob("*/*"):
        assert sha256(blob.read_bytes()) == blob.name
    cache = Cache(Store(root))
    for record in (root / "ac").glob("*/*.json"):
        json.loads(record.read_bytes())
        assert cache.find(record.stem) is not None


def test_eight_processes_make_each_action_once(tmp_path):
    ledger = tmp_path / "ledger"
    processes = [worker(tmp_path / "cache", ledger, seed, 12) for seed in range(8)]
    for process in processes:
        _, errors = process.communicate(timeout=60)
        assert process.returncode == 0, errors
    assert sorted(map(int, ledger.read_text().split())) == list(range(12))
    assert_whole(tmp_path / "cache")


@pytest.mark.slow
def test_writers_killed_at_random_leave_whole_files_and_the_next_finishes(tmp_path):
    root, ledger = tmp_path / "cache", tmp_path / "ledger"
    chance = random.Random(7)
    for attempt in range(8):
        process = worker(root, ledger, attempt, 200)
        assert process.stdout.readline() == "ready\n"
        time.sleep(chance.uniform(0, 0.15))
        process.kill()
        process.communicate()
        assert_whole(root)
    process = worker(root, ledger, 99, 20)
    assert process.wait(timeout=60) == 0
    process.communicate()


@pytest.mark.slow
@pytest.mark.skipif(not hasattr(os, "fork"), reason="needs fork")
def test_a_kill_at_every_step_of_an_action_leaves_a_miss_or_a_whole_hit(tmp_path):
    action = Action("test", 1)
    outputs = {"a": b"alpha" * 100_000, "b": b"beta"}

    def work(root):
        cache = Cache(Store(root))
        cache.run(action, lambda: outputs)
        cache.run(Action("next", 1), lambda: outputs)

    work(tmp_path / "warm")  # so that what is imported late is not counted as a step
    step, outcomes = 0, set()
    while True:
        step += 1
        root = tmp_path / str(step)
        if not killed_at(step, lambda root=root: work(root)):
            break
        assert_whole(root)
        found = Cache(Store(root)).find(action.key)
        outcomes.add(found is not None)
        assert found is None or dict(found) == outputs
        work(root)
        assert dict(Cache(Store(root)).find(action.key)) == outputs
    assert step > 10
    assert outcomes == {True, False}, "the kills must fall before and after the publication"
