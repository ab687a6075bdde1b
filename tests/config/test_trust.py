"""A robot's YAML is data: whatever it says, nothing that it names is run."""

import json
import os
from pathlib import Path

import pytest
import yaml

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import session
from linkwright.pipeline.config.files.trust import compare_hydra_nodes
from linkwright.pipeline.run.preflight import plan_problems
from tests.support import users
from tests.support.hostile import CODE, MARK, ROBOTS
from tests.support.hostile import write as hostile
from tests.support.stand_in_builds import Recorder
from tests.support.users import GLOBAL, SAMPLE, composed, put, write

URDF = f"{GLOBAL}defaults:\n  - override /source: urdf\nsource: {{path: x.xacro, trust: true}}\n"
CLUSTER = f"{SAMPLE}  - override /hydra/launcher: cluster\n"
BOTH = ["-m", "robot=mine", "root=auto,free"]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("EVIL", CODE)
    monkeypatch.delenv("LINKWRIGHT_TRUST", raising=False)


def refused(folder, *arguments, environ=None):
    return users.refused(folder, *arguments, environ=environ or {})


def refuses(arguments, capsys):
    """The errors of a command that must build nothing and leave nothing."""
    before = sorted(Path().rglob("*"))
    build = Recorder()
    assert run(arguments, build) == 2
    assert build.plans == []
    assert sorted(Path().rglob("*")) == before
    return capsys.readouterr().err


def plans_of(*arguments):
    build = Recorder()
    assert run(arguments, build) == 0
    return build.plans


@pytest.mark.parametrize("name", list(ROBOTS)[:12])
def test_a_hostile_robot_is_refused(tmp_path, capsys, name):
    """The others, in every way, are in `tests/e2e/test_hostile_yaml.py`."""
    hostile(tmp_path, name)
    shown = refuses(["robot=mine"], capsys)
    assert "bug in linkwright" not in shown
    assert "E-" in shown


@pytest.mark.parametrize("name", ["a callback", "logging of jobs"])
@pytest.mark.parametrize(("file", "typed"), [
    ("robot/mine.yaml", BOTH),
    ("robot/mine.yaml", ["-m", "robot=mine,sample"]),
    ("experiment/mine.yaml", ["robot=other", "+experiment=mine"]),
])  # fmt: skip
def test_hostile_file_is_refused_in_sweeps_and_experiments(tmp_path, capsys, name, file, typed):
    write(tmp_path, other=SAMPLE)
    hostile(tmp_path, name, file)
    assert "E-TRUST" in refuses(typed, capsys)


def cluster(folder, keys):
    """A robot with a launcher of the user's own, which has the fields of submitit's; the launcher's
    folder."""
    fields = "nodes: 1\ntimeout_min: 60\ntime: null\npartition: null\nsetup: null\npython: null\n"
    fields += "account: null\nqos: null\ninit: {address: null, num_cpus: null}\n"
    fields += "srun_args: null\nadditional_parameters: {}\nfolder: ${hydra.sweep.dir}/x\n"
    basic = "_target_: hydra._internal.core_plugins.basic_launcher.BasicLauncher\n"
    write(folder, mine=f"{CLUSTER}hydra: {{launcher: {keys}}}\n")
    head = "# @package hydra.launcher\n"
    return [put(folder / "trusted", {"hydra/launcher/cluster.yaml": f"{head}{basic}{fields}"})]


@pytest.mark.parametrize(("keys", "shown"), [
    ("{partition: \"gpu\\ntouch x\"}", "hydra.launcher.partition: a file must not"),
    ("{partition: $(touch x)}", "hydra.launcher.partition: a file must not"),
    ("{setup: ['touch x']}", "hydra.launcher.setup: a file must not"),
    ("{python: ./mine}", "hydra.launcher.python: a file must not"),
    ("{additional_parameters: {x: 1}}", "hydra.launcher.additional_parameters: a"),
    ("{additional_parameters: {wrap: y}}", "hydra.launcher.additional_parameters: a"),
    ("{srun_args: [--x]}", "hydra.launcher.srun_args: a file must not"),
    ("{nodes: true}", "hydra.launcher.nodes: a file must not"),
    ("{folder: 5}", "hydra.launcher.folder: a file must not"),
    ("{account: 'a b'}", "hydra.launcher.account: a file must not"),
    ("{qos: 'a;b'}", "hydra.launcher.qos: a file must not"),
    ("{init: {address: host}}", "hydra.launcher.init: a file must not"),
    ("{init: {num_cpus: 2}}", "hydra.launcher.init: a file must not"),
    ("{setup: ['touch x']}", " robot=mine 'hydra.launcher.setup=[touch x]'"),
    ("{srun_args: [--x]}", " robot=mine 'hydra.launcher.srun_args=[--x]'"),
])  # fmt: skip
def test_a_file_sets_only_what_a_launcher_cannot_run(tmp_path, keys, shown):
    message = users.refused(tmp_path, "robot=mine", dirs=cluster(tmp_path, keys))
    assert "E-TRUST" in message
    assert shown in message


