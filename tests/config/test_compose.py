# ruff: noqa: E501
"""From a command line to a plan, through Hydra."""

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.errors import ConfigError
from tests.support.users import GLOBAL, MY_ARM, URL, composed, refused, write

HEAD = f"{GLOBAL}defaults:\n"


@pytest.fixture
def here(tmp_path):
    return write(tmp_path, my_arm=MY_ARM)


def plan(folder, *arguments, dirs=()):
    return composed(folder, *arguments, dirs=dirs).plan


def test_the_robot_is_the_sample_or_with_a_source_alone_bare(tmp_path):
    made = composed(tmp_path)
    assert (made.robot, made.plan.name, made.plan.source.kind) == ("sample", "sample", "sample")
    made = composed(tmp_path, "source=sample", "root={base: free}")
    assert (made.robot, made.plan.joints, made.plan.root.base) == ("bare", {}, "free")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("arguments", "name"), [
    (["robot=my_arm"], "my_arm"),
    (["robot=my_arm", "name=other"], "other"),
    (["robot=sub/leg-2"], "leg-2"),
    (["robot='odd name'"], "odd_name"),
    (["source=bundle", "source.path=data/Arm v2.zip"], "Arm_v2"),
    (["source=urdf", "source.path=data/arm.v2.urdf"], "arm_v2"),
    (["source=urdf", "source.path=data/arm.urdf.xacro"], "arm"),
    (["source=onshape", f"source.url='{URL}'"], "onshape_a1b2c3d4"),
    (["source=sample"], "sample"),
])  # fmt: skip
def test_robot_without_a_name_is_named_by_its_source(here, arguments, name):
    bare = f"{GLOBAL}defaults: [{{override /source: sample}}]\n"
    assert plan(write(here, **{"sub/leg-2": bare, "odd name": bare}), *arguments).name == name


def test_user_robots_are_in_the_working_folder_or_config_dir(tmp_path):
    here, there = write(tmp_path / "a b's", one=MY_ARM), write(tmp_path / "there", two=MY_ARM)
    assert plan(here, "robot=one").source.url.text == URL
    assert plan(here, "robot=two", dirs=[there]).name == "two"
    assert plan(here, "robot=two", dirs=["../there"]).name == "two"


def test_command_line_wins_over_the_robots_file(here):
    for typed, base in (([], "fixed"), (["root=free"], "free"), (["root=free", "root.base=auto"], "auto")):
        assert plan(here, "robot=my_arm", *typed).root.base == base
    assert plan(here, "robot=my_arm", "source=bundle", "source.path=a.zip").source.path == "a.zip"
    assert plan(here, "robot=my_arm", "source=sample").source.kind == "sample"
    shown = refused(here, "robot=my_arm", "source=sample", "source.url=http://x")
    assert "it belongs to source=onshape" in shown


@pytest.mark.parametrize(
    ("arguments", "chosen"), [([], ["mjcf"]), (["export=urdf"], ["urdf"]), (["export=[urdf,mjcf]"], ["urdf", "mjcf"])]
)  # fmt: skip
def test_only_chosen_formats_are_exported(here, arguments, chosen):
    export = plan(here, "robot=my_arm", *arguments).export
    assert [name for name in ("urdf", "mjcf") if getattr(export, name) is not None] == chosen


@pytest.mark.parametrize(("arguments", "expected"), [
    ([], {"mjx": 7}),
    (["target=none"], {}),
    (["target=drake"], {"drake": None}),
    (["target=[mjx,drake]"], {"mjx": 7, "drake": None}),
    (["target=drake", "target.mjx.iterations=9"], {"mjx": 9, "drake": None}),
    (["target.drake={}"], {"mjx": 7, "drake": None}),
])  # fmt: skip
def test_targets_of_the_command_line_are_in_place_of_the_robots(tmp_path, arguments, expected):
    write(tmp_path, my_arm=f"{MY_ARM}target: {{mjx: {{iterations: 7}}}}\n")
    target = plan(tmp_path, "robot=my_arm", *arguments).target
    assert {name: getattr(getattr(target, name), "iterations", None) for name in target.chosen} == expected


def test_open_mappings_are_written_field_by_field(here):
    typed = ["joints.*.friction=0.5", "joints.elbow.effort=2", "joints.Joint 3.limits=[null,1]"]
    joints = plan(here, "robot=my_arm", *typed).tree()["joints"]
    assert {glob: {key: value for key, value in keys.items() if value is not None} for glob, keys in joints.items()} == {
        "*": {"damping": 1.0, "friction": 0.5},
        "elbow": {"limits": [-1.0, 1.0], "effort": 2.0},
        "Joint 3": {"limits": [None, 1.0]},
    }  # fmt: skip


