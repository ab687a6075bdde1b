"""The project's own workflows, the forms of its issues, and what its metadata says."""

import os
import subprocess
import tomllib

import pytest
import yaml

from tests.support.places import PROJECT
from tests.support.workflows import check_workflow

GITHUB = PROJECT / ".github"
WORKFLOWS = sorted((GITHUB / "workflows").glob("*.yml"))
FORMS = sorted(set((GITHUB / "ISSUE_TEMPLATE").glob("*.yml")) - {GITHUB / "ISSUE_TEMPLATE" / "config.yml"})
VERSION = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]["version"]


def release():
    return check_workflow(GITHUB / "workflows" / "release.yml")["jobs"]


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_workflow_has_pinned_actions_and_no_permission_unasked(path):
    check_workflow(path)


def test_job_that_publishes_may_alone_ask_for_a_token():
    rights = {name: job["permissions"] for name, job in release().items()}
    assert rights == {"build": {"contents": "read"}, "publish": {"id-token": "write"}}
    # What it publishes is what the other job built, checked and kept; it runs no code of the project.
    publish = release()["publish"]
    assert [step for step in publish["steps"] if "run" in step] == []
    assert publish["needs"] == "build"
    assert publish["steps"][-1]["with"] == {"attestations": True}


@pytest.mark.parametrize(
    ("tag", "changelog", "words"),
    [
        (f"v{VERSION}", f"## {VERSION}\n", ""),
        ("v99.0", f"## {VERSION}\n", f"the tag is v99.0, and pyproject.toml has the version {VERSION}"),
        (f"v{VERSION}", "## Unreleased\n", f"CHANGELOG.md has no section ## {VERSION}"),
    ],
    ids=["right", "another version", "no section"],
)  # fmt: skip
def test_release_whose_tag_is_not_its_version_is_refused(tmp_path, tag, changelog, words):
    script = next(step["run"] for step in release()["build"]["steps"] if "tag" in step.get("name", ""))
    (tmp_path / "CHANGELOG.md").write_text(changelog)
    (tmp_path / "pyproject.toml").write_text((PROJECT / "pyproject.toml").read_text())
    environ = {**os.environ, "GITHUB_REF_NAME": tag}
    done = subprocess.run(
        ["bash", "-e", "-c", script], cwd=tmp_path, env=environ, capture_output=True, text=True, check=False
    )
    assert (done.returncode == 0) == (not words)
    assert words in done.stderr


@pytest.mark.parametrize("path", FORMS, ids=lambda path: path.stem)
def test_form_is_one_that_github_takes(path):
    """The keys are those of its documents, "Syntax for issue forms"."""
    form = yaml.safe_load(path.read_text())
    assert form.keys() == {"name", "description", "labels", "body"}
    fields = form["body"]
    assert len({field["id"] for field in fields}) == len(fields)
    for field in fields:
        assert field.keys() <= {"type", "id", "attributes", "validations"}
        assert field["type"] == "textarea"
        assert field["attributes"].keys() <= {"label", "description", "render"}
    assert any(field.get("validations") == {"required": True} for field in fields)


def test_citation_has_the_version_and_the_licence():
    citation = yaml.safe_load((PROJECT / "CITATION.cff").read_text())
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    assert (citation["version"], citation["license"]) == (VERSION, project["license"])
    assert citation["repository-code"] == project["urls"]["Homepage"]
