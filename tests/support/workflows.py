"""Rules for the workflows of GitHub that we run, and that we tell users to copy."""

import re

import yaml

PINNED = re.compile(r"uses: [\w.-]+/[\w./-]+@[0-9a-f]{40} # v\d+(\.\d+)*|uses: \./\S+")
"""An action of others by its commit, with the version beside it; or an action of the same repository."""

EXPRESSION = re.compile(r"\$\{\{")


def check_workflow(path):
    """Checks that a workflow gives no job a permission unasked, and steps as `check_steps`; returns it."""
    text = path.read_text(encoding="utf-8")
    workflow = yaml.safe_load(text)
    check_pins(text)
    assert workflow["permissions"] == {}, path
    for name, job in workflow["jobs"].items():
        assert "permissions" in job, name
        assert "timeout-minutes" in job, name
        check_steps(job["steps"])
    return workflow


def check_pins(text):
    """Checks that each action is named by its commit."""
    uses = [line.strip().removeprefix("- ") for line in text.splitlines() if "uses: " in line]
    assert uses
    assert [line for line in uses if not PINNED.fullmatch(line)] == []


def check_steps(steps):
    """Checks that no expression is in a script, where its value would be code, and that a checkout keeps no
    credentials."""
    for step in steps:
        assert not EXPRESSION.search(step.get("run", "")), step
        if step.get("uses", "").startswith("actions/checkout@"):
            assert step["with"]["persist-credentials"] is False, step