FAULTS = {
    "no header": ("name: x\n", """the configuration has 2 problems
  E-MISSING source: the robot has no source
      choose one: source=onshape, source=urdf, source=mjcf, source=bundle, source=sample
  E-KEY robot: the keys of the robot's file are under `robot`
      the first line of a robot's file must be: # @package _global_"""),
    "broken": ("name: [x\nfoo: : 1\n", """the configuration has a problem
  E-YAML {file}, line 2, column 4: not valid YAML: expected ',' or ']', but got ':'
      check quotes, colons and indentation there"""),
    "no option": (f"{HEAD}  - override /mesh: hul\n  - override /ground: foo\n  - override /source: sampel\nsource: {{url: x}}\nroot: {{bse: free}}\nmeshh: 1\n", """the configuration has 5 problems
  E-OPTION mesh=hul: there is no such option
      did you mean hull? options: coacd, hull, ladder, primitives, raw, spheres, visual
  E-OPTION ground=foo: there is no such option
      options: none, plane
  E-OPTION source=sampel: there is no such option
      did you mean sample or onshape? options: bundle, mjcf, onshape, sample, urdf
  E-KEY root.bse: unknown key (given 'free')
      did you mean root.base?
  E-KEY meshh: unknown key (given 1)
      did you mean mesh or names?"""),
    "no group": (f"{HEAD}  - override /source: sample\n  - override /mehs: hull\nuntil: grph\n", """the configuration has 2 problems
  E-OVERRIDE robot/mine.yaml: its defaults list overrides mehs, and there is no such group
      did you mean mesh?
  E-VALUE until: 'grph' is not allowed
      did you mean graph? allowed: fetch, graph, mesh, export, validate"""),
    "no header, but defaults": ("defaults:\n  - override /source: sample\njonts: {}\n", """the configuration has 2 problems
  E-KEY robot: its defaults list chooses options below `robot`
      the first line of a robot's file must be: # @package _global_
  E-KEY jonts: unknown key (given {{}})
      did you mean joints?"""),
    "missing": (f"{HEAD}  - override /source: onshape\nname: ${{nope.x}}\nscene: {{option: {{timestep: '???'}}}}\nmeshh: 1\n", """the configuration has 4 problems
  E-MISSING source.url: must be given
      set it in the robot's file, or on the command line: "source.url='https://cad.onshape.com/documents/...'"
  E-VALUE name: refers to nope.x, which does not exist
      an interpolation needs the full key: ${{vars.reach}}
  E-MISSING scene.option.timestep: must be given
      set it in the robot's file, or on the command line: "scene.option.timestep='...'"
  E-KEY meshh: unknown key (given 1)
      did you mean mesh or names?"""),
}  # fmt: skip
"""Kind of fault → a robot's file, and all that is said of it."""


@pytest.mark.parametrize("kind", FAULTS)
def test_a_fault_in_the_robots_file_is_reported(tmp_path, kind):
    robot, shown = FAULTS[kind]
    write(tmp_path, mine=robot)
    assert refused(tmp_path, "robot=mine") == shown.format(file=tmp_path / "robot" / "mine.yaml")


def test_a_file_that_is_not_utf8_is_named(here):
    file = here / "robot" / "mine.yaml"
    file.write_bytes(b"# @package _global_\nname: \xff\n")
    assert refused(here, "robot=mine").endswith(f"E-YAML {file}: not UTF-8 text\n      save it as UTF-8")


def test_a_robot_of_the_same_name_as_ours_is_ambiguous(tmp_path):
    shown = refused(write(tmp_path, sample=MY_ARM), "robot=sample")
    assert "conf/robot/sample.yaml and " in shown
    assert str(tmp_path / "robot" / "sample.yaml") in shown
    assert "ambiguous" in refused(tmp_path)