def test_allowed_settings_of_a_launcher_in_a_file_are_used(tmp_path, monkeypatch):
    monkeypatch.setenv("NODES", "3")
    words = "partition: gpu-2, time: '1:30:00', account: lab, qos: high"
    dirs = cluster(tmp_path, f"{{nodes: '${{oc.decode:${{oc.env:NODES}}}}', {words}}}")
    sweeping = composed(tmp_path, "robot=mine", dirs=dirs).sweeping
    assert sweeping.launcher == "cluster"
    assert sweeping.launcher_settings == {"nodes": 3, **yaml.safe_load(f"{{{words}}}")}


def test_numbers_of_a_file_reach_the_launcher(tmp_path):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    text = f"{SAMPLE}  - override /hydra/launcher: workstation\nhydra: {{launcher: {{n_jobs: 2}}}}\n"
    write(tmp_path, mine=text)
    with session((), tmp_path) as composer:
        asked = composer.with_params(*composer.read(["robot=mine"], multirun=True))
    assert (asked.sweeping.launcher, asked.sweeping.launcher_settings) == ("workstation", {"n_jobs": 2})


def test_launcher_of_the_user_needs_config_dir(tmp_path, capsys):
    hostile(tmp_path, "a launcher of one's own")
    for typed, hint in (
        (["robot=mine"], "robot=mine"),
        (["-m", "robot=sample", "root=auto,free", "hydra/launcher=mine"], "-m robot=sample"),
    ):
        assert f"if you trust it: linkwright --config-dir {tmp_path} {hint}" in refuses(typed, capsys)
    assert composed(tmp_path, "robot=mine", dirs=[tmp_path]).sweeping.launcher == "mine"


@pytest.mark.parametrize(("robot", "key", "command"), [
    (URDF, "source.trust", "source.trust=true"),
    (f"{SAMPLE}plugins: [a.b, c]\n", "plugins", "'plugins=[a.b, c]'"),
])  # fmt: skip
def test_trust_comes_from_the_command_line_as_the_error_shows(tmp_path, robot, key, command):
    write(tmp_path, mine=robot)
    shown = refused(tmp_path, "robot=mine", "ground=none")
    assert f"E-TRUST {key}: this key must be set on the command line" in shown
    assert f"      if you trust it: linkwright robot=mine ground=none {command}" in shown.splitlines()
    assert "E-TRUST" not in refused(tmp_path, "robot=mine", f"{key}=[a]", "foo=1")


def test_command_line_and_environment_alone_give_trust(tmp_path):
    write(tmp_path, mine=URDF, other=URDF)
    put(tmp_path, {"experiment/e.yaml": f"{GLOBAL}ground: {{kind: none}}\n"})
    file = tmp_path / "robot" / "mine.yaml"
    named = {"LINKWRIGHT_TRUST": f"/nowhere{os.pathsep}{file}"}
    for trusted, typed, environ in (
        (False, ["robot=mine", "source={path: other.urdf}"], {}),
        (True, ["robot=mine", "source={trust: true}", "foo=1"], {}),
        (True, ["robot=mine", "foo=1"], named),
        (False, ["robot=other"], named),
        (False, ["robot=mine"], {"LINKWRIGHT_TRUST": str(tmp_path)}),
        # All of the user's files that were composed: the experiment could have set the key.
        (False, ["robot=mine", "+experiment=e"], named),
    ):
        assert ("E-TRUST" in refused(tmp_path, *typed, environ=environ)) is not trusted, (typed, environ)
    put(tmp_path, {".env": f"LINKWRIGHT_TRUST={file}\n"})
    assert "E-TRUST" in refused(tmp_path, "robot=mine")


def test_settings_of_a_sweep_pass_if_allowed():
    ours = {
        "sweep": {"dir": "outputs"},
        "callbacks": {},
        "verbose": False,
        "launcher": {"n": 1, "_target_": "A"},
    }
    theirs = {"sweep": {"dir": "x"}, "callbacks": {"a": 1}, "verbose": 0, "launcher": {"n": 2, "_target_": 3}}
    changed, problems = compare_hydra_nodes(theirs, ours, lambda place: theirs[place[0]][place[1]])
    assert changed == {"sweep.dir": "x", "launcher.n": 2}
    places = [problem.where for problem in problems]
    assert places == ["hydra.callbacks", "hydra.verbose", "hydra.launcher._target_"]


