"""`python -m tests.benchmarks.cold`: what a cold build costs beside the network, in time and memory.

Time: a robot of 160 parts in 8 part studios on a local server that waits 100 ms before each reply, from
the command's start to the end of `until=export`, against the bare transfer of the same replies: the
definition, then the others four at a time, by a client that does nothing else (its start does not count).
Both run in turn, and the medians are compared. A build keeps one processor busy all the time, so the ratio
grows with the load of the machine: the least processor time of a build is printed beside it. Memory: the
largest resident size of a whole build of 40 parts with 430,000 triangles.
"""

import argparse
import resource
import statistics
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import httpx
import numpy as np

from tests.benchmarks.many_parts import many_parts
from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame
from tests.fake_onshape.server import OnshapeServer
from tests.support.command import COMMAND, environment, run_in

PARTS, STUDIOS, LINKS, LATENCY_S = 160, 8, 40, 0.1
TIME_GOAL, MEMORY_GOAL_GB = 1.7, 0.6
AT_ONCE = 4

HEAVY_PARTS, HEAVY_STUDIOS, HEAVY_TRIANGLES = 40, 8, 11_000


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--times", type=int, default=5, help="how often both run; the medians count")
    parser.add_argument("--only", choices=["time", "memory"])
    asked = parser.parse_args()
    if asked.only != "memory":
        with OnshapeServer(many_parts(PARTS, STUDIOS, LINKS)) as server:
            _time(server, asked.times)
    if asked.only != "time":
        with OnshapeServer(heavy()) as server:
            _memory(server)


def heavy():
    """A chain of balls of many triangles."""
    document = Document("Heavy")
    homes = [document.studio(f"Studio {number}") for number in range(HEAVY_STUDIOS)]
    root = document.assembly("Robot")
    rings = round((HEAVY_TRIANGLES / 4) ** 0.5)
    last = None
    for number in range(HEAVY_PARTS):
        ball = solids.ball(0.02 + 0.0001 * number, segments=2 * rings, rings=rings)
        part = homes[number % HEAVY_STUDIOS].part(f"Ball {number}", ball, density=1000)
        placed = root.add(part, fixed=last is None)
        if last is not None:
            ends = (placed, np.eye(4)), (last, frame((0.1, 0, 0)))
            root.revolute(f"Joint {number}", *ends, limits=(-1, 1))
        last = placed
    return document


def _time(server, times):
    _build(server, "export")  # so that the server has made its replies, and Python its byte code
    requests = [target for method, target, _ in server.calls if method == "GET"]
    server.latency_s = LATENCY_S
    builds, transfers, busy = [], [], []
    for _ in range(times):
        transfers.append(transfer(server, requests))
        before = _busy()
        builds.append(_build(server, "export"))
        busy.append(_busy() - before)
    build, bare = statistics.median(builds), statistics.median(transfers)
    print(f"{PARTS} parts, {STUDIOS} part studios, {LATENCY_S * 1000:.0f} ms latency, {len(requests)} calls")
    ratio = f"{build / bare:.1f} times (goal {TIME_GOAL})"
    print(f"cold build {build:.2f} s ({min(busy):.2f} s busy), bare transfer {bare:.2f} s: {ratio}")


def _busy():
    """Processor time [s] of all builds so far."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def transfer(server, requests):
    """Seconds until all replies are there, unpacked: the first alone, the others four at a time."""
    limits = httpx.Limits(max_connections=AT_ONCE)
    with httpx.Client(base_url=server.url, auth=server.keys, limits=limits, timeout=60) as client:

        def get(target):
            return len(client.get(target).raise_for_status().content)

        start = time.perf_counter()
        get(requests[0])
        with ThreadPoolExecutor(AT_ONCE) as threads:
            list(threads.map(get, requests[1:]))
        return time.perf_counter() - start


def _memory(server):
    _build(server, "validate")
    largest = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e6
    targets = {target for _, target, _ in server.calls if "tessellatedfaces" in target}
    with httpx.Client(base_url=server.url, auth=server.keys, timeout=60) as client:
        size = sum(len(client.get(target).content) for target in sorted(targets))
    print(f"{size / 1e6:.0f} MB of triangles: at most {largest:.2f} GB resident (goal {MEMORY_GOAL_GB})")


def _build(server, until):
    server.reset()
    with tempfile.TemporaryDirectory() as folder:
        here = Path(folder)
        source = ["source=onshape", f"source.url='{server.document_url()}'"]
        plain = ["mesh=hull", "contact.self=none"]  # what other colliders cost has benchmarks of its own
        line = [str(COMMAND), *source, *plain, "name=robot", "root=fixed", f"until={until}"]
        start = time.perf_counter()
        done = run_in(here, *line, environ=environment(here, **server.environ))
        seconds = time.perf_counter() - start
        if done.returncode not in (0, 3):
            sys.exit(f"the build ended with {done.returncode}:\n{done.stderr}")
        return seconds


if __name__ == "__main__":
    main()
