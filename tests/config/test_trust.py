"""A robot's YAML is data: whatever it says, nothing that it names is run."""

import json
import os
from pathlib import Path

import pytest

from linkwright.pipeline.cli import run
from linkwright.pipeline.config.compose import compose_plan, session
from linkwright.pipeline.config.files.trust import listed
from linkwright.pipeline.report import Report
from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.errors import ConfigError
from tests.support.cases import mostly_slow
from tests.support.hostile import CODE, MARK, ROBOTS
from tests.support.hostile import write as hostile
from tests.support.users import write

SAMPLE = "# @package _global_\ndefaults:\n  - override /source: sample\n"
URDF = "# @package _global_\ndefaults:\n  - override /source: urdf\nsource: {path: x.xacro, trust: true}\n"


class Recorder:
    """A build that succeeds, and remembers its plans and the environment."""

    def __init__(self):
        self.plans, self.environs = [], []

    def __call__(self, plan):
        self.plans.append(plan)
        self.environs.append(dict(os.environ))
        return Report("built", plan.name, str(plan.folder), plan.until, 0)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("EVIL", CODE)
    monkeypatch.delenv("LINKWRIGHT_TRUST", raising=False)


def refused(folder, *arguments, environ=None):
    with pytest.raises(ConfigError) as caught:
        compose_plan(arguments, (), folder, environ=environ or {})
    return str(caught.value)


def refuses(arguments, capsys):
    """Whether a command builds nothing, leaves nothing, and says so."""
    before = sorted(Path().rglob("*"))
    build = Recorder()
    assert run(arguments, build) == 2
    assert build.plans == []
    assert sorted(Path().rglob("*")) == before
    return capsys.readouterr().err


@pytest.mark.parametrize("name", mostly_slow(ROBOTS, keep=12))
def test_a_hostile_robot_is_refused(tmp_path, capsys, name):
    hostile(tmp_path, name)
    output_text = refuses(["robot=mine"], capsys)
    assert "bug in linkwright" not in output_text
    assert "E-" in output_text


SWEPT = ["a callback", "logging of jobs", "a variable for the job", "a launcher's class", "a sweep of Hydra"]


@pytest.mark.parametrize("name", mostly_slow(SWEPT, keep=2))
@pytest.mark.parametrize("swept", [["robot=mine", "root=auto,free"], ["robot=mine,sample"]])
def test_so_it_is_in_a_sweep_and_where_it_is_itself_swept_over(tmp_path, capsys, name, swept):
    hostile(tmp_path, name)
    assert "E-TRUST" in refuses(["-m", *swept], capsys)


@pytest.mark.parametrize("name", mostly_slow(SWEPT, keep=2))
def test_an_experiment_may_set_no_more_than_a_robot(tmp_path, capsys, name):
    write(tmp_path, other=SAMPLE)
    hostile(tmp_path, name, "experiment/mine.yaml")
    assert "E-TRUST" in refuses(["robot=other", "+experiment=mine"], capsys)


@pytest.mark.parametrize(
    ("keys", "shown"),
    [
        ("hydra: {launcher: {partition: \"gpu\\ntouch x\"}}", "hydra.launcher.partition: a file must not"),
        ("hydra: {launcher: {partition: $(touch x)}}", "hydra.launcher.partition: a file must not"),
        ("hydra: {launcher: {setup: ['touch x']}}", "hydra.launcher.setup: a file must not"),
        ("hydra: {launcher: {python: ./mine}}", "hydra.launcher.python: a file must not"),
        ("hydra: {launcher: {additional_parameters: {x: 1}}}", "hydra.launcher.additional_parameters: a"),
        ("hydra: {launcher: {additional_parameters: {wrap: y}}}", "hydra.launcher.additional_parameters: a"),
        ("hydra: {launcher: {srun_args: [--x]}}", "hydra.launcher.srun_args: a file must not"),
        ("hydra: {launcher: {nodes: true}}", "hydra.launcher.nodes: a file must not"),
        ("hydra: {launcher: {folder: 5}}", "hydra.launcher.folder: a file must not"),
    ],
)  # fmt: skip
def test_a_file_sets_only_a_launchers_numbers_partition_and_time(tmp_path, keys, shown):
    cluster(tmp_path)
    write(tmp_path, mine=f"{SAMPLE}  - override /hydra/launcher: cluster\n{keys}\n")
    with pytest.raises(ConfigError, match="E-TRUST") as caught:
        compose_plan(["robot=mine"], [tmp_path / "trusted"], tmp_path)
    assert shown in str(caught.value)


def cluster(folder: Path) -> None:
    """A launcher of the user's own, with the fields of submitit's."""
    file = folder / "trusted" / "hydra" / "launcher" / "cluster.yaml"
    file.parent.mkdir(parents=True)
    fields = "nodes: 1\ntimeout_min: 60\ntime: null\npartition: null\nsetup: null\npython: null\n"
    fields += "srun_args: null\nadditional_parameters: {}\nfolder: ${hydra.sweep.dir}/x\n"
    basic = "_target_: hydra._internal.core_plugins.basic_launcher.BasicLauncher\n"
    file.write_text(f"# @package hydra.launcher\n{basic}{fields}")


