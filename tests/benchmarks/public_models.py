"""`python -m tests.benchmarks.public_models DIR... [--build]`: what `linkwright check` finds in public files.

For each URDF and MJCF below the folders, without the parts that other files include: the codes of what does
not pass, with the number of findings; errors have capitals. `--findings` prints each finding too. Findings
that were looked at are in public_models.yaml, as true or as a false alarm; the others are printed. With
`--build` also what a build of the same file says, with servos where the file is a URDF: the errors that
refuse it, or its checks that fail; and how many links and joints of a URDF lose their names. Ends with exit
status 1 where a check gives no verdict, a finding is a false alarm or was not looked at, a name is lost, or a
build and a check do not say the same: one of them has errors and the other has none. A file without a body
is no robot to a build, and a right file to a check.
"""

import argparse
import re
import sys
import tempfile
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

import linkwright
from linkwright.pipeline.checking.ask import checked
from linkwright.pipeline.errors import OutputError
from linkwright.stages.robot.check import Check
from tests.benchmarks.judged import judged, judgements, level_of, lines_of
from tests.support.urdfs import lost_names

_MODEL = re.compile(r"<(mujoco|robot)[\s>]")
NO_ROBOT = "no body"
"""What a build says of a file in which nothing can move, as an arena."""

_INCLUDE = re.compile(r"""<include\s[^>]*file=["']([^"']+)["']""")


@dataclass(frozen=True, slots=True)
class Row:
    """The outcome for a model. `checks`: those that do not pass; `unread`: why there is no verdict;
    `refused`: the codes of the errors for which the build ended, `failed`: those of the checks of the build
    that failed; `built`: whether a build was tried; `lost`: names of links and joints that the new URDF
    lacks. `alarms`: findings that are false alarms, or were not looked at."""

    name: str
    checks: tuple[Check, ...] = ()
    unread: str = ""
    built: bool = False
    refused: tuple[str, ...] = ()
    failed: tuple[str, ...] = ()
    lost: tuple[str, ...] = ()
    alarms: tuple[str, ...] = ()

    @property
    def codes(self):
        """The number of findings by code, and whether it is an error."""
        numbers: Counter[tuple[str, bool]] = Counter()
        for check in self.checks:
            numbers[check.code, check.fails] += max(1, len(check.findings))
        return numbers

    @property
    def agrees(self):
        """Whether a build and a check both have errors, or neither; of what is no robot a build says
        nothing."""
        return (
            not self.built
            or self.refused == (NO_ROBOT,)
            or bool(self.refused or self.failed) == any(check.fails for check in self.checks)
        )

    def __str__(self):
        words = self.unread or " ".join(
            f"{code if wrong else code.lower()}×{count}"
            for (code, wrong), count in sorted(self.codes.items())
        )
        line = f"{self.name:60} {words or 'passes'}"
        if self.built:
            said = f"refused: {' '.join(self.refused)}" if self.refused else " ".join(self.failed) or "builds"
            line += f" | {said}{'' if self.agrees else ' | NOT THE SAME'}"
        return f"{line} | lost: {', '.join(self.lost)}" if self.lost else line


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("folders", nargs="+", type=Path, metavar="DIR")
    parser.add_argument("--only", default="", help="models whose path has this in it")
    parser.add_argument("--build", action="store_true", help="also builds each")
    parser.add_argument("--findings", action="store_true", help="prints each finding")
    asked = parser.parse_args()
    rulings, rows = judgements(), []
    with tempfile.TemporaryDirectory() as scratch:
        for name, path in models(asked.folders):
            if asked.only not in str(path):
                continue
            rows.append(_row(name, path, Path(scratch), asked.build, rulings))
            print(rows[-1], flush=True)
            if asked.findings:
                for check in rows[-1].checks:
                    print("\n".join(f"    {line}" for line in _lines(check)), flush=True)
            for line in rows[-1].alarms:
                print(f"    {line}", flush=True)
    return _summary(rows)


def models(folders):
    """The models below the folders, each with its name, without the parts that others include."""
    for folder in folders:
        texts = {
            path: path.read_text(errors="replace")
            for path in sorted(folder.rglob("*"))
            if path.suffix in (".urdf", ".xml", ".mjcf") and path.is_file()
        }
        parts = {
            (path.parent / name).resolve() for path, text in texts.items() for name in _INCLUDE.findall(text)
        }
        for path, text in texts.items():
            if _MODEL.search(text) and path.resolve() not in parts:
                yield str(path.relative_to(folder)), path


def _row(name, path, scratch, build, rulings):
    try:
        verdict = checked(str(path), "standard")
    except OutputError as error:
        return Row(name, unread=f"{error.message}: {error.hint}")
    checks = tuple(check for check in verdict.checks if not check.passed)
    alarms = tuple(line for check in checks for line in _alarms(name, check, rulings))
    return Row(name, checks, built=build, alarms=alarms, **(_built(path, scratch) if build else {}))


def _alarms(model, check, rulings):
    for line, judgement in judged(rulings, model, check):
        if judgement is None or not judgement.true:
            why = "NOT LOOKED AT" if judgement is None else f"FALSE ALARM ({judgement.why})"
            yield f"{why}: {check.code} {level_of(check)}: {line}"


def _built(path, scratch):
    urdf = path.suffix == ".urdf"
    tree = {
        "name": "robot",
        "source": {"kind": "urdf" if urdf else "mjcf", "path": str(path)},
        "mesh": {"collider": "hull"},
        "actuators": {"*": {"type": "position"}} if urdf else {},
        "page": {"live": "kinematics", "preview": "none"},
        "cache": {"dir": str(scratch)},
    }
    try:
        build = linkwright.build(tree)
    except linkwright.LinkwrightError as error:
        if error.message.endswith(NO_ROBOT):
            return {"refused": (NO_ROBOT,)}
        codes = {problem.code for problem in error.problems if problem.code.startswith("E-")}
        return {"refused": tuple(sorted(codes)) or (type(error).__name__,)}
    failed = tuple(sorted({check.code for check in build.report.checks if check.fails}))
    lost = tuple(lost_names(path.read_bytes(), build.files["robot.urdf"])) if urdf else ()
    return {"failed": failed, "lost": lost}


def _lines(check):
    return (f"{check.code} {level_of(check)}: {line}" for line in lines_of(check))


def _summary(rows):
    total: Counter[tuple[str, bool]] = Counter()
    where: Counter[tuple[str, bool]] = Counter()
    for row in rows:
        total += row.codes
        where.update(row.codes.keys())
    print(f"\n{'code':16} {'level':8} {'findings':>8} {'models':>6}")
    for (code, wrong), count in sorted(total.items()):
        print(f"{code:16} {'error' if wrong else 'warning':8} {count:8} {where[code, wrong]:6}")
    unread, alarms = sum(bool(row.unread) for row in rows), sum(len(row.alarms) for row in rows)
    print(
        f"{len(rows)} models: {sum(not row.checks and not row.unread for row in rows)} pass, "
        f"{sum(any(check.fails for check in row.checks) for row in rows)} have errors, "
        f"{unread} have no verdict; {alarms} findings are false alarms or not looked at"
    )
    built = [row for row in rows if row.built and not row.refused]
    if any(row.built for row in rows):
        print(
            f"{len(built)} are built, {sum(not row.lost for row in built)} of them with all names; "
            f"a build and a check say the same of {sum(row.agrees for row in rows)} models"
        )
    return int(unread + alarms > 0 or any(row.lost or not row.agrees for row in rows))


if __name__ == "__main__":
    sys.exit(main())
