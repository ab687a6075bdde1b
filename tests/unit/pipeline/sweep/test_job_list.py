"""A list of the jobs of a sweep: written, fetched, run anywhere, and told from their folders."""

import json
import shutil
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.config.files.file_text import as_yaml
from linkwright.pipeline.lock import FOLDER as LOCKS
from linkwright.pipeline.reference.exit_status import MEANINGS
from tests.fake_onshape.faults import Fault
from tests.fake_onshape.server import ACCESS_KEY, SECRET_KEY, OnshapeServer
from tests.fake_onshape.settable import configured_stand
from tests.support.command import called, environment
from tests.support.users import write

pytestmark = pytest.mark.e2e

ARM = """\
# @package _global_
defaults:
  - override /source: sample
root: {base: fixed}
"""
SWEPT = ("robot=arm", "joints.*.damping=1,2,3", "until=graph", "page.preview=none")
LEGS = "'200 mm','0.3 m'"


class Place:
    """A working folder with the robot `arm`, and commands in it."""

    def __init__(self, here, **variables):
        self.here = write(here, arm=ARM)
        self.environ = environment(here, seeded=False, **variables)

    def __call__(self, *arguments, status=0, **variables):
        done = called(self.here, *arguments, environ={**self.environ, **variables})
        assert done.returncode == status, done.stderr + done.stdout
        assert status in MEANINGS.get(arguments[0], {status})
        assert "Traceback" not in done.stderr
        return done

    def plan(self, *more, swept=SWEPT, **variables):
        """Writes the list; what is told."""
        return self("-m", *swept, *more, "--plan", "jobs.json", **variables).stdout

    def job(self, *which, **more):
        return self("job", "jobs.json", *map(str, which), **more)

    def jobs(self, *more, status=0, **variables):
        """The last line about the jobs of the list."""
        return self("jobs", "jobs.json", *more, status=status, **variables).stdout.splitlines()[-1]

    @property
    def list(self):
        return json.loads((self.here / "jobs.json").read_text())

    def change(self, table):
        (self.here / "jobs.json").write_text(json.dumps(table))

    def files(self, name="robot.json"):
        paths = sorted(self.here.glob(f"outputs/*.sweep/*/{name}"))
        return {path.parent.name: path.read_bytes() for path in paths}


@pytest.fixture
def place(tmp_path):
    return Place(tmp_path / "place")


@pytest.fixture(scope="module")
def listed(tmp_path_factory):
    """The text of a list."""
    place = Place(tmp_path_factory.mktemp("listed"))
    place.plan()
    return (place.here / "jobs.json").read_text()


@pytest.fixture
def planned(place, listed):
    """A place with a list."""
    (place.here / "jobs.json").write_text(listed)
    return place


@pytest.fixture
def server():
    with OnshapeServer(configured_stand()) as server:
        yield server


@pytest.fixture
def stand(tmp_path, server):
    """A place with the key of the local Onshape, for a list of four jobs of two configurations."""
    place = Place(tmp_path / "stand", **server.environ)
    line = ["name=stand", "until=graph", "page.preview=none", "source=onshape"]
    line += [f"source.url='{server.document_url()}'", f"source.configuration.leg_length={LEGS}"]
    place.swept = (*line, "joints.*.damping=1,2")
    return place


def keyless(server):
    return {"ONSHAPE_ACCESS_KEY": "", "ONSHAPE_SECRET_KEY": "", "LINKWRIGHT_HOST": server.url}


def test_jobs_of_a_list_are_those_of_the_sweep(place, tmp_path):
    more = "vars={x: 'é', y: \"a\\tb\", z: [1, {w: null}]}"
    assert place.plan(more) == "jobs.json: 3 jobs\n"
    assert not (place.here / "outputs").exists()
    labels = [(number, f"joints.*.damping={number + 1}") for number in range(3)]
    assert [(job["number"], job["label"]) for job in place.list["jobs"]] == labels
    first = (place.here / "jobs.json").read_bytes()
    place.job(1)
    place.plan(more)
    assert (place.here / "jobs.json").read_bytes() == first
    place.job("--shard", "1/1")
    assert place.jobs() == "3 done", "the digest of a job is that of the configuration that its build writes"
    swept = Place(tmp_path / "swept")
    swept("-m", *SWEPT, more)
    assert len(place.files()) == 3
    for name in ("robot.json", "config.yaml"):
        assert place.files(name) == swept.files(name)