def test_allowed_settings_of_a_launcher_in_a_file_are_used(tmp_path, monkeypatch):
    cluster(tmp_path)
    monkeypatch.setenv("NODES", "3")
    keys = "hydra: {launcher: {nodes: '${oc.decode:${oc.env:NODES}}', partition: gpu-2, time: '1:30:00'}}\n"
    write(tmp_path, mine=f"{SAMPLE}  - override /hydra/launcher: cluster\n{keys}")
    output_text = compose_plan(["robot=mine"], [tmp_path / "trusted"], tmp_path).sweeping
    assert output_text.launcher == "cluster"
    assert output_text.numbers == {"nodes": 3, "partition": "gpu-2", "time": "1:30:00"}


def test_numbers_of_a_file_reach_the_launcher(tmp_path):
    pytest.importorskip("hydra_plugins.hydra_joblib_launcher")
    text = f"{SAMPLE}  - override /hydra/launcher: workstation\nhydra: {{launcher: {{n_jobs: 2}}}}\n"
    write(tmp_path, mine=text)
    with session((), tmp_path) as composer:
        asked = composer.with_params(*composer.read(["robot=mine"], multirun=True))
    assert (asked.sweeping.launcher, asked.sweeping.numbers) == ("workstation", {"n_jobs": 2})


def test_a_launcher_in_the_working_folder_counts_only_where_config_dir_names_it(tmp_path, capsys):
    hostile(tmp_path, "a launcher of one's own")
    output_text = refuses(["robot=mine"], capsys)
    assert f"if you trust it: linkwright --config-dir {tmp_path} robot=mine" in output_text
    output_text = refuses(["-m", "robot=sample", "root=auto,free", "hydra/launcher=mine"], capsys)
    assert f"if you trust it: linkwright --config-dir {tmp_path} -m robot=sample" in output_text
    assert compose_plan(["robot=mine"], [tmp_path], tmp_path).sweeping.launcher == "mine"


@pytest.mark.parametrize(
    ("robot", "key", "command"),
    [
        (URDF, "source.trust", "linkwright robot=mine ground=none source.trust=true"),
        (f"{SAMPLE}plugins: [a.b, c]\n", "plugins", "linkwright robot=mine ground=none 'plugins=[a.b, c]'"),
    ],
)
def test_trust_is_given_on_the_command_line_and_the_error_shows_how(tmp_path, robot, key, command):
    write(tmp_path, mine=robot)
    shown = refused(tmp_path, "robot=mine", "ground=none")
    assert f"E-TRUST {key}: must be set on the command line" in shown
    assert f"      if you trust it: {command}" in shown.splitlines()
    assert "E-TRUST" not in refused(tmp_path, "robot=mine", f"{key}=[a]", "foo=1")


def test_a_mapping_on_the_command_line_trusts_only_what_it_names(tmp_path):
    write(tmp_path, mine=URDF)
    assert "E-TRUST" in refused(tmp_path, "robot=mine", "source={path: other.urdf}")
    assert "E-TRUST" not in refused(tmp_path, "robot=mine", "source={trust: true}", "foo=1")


def test_the_environment_may_trust_a_file_by_its_name(tmp_path):
    write(tmp_path, mine=URDF, other=URDF)
    (tmp_path / "experiment").mkdir()
    (tmp_path / "experiment" / "e.yaml").write_text("# @package _global_\nground: {kind: none}\n")
    named = {"LINKWRIGHT_TRUST": f"/nowhere{os.pathsep}{tmp_path / 'robot' / 'mine.yaml'}"}
    assert "E-TRUST" not in refused(tmp_path, "robot=mine", "foo=1", environ=named)
    assert "E-TRUST" in refused(tmp_path, "robot=other", environ=named)
    assert "E-TRUST" in refused(tmp_path, "robot=mine", environ={"LINKWRIGHT_TRUST": str(tmp_path)})
    # All of the user's files that were composed: the other one could have said it.
    assert "E-TRUST" in refused(tmp_path, "robot=mine", "+experiment=e", environ=named)


def test_a_file_env_trusts_nothing(tmp_path):
    write(tmp_path, mine=URDF)
    (tmp_path / ".env").write_text(f"LINKWRIGHT_TRUST={tmp_path / 'robot' / 'mine.yaml'}\n")
    assert "E-TRUST" in refused(tmp_path, "robot=mine")


def test_allowed_settings_of_a_sweep_pass_and_others_are_reported():
    ours = {
        "sweep": {"dir": "outputs"},
        "callbacks": {},
        "verbose": False,
        "launcher": {"n": 1, "_target_": "A"},
    }
    theirs = {"sweep": {"dir": "x"}, "callbacks": {"a": 1}, "verbose": 0, "launcher": {"n": 2, "_target_": 3}}
    output_text, problems = listed(theirs, ours, lambda place: theirs[place[0]][place[1]])
    assert output_text == {"sweep.dir": "x", "launcher.n": 2}
    assert [one.where for one in problems] == ["hydra.callbacks", "hydra.verbose", "hydra.launcher._target_"]


