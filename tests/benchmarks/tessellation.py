"""`python -m tests.benchmarks.tessellation`: what triangles cost as tessellated faces and as glTF.

For part studios of several sizes on the local server: bytes as they are and as gzip sends them, CPU
time from the reply to its compact form, the largest memory in use on the way beyond that of the
libraries (the reply included), and how far the mesh is from the true one. Each reading runs in a
process of its own.
"""

import gzip
import json
import resource
import subprocess
import sys
import tempfile
import time
import tracemalloc
from pathlib import Path

import numpy as np

from tests.fake_onshape import solids
from tests.fake_onshape.document import Document
from tests.fake_onshape.frames import frame, turn
from tests.fake_onshape.replies import Replies

SIZES = {"20 parts of 600": (20, 600), "60 parts of 1500": (60, 1500), "1 part of 100000": (1, 100_000)}
_FACES = "tessellatedfaces?outputFaceAppearances=true&outputFacetNormals=false&outputIndexTable="
KINDS = {
    "faces, point table": f"{_FACES}true",
    "faces, loose": f"{_FACES}false",  # should a server not know of tables
    "glTF": "gltf?outputFaceAppearances=true",
}
GOAL_MB, GOAL_S, GOAL_TIMES = 16.0, 1.5, 3.0


def replies(parts, triangles):
    """All kinds of triangles of a studio of balls, and their mass properties."""
    document = Document(f"Balls {parts}")
    studio = document.studio("Balls")
    document.assembly("Empty")
    rings = max(4, round((triangles / 4) ** 0.5))
    for number in range(parts):
        ball = solids.ball(0.02 + 0.0005 * number, segments=2 * rings, rings=rings)
        place = frame((0.1 * number, 0.013 * number, 0.007)) @ turn((1, 2, 3), 0.7)
        studio.part(f"Ball {number}", ball.moved(place), density=1000)
    served = Replies(document)
    path = f"/partstudios/d/{document.id}/m/{document.microversion}/e/{studio.element}"
    bodies = {kind: served.answer(*f"{path}/{asked}".split("?")).body for kind, asked in KINDS.items()}
    return bodies | {"mass": served.answer(f"{path}/massproperties", "massAsGroup=false").body}


def read(folder, kind, traced):
    """What reading the reply of this kind takes; run in a process of its own."""
    from linkwright.stages.fetch.onshape.triangles import faces, gltf_parts
    from linkwright.stages.formats import triangles as codec
    from linkwright.stages.formats.meshes import body_arrays

    mass = (folder / "mass").read_bytes()
    small = replies(2, 60)  # so that imports are not measured
    for data, of in ((small, small["mass"]), (None, mass)):
        if traced and data is None:
            tracemalloc.start()
        resident = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        reply = data[kind] if data else (folder / kind).read_bytes()
        start = time.process_time()
        compact = gltf_parts.compact(reply, of) if kind == "glTF" else faces.compact(reply)
        seconds = time.process_time() - start
    traced_peak = tracemalloc.get_traced_memory()[1] if traced else 0
    return {
        "compact": len(compact),
        "seconds": seconds,
        "resident": 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - resident),
        "traced": traced_peak,
        "bodies": len(codec.ids_with_triangles(compact)),
        "volume": sum(_volume(body) for body in body_arrays.decode(compact).values()),
    }


def _volume(body):
    a, b, c = np.moveaxis((body.points - body.points.mean(axis=0))[body.triangles], 1, 0)
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def main():
    head = f"{'studio':18} {'kind':18} {'MB':>7} {'gzip':>7} {'kept':>7} {'B/tri':>6} {'CPU s':>6}"
    print(f"{head} {'memory':>7} {'resident':>8} {'bodies':>6} {'volume off':>10}")
    for name, (parts, triangles) in SIZES.items():
        with tempfile.TemporaryDirectory() as folder:
            bodies = replies(parts, triangles)
            for kind, body in bodies.items():
                (Path(folder) / kind).write_bytes(body)
            volumes = json.loads(bodies["mass"])["bodies"].values()
            true = sum(record["volume"][0] for record in volumes)
            count = bodies["faces, point table"].count(b'"indices"')
            for kind in KINDS:
                size = len(bodies[kind])
                measured, traced = (_apart(folder, kind, flag) for flag in ("", "traced"))
                print(
                    f"{name:18} {kind:18} {size / 1e6:7.2f} {len(gzip.compress(bodies[kind], 1)) / 1e6:7.2f} "
                    f"{measured['compact'] / 1e6:7.2f} {size / count:6.0f} {measured['seconds']:6.2f} "
                    f"{traced['traced'] / size:6.1f}× {measured['resident'] / size:7.1f}× "
                    f"{measured['bodies']:6.0f} {abs(measured['volume'] / true - 1):10.1e}"
                )
    print(f"goal: a reply of {GOAL_MB:.0f} MB in {GOAL_S} s of CPU and {GOAL_TIMES:.0f}× its size of memory")


def _apart(folder, kind, traced):
    line = [sys.executable, "-m", "tests.benchmarks.tessellation", folder, kind, traced]
    done = subprocess.run(line, capture_output=True, check=True, text=True)
    measured: dict[str, float] = json.loads(done.stdout)
    return measured


if __name__ == "__main__":
    if len(sys.argv) > 1:
        print(json.dumps(read(Path(sys.argv[1]), sys.argv[2], bool(sys.argv[3]))))
    else:
        main()
