"""CI for hardware: builds a robot, and posts what changed since the last build.

hardware.py build ROBOT    builds the robot; leaves the difference in STATE/change, if there is one
hardware.py post ROBOT     posts the difference as a comment on an issue, with both pictures

It needs Python's standard library, `linkwright` and, to post, GitHub's `gh`. Environment: STATE, a folder
that is kept from run to run; ISSUE, the number of the issue; PAGE, the address of the robot's page; and what
GitHub sets.
"""

import base64
import gzip
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

LONGEST = 60_000
"""Characters of a difference in a comment, which GitHub limits to 65,536."""

CUT = "\n\n(cut: the rest is in diff.md, beside the page)"

BRANCH = "linkwright-pictures"
"""The branch that holds the pictures: a comment can only show what has an address."""

STATE = Path(os.environ.get("STATE", "linkwright-state")).resolve()
ROBOT, BEFORE, CHANGE = STATE / "robot", STATE / "before", STATE / "change"
KEPT = ("robot.json", "preview.png")
"""What the difference needs of the build before."""

PICTURES = ("before.png", "after.png")


def run(*words, check=True, cwd=None):
    """Runs a command; returns its status and what it printed. With `check`, ends with its status if it
    fails."""
    done = subprocess.run(words, cwd=cwd, stdout=subprocess.PIPE, text=True, encoding="utf-8", check=False)
    if check and done.returncode:
        raise SystemExit(done.returncode)
    return done.returncode, done.stdout


def set_outputs(**values):
    """Sets outputs of the workflow's step."""
    with open(os.environ.get("GITHUB_OUTPUT", os.devnull), "a", encoding="utf-8") as file:
        file.writelines(f"{name}={value}\n" for name, value in values.items())


def build(robot):
    """Builds the robot, and compares it with the build before. A document that did not change costs one API
    call."""
    for folder in (BEFORE, CHANGE):
        shutil.rmtree(folder, ignore_errors=True)
    BEFORE.mkdir(parents=True)
    for name in KEPT:
        if (ROBOT / name).exists():
            shutil.copy(ROBOT / name, BEFORE / name)
    os.environ.setdefault("LINKWRIGHT_CACHE", str(STATE / "cache"))
    status, text = run("linkwright", f"robot={robot}", f"output={ROBOT}", check=False)
    print(text, end="")
    if status not in (0, 3):  # the log says why, and the last good build stays
        raise SystemExit(status)
    changed = (BEFORE / "robot.json").exists() and compare()
    set_outputs(changed=str(changed).lower(), status=status)


def compare():
    """Writes the difference to the build before into the folder `change`; returns whether there is one."""
    places = (f"{BEFORE.name}/robot.json", ROBOT.name)
    status, text = run("linkwright", "diff", "--markdown", *places, cwd=STATE, check=False)
    if status not in (0, 3):
        raise SystemExit(status)
    if status == 0:
        return False
    CHANGE.mkdir()
    (CHANGE / "diff.md").write_text(text, encoding="utf-8")
    run("linkwright", "check", "--sarif", str(CHANGE / "check.sarif"), str(ROBOT), check=False)
    for folder, name in zip((BEFORE, ROBOT), PICTURES, strict=True):
        if (folder / "preview.png").exists():
            shutil.copy(folder / "preview.png", CHANGE / name)
    return True


def comment(robot, pictures, page):
    """Returns the text of the comment. `pictures`: address by name; `page`: the address of the robot's page,
    or an empty text."""
    checks = json.loads((ROBOT / "report.json").read_text(encoding="utf-8"))["checks"]
    failed = [check["name"] for check in checks if not check["passed"]]
    difference = (CHANGE / "diff.md").read_text(encoding="utf-8").strip()
    if len(difference) > LONGEST:
        difference = difference[:LONGEST].rpartition("\n")[0] + CUT
    parts = [f"### {robot} changed in CAD"]
    if pictures:
        titles = [name.partition(".")[0] for name in pictures]
        images = [f"![{title}]({address})" for title, address in zip(titles, pictures.values(), strict=True)]
        rows = (titles, ["---"] * len(titles), images)
        parts.append("\n".join(f"| {' | '.join(row)} |" for row in rows))
    parts.append(difference)
    parts.append(f"{len(checks) - len(failed)} of {len(checks)} checks passed.")
    parts += [f"- {name}" for name in failed]
    if page:
        parts.append(f"[The page of the robot]({page})")
    return "\n\n".join(parts) + "\n"


def post(robot):
    """Puts the pictures on a branch, the findings into code scanning, and the comment on the issue."""
    repository, issue = os.environ["GITHUB_REPOSITORY"], os.environ["ISSUE"]
    head, place = os.environ["GITHUB_SHA"], f"{robot}/{os.environ['GITHUB_RUN_ID']}"
    # It fails where the branch exists already.
    new = {"ref": f"refs/heads/{BRANCH}", "sha": head}
    api("POST", f"repos/{repository}/git/refs", new, check=False)
    pictures = {}
    for name in PICTURES:
        if (CHANGE / name).exists():
            content = base64.b64encode((CHANGE / name).read_bytes()).decode()
            file = {"message": f"{place}/{name}", "branch": BRANCH, "content": content}
            answer = api("PUT", f"repos/{repository}/contents/{place}/{name}", file)
            pictures[name] = f"{json.loads(answer)['content']['html_url']}?raw=true"
    packed = gzip.compress((CHANGE / "check.sarif").read_bytes())
    sarif = {"commit_sha": head, "ref": os.environ["GITHUB_REF"], "sarif": base64.b64encode(packed).decode()}
    # It fails where the repository has no code scanning: a private one without that product.
    api("POST", f"repos/{repository}/code-scanning/sarifs", sarif, check=False)
    text = comment(robot, pictures, os.environ.get("PAGE", ""))
    (CHANGE / "comment.md").write_text(text, encoding="utf-8")
    run("gh", "issue", "comment", issue, "--repo", repository, "--body-file", str(CHANGE / "comment.md"))


def api(method, path, body, check=True):
    """Sends a request to GitHub, and returns its reply."""
    file = STATE / "request.json"
    file.write_text(json.dumps(body), encoding="utf-8")
    try:
        return run("gh", "api", "--method", method, path, "--input", str(file), check=check)[1]
    finally:
        file.unlink()


if __name__ == "__main__":
    {"build": build, "post": post}[sys.argv[1]](sys.argv[2])