def test_a_configuration_as_text_is_that_of_its_sections():
    tree = {"name": "arm", "joints": {"*": {"limits": None}}, "vars": {"x": "é"}, "plugins": []}
    assert as_yaml(tree) == yaml.safe_dump(tree, sort_keys=False, allow_unicode=True).encode()


def test_what_became_of_each_job_is_told_from_the_folders_alone(planned):
    assert planned.jobs(status=1) == "3 missing"
    planned.job(1)
    assert planned.jobs(status=1) == "1 done, 2 missing"
    sweep = planned.here / "outputs" / "arm.sweep"
    name = Path(planned.list["jobs"][0]["folder"]).name
    running = sweep / LOCKS / f"{name}.outcome.json"
    running.write_text(json.dumps({"host": "elsewhere", "process": 1}))
    assert planned.jobs(status=1) == "1 done, 1 running, 1 missing"
    planned.job("--shard", "1/2")
    assert planned.jobs() == "3 done"
    (only,) = json.loads((sweep / "summary.json").read_text())["runs"]
    assert [job["status"] for job in only["jobs"]] == [0, 0, 0]
    assert only["overrides"] == list(SWEPT)
    assert (sweep / "summary.html").is_file()
    before = planned.files()
    planned.job(2)
    assert planned.files() == before
    reports = [json.loads(report) for report in planned.files("report.json").values()]
    assert sum(all(stage["cached"] for stage in report["stages"]) for report in reports) == 1


def test_job_that_fails_has_the_status_of_its_build(place):
    place.plan(swept=("robot=arm", "root.select=nothing,auto", "until=graph", "page.preview=none"))
    assert "error: job 0 (root.select=nothing): " in place.job(0, status=1).stderr
    assert place.jobs(status=1) == "1 failed, 1 missing"


def test_shares_are_all_jobs_once(place):
    place.plan(swept=("robot=arm", "vars.x=range(0,7)", "until=fetch", "page.preview=none"))
    numbers = []
    for part in (1, 2, 3):
        rows = place("jobs", "jobs.json", f"--shard={part}/3", status=1).stdout.splitlines()
        numbers += [int(row.split()[0]) for row in rows if row[:1].isdigit() and "vars.x" in row]
    assert sorted(numbers) == list(range(7))


def test_a_list_goes_with_its_tree_to_another_place(place, tmp_path):
    work = Place(place.here / "work")
    work("-m", *SWEPT, "--plan", "../jobs.json")
    assert place.list["cwd"] == "work"
    there, elsewhere = tmp_path / "there", tmp_path / "anywhere"
    shutil.copytree(place.here, there)
    elsewhere.mkdir()
    done = called(elsewhere, "job", str(there / "jobs.json"), "0", environ=place.environ)
    assert done.returncode == 0, done.stderr
    assert len(list(there.glob("work/outputs/arm.sweep/*/robot.json"))) == 1
    shutil.rmtree(there / "work")
    done = called(elsewhere, "job", str(there / "jobs.json"), "0", environ=place.environ)
    assert done.returncode == 2
    assert "its working folder work" in done.stderr


def test_list_of_a_changed_robot_is_stale(planned):
    planned.job(0)
    write(planned.here, arm=ARM.replace("fixed", "free"))
    stale = planned.job(0, status=2).stderr
    assert "job 0 (joints.*.damping=1): the list is stale" in stale
    assert stale.count("error:") == 1
    planned.plan()
    assert planned.jobs(status=1) == "1 stale, 2 missing"
    planned.job(0)
    assert planned.jobs(status=1) == "1 done, 2 missing"


def test_failure_of_another_sweep_in_the_folders_is_stale(place):
    numbered = ("hydra.sweep.dir=s", "hydra.sweep.subdir='${hydra.job.num}'")
    place("-m", "robot=arm", "joints.nowhere.damping=1,2", "until=graph", *numbered, status=1)
    place.plan(*numbered)
    output = place("jobs", "jobs.json", status=1).stdout
    assert output.endswith("\n2 stale, 1 missing\n")
    assert "nowhere" not in output