@pytest.mark.parametrize(("arguments", "shown"), [
    (["robot=my_rm"], "did you mean my_arm? robots: bare, "),
    (["robot=robot/my_arn.yaml"], "there is no such file\n      did you mean my_arm? paths start at"),
    (["robot=robot/config.json"], "config.json: a robot's file is YAML: its name ends in .yaml"),
    (["robot=old"], "{own}/old.yml must end in .yaml"),
    (["robot=null"], "E-OPTION robot=null: there is no such robot"),
    (["robot=[my_arm,bare]"], "E-OPTION robot=[my_arm,bare]: expected one option"),
    (["export="], "E-OPTION export=: expected one option"),
    (["export=[urdf,obj]"], "E-OPTION export=obj: there is no such option\n      options: mjcf, python"),
    (["export=[]"], "E-VALUE export: no format is chosen"),
    (["actuators=positon"], "did you mean position? options: damper, general, intvelocity"),
    (["mesh/collider=x"], "E-OVERRIDE mesh/collider=x: there is no such group\n      groups: actuators"),
    (["hydra.searchpath=[x]"], "this part of Hydra is set by linkwright"),
    (["hydra.run.dir=x"], "E-OVERRIDE hydra.run.dir=x: this part of Hydra is set by linkwright"),
    (["hydra={verbose: true}"], "E-OVERRIDE hydra={{verbose: true}}: this part of Hydra is set"),
    (["hydra/launcher=joblib"], "hydra/launcher=joblib: has no effect: a single build does not run"),
    (["hydra.verbose=true"], "E-OVERRIDE hydra.verbose=true: has no effect: a single build does not"),
    (["ground=glob(*)"], "E-OVERRIDE ground=glob(*): several values, but no sweep"),
    (["ground=glob(x*)"], "cannot be read: no option matches\n      options: none, plane"),
    (["name=glob(*)"], "cannot be read: glob() chooses among the options of a group\n      groups: act"),
    (["robott=x"], "E-KEY robott: unknown key (given 'x')\n      did you mean robot or root?"),
    (["source=onshape", "source.url=61234567890123456789e012"], "source.url: must be text (given 6.123456789012345e+31)\n      quote it"),
    (["robot=number"], "source.url: must be text (given 96374504495306324343)\n      quote it"),
])  # fmt: skip
def test_a_choice_that_cannot_be_made_is_reported(here, arguments, shown):
    if arguments == ["robot=number"]:
        write(here, number=f"{GLOBAL}source: {{kind: onshape, url: 012345670123456701234567}}\n")
    (here / "robot" / "old.yml").write_text("")
    (here / "robot" / "config.json").write_text("{}")
    assert shown.format(own=here / "robot") in refused(here, *arguments)


@pytest.mark.parametrize(("arguments", "expected"), [
    (["ground=foo", "foo=1"], ["E-OPTION ground=foo:", "E-KEY foo:"]),
    (["source=foo", "source.url=1", "foo=1"], ["E-OPTION source=foo:", "E-KEY foo:"]),
    (["source=onshape", "source.url=https://x?a=b", "foo=1"], ["E-OVERRIDE source.url=https://x?a=b:", "E-KEY foo:"]),
    (["source=onshape", "source.url=arm", "ground.size=1"], ["E-VALUE ground.size:", "E-VALUE source.url:"]),
    (["robot=nope", "foo=1"], ["E-OPTION robot=nope:", "E-KEY foo:"]),
    (["source=sample", "~nope", "foo=1"], ["E-OVERRIDE ~nope:", "E-KEY foo:"]),
    (["robot=sample", "~nope", "foo=1"], ["E-OVERRIDE ~nope:", "E-KEY foo:"]),
    (["source=sample", "root={base: up}", "export=[]", "until=x"], ["E-VALUE export:", "E-VALUE root.base:", "E-VALUE until:"]),
    (
        ["robot=nope", "mesh=hul", "source.url=https://x?a=b", "new", "foo=1"],
        ["E-OVERRIDE source.url=https://x?a=b:", "E-OVERRIDE new:", "E-OPTION robot=nope:", "E-OPTION mesh=hul:", "E-KEY foo:"],
    ),
])  # fmt: skip
def test_impossible_choice_hides_no_other_problem(tmp_path, arguments, expected):
    lines = refused(tmp_path, *arguments).splitlines()
    codes = [" ".join(line.split()[:2]) for line in lines if line.startswith("  E-")]
    assert codes == expected


@pytest.mark.parametrize("wrong", ["foo=1", "ground=foo", "source.foo=1", "hydra.verbose=true"])
def test_problems_of_preflight_and_configuration_come_together(tmp_path, monkeypatch, wrong):
    monkeypatch.chdir(tmp_path)
    for name in ("ONSHAPE_ACCESS_KEY", "ONSHAPE_SECRET_KEY"):
        monkeypatch.delenv(name, raising=False)
    with pytest.raises(ConfigError) as caught:
        compose_plan(["source=onshape", f"source.url='{URL}'", wrong], cwd=tmp_path, judge=plan_problems)
    assert len(caught.value.problems) == 2
    assert "no Onshape API key" in caught.value.problems[1].message