@pytest.mark.slow
def test_a_file_sets_the_swept_values_and_the_command_line_wins(tmp_path):
    keys = "hydra: {sweeper: {params: {root: 'auto,free', joints.*.damping: '0.1,0.2'}}}\n"
    write(tmp_path, mine=SAMPLE + keys)
    pairs = [(plan.root.base, plan.joints["*"].damping) for plan in plans_of("-m", "robot=mine")]
    assert pairs == [("auto", 0.1), ("auto", 0.2), ("free", 0.1), ("free", 0.2)]
    assert [plan.root.base for plan in plans_of("-m", "robot=mine", "root=fixed")] == ["fixed", "fixed"]
    assert len(plans_of("robot=mine")) == 1


@pytest.mark.slow
def test_a_file_sets_the_folders_of_a_sweep_and_its_jobs(tmp_path):
    subdir = "${hydra.job.num}_${hydra.job.override_dirname}"
    write(tmp_path, mine=f"{SAMPLE}hydra: {{sweep: {{dir: 'sweeps/${{name}}', subdir: '{subdir}'}}}}\n")
    assert [plan.output for plan in plans_of(*BOTH)] == ["sweeps/mine/0_root=auto", "sweeps/mine/1_root=free"]
    assert (tmp_path / "sweeps" / "mine" / "multirun.yaml").is_file()
    folders = [plan.output for plan in plans_of(*BOTH, "hydra.sweep.dir=there")]
    assert folders == ["there/0_root=auto", "there/1_root=free"]


@pytest.mark.parametrize(("subdir", "shown"), [
    ("same", "hydra.sweep.subdir: jobs 0 and 1 have the same folder"),
    ("../${hydra.job.num}", "hydra.sweep.subdir: must be a folder below the sweep's"),
    ("/tmp/${hydra.job.num}", "hydra.sweep.subdir: must be a folder below the sweep's"),
])  # fmt: skip
def test_each_job_has_its_own_folder_below_the_sweeps(tmp_path, capsys, subdir, shown):
    write(tmp_path, mine=f"{SAMPLE}hydra: {{sweep: {{subdir: '{subdir}'}}}}\n")
    assert shown in refuses(BOTH, capsys)


def test_robots_of_a_sweep_agree_on_how_it_runs(tmp_path, capsys):
    write(tmp_path, a=SAMPLE, b=f"{SAMPLE}hydra: {{sweeper: {{params: {{ground: 'plane,none'}}}}}}\n")
    assert "has no effect: the file that sets it is itself swept" in refuses(["-m", "robot=a,b"], capsys)


@pytest.mark.slow
def test_hydras_account_has_what_was_typed(tmp_path):
    keys = "name: '${oc.env:HOME}-arm'\nhydra: {sweeper: {params: {root: 'auto,free'}}}\n"
    write(tmp_path, mine=SAMPLE + keys)
    typed = ["robot=mine", "ground=none,plane", "name=arm"]
    plans_of("-m", *typed)
    account = yaml.safe_load((tmp_path / "outputs" / "arm.sweep" / "multirun.yaml").read_text())
    assert account["hydra"]["overrides"]["task"] == typed
    assert account["source"] == {"kind": "sample", "robot": "sample"}


def test_the_environment_of_jobs_is_that_of_the_sweep(tmp_path):
    write(tmp_path, mine=SAMPLE)
    build = Recorder()
    assert run(BOTH, build) == 0
    assert all(environ == dict(os.environ) for environ in build.environs)
    assert json.loads((tmp_path / "outputs/mine.sweep/summary.json").read_text())["runs"]


def test_a_mark_would_be_seen(tmp_path):
    """The code that the hostile robots name does leave a file, where it is run."""
    code = yaml.safe_load(CODE)
    module, _, name = code["_target_"].rpartition(".")
    getattr(__import__(module), name)(code["filename"]).close()
    assert (tmp_path / MARK).is_file()


def test_a_plugin_that_only_a_file_names_is_not_imported(tmp_path):
    put(tmp_path, {"plugin_of_nobody.py": "open('ran', 'w').close()\n"})
    keys = "plugins: [plugin_of_nobody]\nvalidate: {checks: [{_target_: plugin_of_nobody.x}]}\n"
    write(tmp_path, mine=SAMPLE + keys)
    assert "E-TRUST plugins" in users.refused(tmp_path, "robot=mine", judge=plan_problems)
    assert not (tmp_path / "ran").exists()
