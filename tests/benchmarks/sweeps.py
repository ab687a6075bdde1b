"""`python -m tests.benchmarks.sweeps`: CPU seconds, memory and bytes of the summary of a sweep."""

import random
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.sweep.folder import prepare, write_summaries
from linkwright.pipeline.sweep.outcome import Outcome
from linkwright.pipeline.sweep.outcome_files import leave, outcomes_of
from linkwright.pipeline.sweep.run import Job
from linkwright.pipeline.sweep.terminal_table import table

SIZES = (64, 1_000, 10_000)
FILES = ("summary.html", "summary.csv", "summary.json")


def jobs(root, number):
    """This number of jobs of a sweep over four keys."""
    plan = Plan.parse({"name": "arm", "source": {"kind": "sample"}})
    made = []
    for at in range(number):
        overrides = {
            "vars.upper_arm": f"{0.2 + 0.01 * (at % 10)} m",
            "vars.fore_arm": 0.2 + 0.02 * (at // 10 % 10),
            "mesh": ("hull", "contact", "coacd")[at // 100 % 3],
            "joints.*.damping": round(0.01 * 1.7 ** (at // 300), 6),
        }
        label = " ".join(f"{key}={value}" for key, value in overrides.items())
        folder = root / f"{label.replace(' ', '_').replace('*', '_')[:60]}-{at:08x}"
        made.append(Job(at, label, plan.model_copy(update={"output": str(folder)}), overrides))
    return made


def outcome(job):
    """An outcome of the job: some fail, some miss a check."""
    draw = random.Random(job.number)
    upper = float(str(job.overrides["vars.upper_arm"]).split()[0])
    fore = float(job.overrides["vars.fore_arm"])
    state = draw.choices((0, 3, 1), (93, 5, 2))[0]
    folder, which = str(job.plan.folder), (job.number, job.label)
    if state == 1:
        problems = [f"E-MASS Pin <{draw.randrange(9)}>: no mass"]
        text = f"link_{draw.randrange(9)}: no triangles"
        return Outcome(*which, 1, text, f"{folder}.failed", job.overrides, problems=problems)
    figures = {
        "links": 11,
        "mass": 3.0 + 4 * upper + 3 * fore**2 + draw.gauss(0, 0.02),
        "meshes": draw.randrange(20, 60),
        "triangles": draw.randrange(9_000, 20_000),
        "reach": upper + fore + draw.gauss(0, 0.01),
        "torque_margin": 3.0 / (1 + 8 * upper * fore) + draw.gauss(0, 0.05),
        "steps_per_second": draw.gauss(90_000, 4_000),
    }
    failed = ["arm.xml: C-MASS"] if state == 3 else []
    warned = ["arm.xml: C-REACH"] if draw.random() < 0.2 else []
    checks = {"passed": 41 - len(failed), "warned": warned, "failed": failed}
    message = "a check failed" if state == 3 else "valid"
    calls = {"made": 0, "saved": 11}
    return Outcome(*which, state, message, folder, job.overrides, figures, checks, calls)


def sweep(root, number):
    """Prepares the folder of a sweep whose jobs have all left their outcome."""
    made = jobs(root, number)
    prepare(root, made, ["-m"], {"LINKWRIGHT_PAGE": "plain"})
    for job in made:
        leave(outcome(job), job.plan.folder)
    return made


def peak():
    """The most memory [MB] that this process had. What `getrusage` says may be its parent's."""
    try:
        lines = Path("/proc/self/status").read_text().splitlines()
    except OSError:
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return next(int(line.split()[1]) / 1024 for line in lines if line.startswith("VmHWM"))


def measure(number):
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "arm.sweep"
        start = time.process_time()
        sweep(root, number)
        left = time.process_time()
        outcomes = list(outcomes_of(root))
        read = time.process_time()
        write_summaries(outcomes, root)
        kept = time.process_time()
        table(outcomes, root, 100)
        sizes = [(root / name).stat().st_size / 1e6 for name in FILES]
    memory = peak()
    times = (left - start, read - left, kept - read, time.process_time() - kept, memory)
    print(f"{number:6}" + "".join(f"{value:9.2f}" for value in (*times, *sizes)))


def main():
    if len(sys.argv) > 1:
        measure(int(sys.argv[1]))
        return
    print("  jobs   left, s read, s  kept, s table, s   MB RAM  html, MB  csv, MB  json, MB")
    for number in SIZES:
        # In a process of its own, whose memory is that of this sweep.
        subprocess.run([sys.executable, "-m", "tests.benchmarks.sweeps", str(number)], check=True)


if __name__ == "__main__":
    main()