def sweep(arguments):
    build = Recorder()
    assert run(["-m", *arguments], build) == 0
    return build.plans


@pytest.mark.slow
def test_a_file_sets_the_swept_values_and_the_command_line_wins(tmp_path):
    keys = "hydra: {sweeper: {params: {root: 'auto,free', joints.*.damping: '0.1,0.2'}}}\n"
    write(tmp_path, mine=SAMPLE + keys)
    plans = sweep(["robot=mine"])
    assert [(plan.root.base, plan.joints["*"].damping) for plan in plans] == [
        ("auto", 0.1), ("auto", 0.2), ("free", 0.1), ("free", 0.2),
    ]  # fmt: skip
    assert [plan.root.base for plan in sweep(["robot=mine", "root=fixed"])] == ["fixed", "fixed"]
    build = Recorder()
    assert run(["robot=mine"], build) == 0
    assert len(build.plans) == 1


@pytest.mark.slow
def test_a_file_sets_the_folders_of_a_sweep_and_its_jobs(tmp_path):
    keys = (
        "hydra: {sweep: {dir: 'sweeps/${name}', subdir: '${hydra.job.num}_${hydra.job.override_dirname}'}}\n"
    )
    write(tmp_path, mine=SAMPLE + keys)
    folders = [plan.output for plan in sweep(["robot=mine", "root=auto,free"])]
    assert folders == ["sweeps/mine/0_root=auto", "sweeps/mine/1_root=free"]
    assert (tmp_path / "sweeps" / "mine" / "multirun.yaml").is_file()
    folders = [plan.output for plan in sweep(["robot=mine", "root=auto,free", "hydra.sweep.dir=there"])]
    assert folders == ["there/0_root=auto", "there/1_root=free"]


@pytest.mark.parametrize(
    ("subdir", "shown"),
    [
        ("same", "hydra.sweep.subdir: jobs 0 and 1 have the same folder"),
        ("../${hydra.job.num}", "hydra.sweep.subdir: must be a folder below the sweep's"),
        ("/tmp/${hydra.job.num}", "hydra.sweep.subdir: must be a folder below the sweep's"),
    ],
)
def test_each_job_has_a_folder_of_its_own_below_the_sweeps(tmp_path, capsys, subdir, shown):
    write(tmp_path, mine=f"{SAMPLE}hydra: {{sweep: {{subdir: '{subdir}'}}}}\n")
    assert shown in refuses(["-m", "robot=mine", "root=auto,free"], capsys)


def test_robots_of_one_sweep_agree_on_how_it_runs(tmp_path, capsys):
    write(tmp_path, a=SAMPLE, b=f"{SAMPLE}hydra: {{sweeper: {{params: {{ground: 'plane,none'}}}}}}\n")
    assert "has no effect: the file that sets it is itself swept" in refuses(["-m", "robot=a,b"], capsys)


@pytest.mark.slow
def test_hydras_account_has_what_was_typed_and_what_all_jobs_start_from(tmp_path):
    import yaml

    write(
        tmp_path,
        mine=f"{SAMPLE}name: '${{oc.env:HOME}}-arm'\nhydra: {{sweeper: {{params: {{root: 'auto,free'}}}}}}\n",
    )
    assert run(["-m", "robot=mine", "ground=none,plane", "name=arm"], Recorder()) == 0
    account = yaml.safe_load((tmp_path / "outputs" / "arm.sweep" / "multirun.yaml").read_text())
    assert account["hydra"]["overrides"]["task"] == ["robot=mine", "ground=none,plane", "name=arm"]
    assert account["source"] == {"kind": "sample"}


def test_nothing_of_a_refused_robot_is_in_the_environment_of_others(tmp_path):
    write(tmp_path, mine=SAMPLE)
    build = Recorder()
    assert run(["-m", "robot=mine", "root=auto,free"], build) == 0
    assert all(environ == dict(os.environ) for environ in build.environs)
    assert json.loads((tmp_path / "outputs/mine.sweep/summary.json").read_text())["runs"]


def test_a_mark_would_be_seen(tmp_path):
    """What the hostile robots name does leave a file, where it is run."""
    import yaml

    code = yaml.safe_load(CODE)
    module, _, name = code["_target_"].rpartition(".")
    getattr(__import__(module), name)(code["filename"]).close()
    assert (tmp_path / MARK).is_file()


def test_a_plugin_that_only_a_file_names_is_not_imported(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "plugin_of_nobody.py").write_text("open('ran', 'w').close()\n")
    (tmp_path / "robot").mkdir()
    (tmp_path / "robot" / "mine.yaml").write_text(
        "# @package _global_\ndefaults: [override /source: sample]\nplugins: [plugin_of_nobody]\n"
        "validate: {checks: [{_target_: plugin_of_nobody.x}]}\n"
    )
    with pytest.raises(ConfigError, match="E-TRUST plugins"):
        compose_plan(["robot=mine"], judge=plan_problems)
    assert not (tmp_path / "ran").exists()