@pytest.mark.parametrize(("content", "message"), [
    ("", "is not JSON"),
    ("{", "is not JSON"),
    ("[" * 100_000, "is not JSON"),
    ("[]", "is not a list of jobs"),
    ('{"runs": []}', "is not a list of jobs"),
    ('{"linkwright-jobs": 2}', "version 2, and this linkwright reads version 1"),
    ('{"linkwright-jobs": 1}', "damaged"),
    ('{"linkwright-jobs": 1, "jobs": 5}', "damaged"),
])  # fmt: skip
@pytest.mark.parametrize("verb", [["job", "0"], ["jobs"], ["jobs", "--fetch"]])
def test_a_file_that_is_no_list_is_one_message(place, content, message, verb):
    (place.here / "jobs.json").write_text(content)
    done = place(verb[0], "jobs.json", *verb[1:], status=2)
    assert message in done.stderr
    assert done.stderr.count("error:") == 1


STALE = "job 0 (joints.*.damping=1): the list is stale"


@pytest.mark.parametrize(("change", "message"), [
    *(({key: value}, "damaged") for key, value in (
        ("jobs", []), ("jobs", [5]), ("cwd", 5), ("overrides", [5]), ("overrides", None), ("folder", None),
        ("more", 1),
    )),
    *(({"jobs": [{key: value}]}, "damaged") for key, value in (
        ("folder", "../../x"), ("folder", "outputs/arm.sweep/../../x"), ("folder", "outputs/arm.sweep"),
        ("folder", "/tmp/x"), ("suffix", "/../../x"),
    )),
    ({"jobs": [{"folder": "outputs/arm.sweep/x"}]}, STALE), ({"jobs": [{"suffix": ".x"}]}, STALE),
], ids=str)  # fmt: skip
def test_a_list_that_was_edited_is_one_message(planned, change, message):
    """A change of the first job, such as a folder outside that of the sweep, leaves the other jobs."""
    table = planned.list
    match change:
        case {"jobs": [dict() as job]}:
            table["jobs"][0] |= job
        case _:
            table |= change
    planned.change(table)
    assert message in planned.job(0, status=2).stderr
    if message == "damaged":
        assert message in planned("jobs", "jobs.json", status=2).stderr
    else:
        planned.job(1)


def test_a_subdir_with_the_time_in_it_is_the_one_of_the_list(place):
    place.plan("hydra.sweep.dir=s", "hydra.sweep.subdir='${now:%f}-${hydra.job.num}'")
    place.job(0)
    assert place.jobs(status=1) == "1 done, 2 missing"


def test_a_quiet_verb_shows_only_errors(planned):
    lines = ["job jobs.json 0 -q", "job --quiet jobs.json --shard=1/1"]
    lines += ["jobs jobs.json -q", "jobs jobs.json -q --fetch", "jobs jobs.json -q --shard 1/2"]
    for line in lines:
        done = planned(*line.split())
        assert (done.stdout, done.stderr) == ("", ""), line
    shutil.rmtree(planned.here / "outputs")
    assert planned.jobs("-q", status=1) == "3 missing"


@pytest.mark.parametrize(("arguments", "message"), [
    (["job", "jobs.json", "3"], "has no job 3"),
    (["job", "jobs.json", "-1"], "there is no option -1"),
    (["job", "jobs.json", "first"], "has no job first"),
    (["job", "jobs.json"], "a number or --shard"),
    (["job", "jobs.json", "1", "2"], "a number or --shard"),
    (["job"], "expected a list"),
    (["job", "jobs.json", "--shard", "0/3"], "a share such as 3/8"),
    (["job", "jobs.json", "--shard=4/3"], "a share such as 3/8"),
    (["job", "jobs.json", "--shard"], "a share such as 3/8"),
    (["jobs", "jobs.json", "--fast"], "there is no option --fast"),
    (["jobs", "jobs.json", "--fetch", "--shard", "1/2"], "--fetch or --shard"),
    (["jobs", "nowhere.json"], "cannot be read"),
    (["robot=arm", "--plan", "jobs.json"], "lists the jobs of a sweep"),
    (["-m", "robot=arm", "--offline"], "belongs to --plan"),
    (["-m", "robot=arm", "--plan"], "needs a file"),
    (["-m", *SWEPT, "--plan", "robot/arm.yaml"], "another file is there"),
    (["-m", *SWEPT, "--plan", "nowhere/jobs.json"], "there is no folder nowhere"),
])  # fmt: skip
def test_wrong_usage_is_one_message(planned, arguments, message):
    done = planned(*arguments, status=2)
    assert message in done.stderr
    assert done.stderr.count("error:") == 1
    assert (planned.here / "robot" / "arm.yaml").read_text() == ARM


def test_list_of_a_document_is_fetched_once_for_its_jobs(stand, server, tmp_path):
    line = stand.plan(swept=stand.swept)
    # The parameters and two definitions; then the base, the jaw and two legs, two calls each.
    assert server.count == 3
    assert line == "jobs.json: 4 jobs, 2 configurations, 11 calls\n"
    listed = stand.list
    assert (listed["calls"], listed["exact"]) == (8, True)
    assert {job["pin"] for job in listed["jobs"]} == {f"m/{server.document.microversion}"}
    stand.plan(swept=stand.swept)
    assert stand.list == listed
    assert server.count == 4, "whether the workspace changed"
    server.reset()
    assert "4 jobs, 2 configurations, 8 calls" in stand("jobs", "jobs.json", "--fetch").stderr
    assert server.count == 8
    assert stand.list == listed
    server.reset()
    for number in range(4):
        stand.job(number, **keyless(server))
    stand.jobs(**keyless(server))
    stand("jobs", "jobs.json", "--fetch")
    assert not server.calls
    swept = Place(tmp_path / "swept", **server.environ)
    swept("-m", *stand.swept)
    assert stand.files() == swept.files()
    assert len(stand.files()) == 4
    files = [path for path in stand.here.rglob("*") if path.is_file()]
    assert not [path for path in files if SECRET_KEY.encode() in path.read_bytes()]
    assert ACCESS_KEY not in (stand.here / "jobs.json").read_text()


def test_the_state_of_a_list_is_fetched_also_after_an_edit(stand, server):
    stand.plan(swept=stand.swept)
    pin = stand.list["jobs"][0]["pin"]
    server.edit(server.document.edited(server.document.studios[0].name))
    stand("jobs", "jobs.json", "--fetch")
    stand.job("--shard", "1/1", **keyless(server))
    reports = [json.loads(report) for report in stand.files("report.json").values()]
    assert {f"m/{report['source']['microversion']}" for report in reports} == {pin}
    assert stand.jobs() == "4 done"
    stand.plan(swept=stand.swept)
    assert stand.list["jobs"][0]["pin"] != pin
    assert stand.jobs(status=1) == "4 stale"


def test_list_written_offline_is_pinned_when_it_is_fetched(stand, server):
    line = stand.plan("--offline", swept=stand.swept, **keyless(server))
    assert not server.calls
    assert line == "jobs.json: 4 jobs, 2 configurations, at least 2 calls\n"
    assert {job["pin"] for job in stand.list["jobs"]} == {""}
    missing = stand.job(0, status=1, **keyless(server))
    label = stand.list["jobs"][0]["label"]
    hint = "  → linkwright jobs jobs.json --fetch\n"
    assert missing.stdout == ""
    assert missing.stderr == f"error: job 0 ({label}): nothing is fetched for this job yet\n{hint}"
    several = stand.job("--shard", "1/2", status=1, **keyless(server)).stderr
    assert several.splitlines()[0] == "error: jobs 0, 2: nothing is fetched for these jobs yet"
    stand("jobs", "jobs.json", "--fetch")
    assert {job["pin"] for job in stand.list["jobs"]} == {f"m/{server.document.microversion}"}
    stand.job(0, **keyless(server))


def test_failures_of_a_fetch_for_one_reason_are_one_message(stand, server):
    lengths = ",".join(f"'{length} mm'" for length in range(200, 205))
    line = [f"source.configuration.leg_length={lengths}" if LEGS in text else text for text in stand.swept]
    stand.plan("--offline", swept=line, **keyless(server))
    refused = stand("jobs", "jobs.json", "--fetch", status=1, **keyless(server)).stderr
    assert refused.count("error: ") == refused.count("no Onshape API key") == 1
    assert "error: jobs 0, 2, 4 and 2 more: no Onshape API key" in refused


def test_failed_fetch_is_named_and_fails_its_jobs_alone(stand, server):
    stand.plan(swept=stand.swept)
    server.fault = lambda method, target, number: Fault(404) if "0.3%2Bm" in target else None
    assert stand("jobs", "jobs.json", "--fetch", status=1).stderr.count("error: job 2 ") == 1
    stand.job(2, status=1, **keyless(server))
    output = stand.job("--shard", "1/1", status=1, **keyless(server)).stderr
    assert "error: jobs 2, 3: nothing is fetched for these jobs yet" in output
    assert stand.jobs(status=1) == "2 done, 2 missing"
