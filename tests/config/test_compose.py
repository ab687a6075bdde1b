"""From a command line to a plan, through Hydra."""

import pytest

from linkwright.pipeline.config.compose import compose_plan
from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.errors import ConfigError
from tests.support.users import MY_ARM, URL, write


def plan(folder, *arguments, config_dirs=()):
    return compose_plan(arguments, config_dirs, folder).plan


def refused(folder, *arguments, config_dirs=()):
    with pytest.raises(ConfigError) as caught:
        compose_plan(arguments, config_dirs, folder)
    return str(caught.value)


def test_without_robot_and_source_the_sample_is_built(tmp_path):
    composed = compose_plan([], cwd=tmp_path)
    assert (composed.robot, composed.plan.name, composed.plan.source.kind) == ("sample", "sample", "sample")


def test_with_a_source_alone_the_robot_is_bare(tmp_path):
    composed = compose_plan(["source=sample"], cwd=tmp_path)
    assert composed.robot == "bare"
    assert composed.plan.joints == {}


@pytest.mark.parametrize(
    ("arguments", "name"),
    [
        (["robot=my_arm"], "my_arm"),
        (["robot=my_arm", "name=other"], "other"),
        (["robot=sub/leg-2"], "leg-2"),
        (["robot='odd name'"], "odd_name"),
        (["source=bundle", "source.path=data/Arm v2.zip"], "Arm_v2"),
        (["source=urdf", "source.path=data/arm.v2.urdf"], "arm_v2"),
        (["source=urdf", "source.path=data/arm.urdf.xacro"], "arm"),
        (["source=onshape", f"source.url='{URL}'"], "onshape_a1b2c3d4"),
        (["source=sample"], "sample"),
    ],
)
def test_a_robot_without_a_name_is_named_by_its_file_its_path_or_its_element(tmp_path, arguments, name):
    bare = "# @package _global_\ndefaults: [{override /source: sample}]\n"
    write(tmp_path, my_arm=MY_ARM, **{"sub/leg-2": bare, "odd name": bare})
    assert plan(tmp_path, *arguments).name == name


def test_robots_of_ones_own_come_from_the_working_folder_and_from_config_dir(tmp_path):
    here, there = write(tmp_path / "a b's", one=MY_ARM), write(tmp_path / "there", two=MY_ARM)
    assert plan(here, "robot=one").source.url.text == URL
    assert plan(here, "robot=two", config_dirs=[there]).name == "two"
    assert plan(here, "robot=two", config_dirs=["../there"]).name == "two"


def test_an_option_chosen_on_the_command_line_wins_over_the_robots_file(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    assert plan(tmp_path, "robot=my_arm").root.base == "fixed"
    assert plan(tmp_path, "robot=my_arm", "root=free").root.base == "free"
    assert plan(tmp_path, "robot=my_arm", "root=free", "root.base=auto").root.base == "auto"


def test_keys_of_the_robots_source_are_dropped_when_another_kind_is_chosen(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    assert plan(tmp_path, "robot=my_arm", "source=bundle", "source.path=a.zip").source.path == "a.zip"
    assert plan(tmp_path, "robot=my_arm", "source=sample").source.kind == "sample"
    assert "it belongs to source=onshape" in refused(
        tmp_path, "robot=my_arm", "source=sample", "source.url=http://x"
    )


def test_only_formats_that_are_chosen_are_exported(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    assert (plan(tmp_path, "robot=my_arm").export.urdf, plan(tmp_path, "robot=my_arm").export.mjcf) != (
        None,
        None,
    )
    assert plan(tmp_path, "robot=my_arm").export.urdf is None
    assert plan(tmp_path, "robot=my_arm", "export=urdf").export.mjcf is None
    both = plan(tmp_path, "robot=my_arm", "export=[urdf,mjcf]").export
    assert None not in (both.urdf, both.mjcf)


def test_open_mappings_are_written_without_a_plus_and_field_by_field(tmp_path):
    write(tmp_path, my_arm=MY_ARM)
    joints = plan(
        tmp_path,
        "robot=my_arm",
        "joints.*.friction=0.5",
        "joints.elbow.effort=2",
        "joints.Joint 3.limits=[null,1]",
    ).tree()["joints"]
    given = {
        glob: {key: one for key, one in keys.items() if one is not None} for glob, keys in joints.items()
    }
    assert given == {
        "*": {"damping": 1.0, "friction": 0.5},
        "elbow": {"limits": [-1.0, 1.0], "effort": 2.0},
        "Joint 3": {"limits": [None, 1.0]},
    }


def test_a_mapping_may_be_given_as_a_whole(tmp_path):
    assert plan(tmp_path, "source=sample", "root={base: free}").root.base == "free"


@pytest.mark.parametrize(
    ("robot", "shown"),
    [
        (
            "name: x\n",
            "the configuration has 2 problems\n"
            "  E-MISSING source: the robot has no source\n"
            "      choose one: source=onshape, source=urdf, source=mjcf, source=bundle, source=sample\n"
            "  E-KEY robot: the keys of the robot's file lie under `robot`\n"
            "      the first line of a robot's file must be: # @package _global_",
        ),
        (
            "name: [x\nfoo: : 1\n",
            "the configuration has a problem\n"
            "  E-YAML {file}, line 2, column 4: not valid YAML: expected ',' or ']', but got ':'\n"
            "      check quotes, colons and indentation there",
        ),
        (
            "a: 1\na: 2\n",
            "the configuration has a problem\n"
            "  E-YAML {file}, line 2, column 1: not valid YAML: found a key twice\n"
            "      check quotes, colons and indentation there",
        ),
        (
            "# @package _global_\ndefaults:\n  - override /mesh: hul\n  - override /ground: foo\n"
            "  - override /source: sampel\nsource: {url: x}\nroot: {bse: free}\nmeshh: 1\n",
            "the configuration has 5 problems\n"
            "  E-OPTION mesh=hul: there is no such option\n"
            "      did you mean hull? options: coacd, hull, ladder, primitives, raw, spheres, visual\n"
            "  E-OPTION ground=foo: there is no such option\n"
            "      options: none, plane\n"
            "  E-OPTION source=sampel: there is no such option\n"
            "      did you mean sample or onshape? options: bundle, mjcf, onshape, sample, urdf\n"
            "  E-KEY root.bse: unknown key (given 'free')\n"
            "      did you mean root.base?\n"
            "  E-KEY meshh: unknown key (given 1)\n"
            "      did you mean mesh or names?",
        ),
        (
            "# @package _global_\ndefaults:\n  - override /source: sample\n  - override /mehs: hull\n"
            "until: grph\n",
            "the configuration has 2 problems\n"
            "  E-OVERRIDE robot/mine.yaml: its defaults list overrides mehs, and there is no such group\n"
            "      did you mean mesh?\n"
            "  E-VALUE until: 'grph' is not allowed\n"
            "      did you mean graph? allowed: fetch, graph, mesh, export, validate",
        ),
        (
            "defaults:\n  - override /source: sample\njonts: {}\n",
            "the configuration has 2 problems\n"
            "  E-KEY robot: its defaults list chooses options below `robot`\n"
            "      the first line of a robot's file must be: # @package _global_\n"
            "  E-KEY jonts: unknown key (given {{}})\n"
            "      did you mean joints?",
        ),
        (
            "# @package _global_\ndefaults:\n  - override /source: onshape\n"
            "name: ${nope.x}\nscene: {option: {timestep: '???'}}\nmeshh: 1\n",
            "the configuration has 4 problems\n"
            "  E-MISSING source.url: must be given\n"
            "      set it in the robot's file, or on the command line: "
            "\"source.url='https://cad.onshape.com/documents/...'\"\n"
            "  E-VALUE name: refers to nope.x, which does not exist\n"
            "      an interpolation needs the full key: ${{vars.reach}}\n"
            "  E-MISSING scene.option.timestep: must be given\n"
            "      set it in the robot's file, or on the command line: \"scene.option.timestep='...'\"\n"
            "  E-KEY meshh: unknown key (given 1)\n"
            "      did you mean mesh or names?",
        ),
    ],
    ids=["no header", "broken", "duplicate", "no option", "no group", "no header, but defaults", "missing"],
)
def test_a_fault_in_the_robots_file_is_reported(tmp_path, robot, shown):
    write(tmp_path, mine=robot)
    assert refused(tmp_path, "robot=mine") == shown.format(file=tmp_path / "robot" / "mine.yaml")


def test_a_file_that_is_not_utf8_is_named(tmp_path):
    write(tmp_path, good=MY_ARM)
    file = tmp_path / "robot" / "mine.yaml"
    file.write_bytes(b"# @package _global_\nname: \xff\n")
    assert refused(tmp_path, "robot=mine").endswith(f"E-YAML {file}: not UTF-8 text\n      save it as UTF-8")


def test_a_robot_of_the_same_name_as_ours_is_ambiguous(tmp_path):
    write(tmp_path, sample=MY_ARM)
    shown = refused(tmp_path, "robot=sample")
    assert "conf/robot/sample.yaml and " in shown
    assert str(tmp_path / "robot" / "sample.yaml") in shown
    assert "ambiguous" in refused(tmp_path)


@pytest.mark.parametrize(
    ("arguments", "shown"),
    [
        (["robot=my_rm"], "did you mean my_arm? options: bare, legged, my_arm, sample; robots of your"),
        (["robot=robot/my_arn.yaml"], "there is no such file\n      did you mean my_arm? paths start at"),
        (["robot=robot/config.json"], "config.json: a robot's file is YAML: its name ends in .yaml"),
        (["robot=old"], "{own}/old.yml must end in .yaml"),
        (["robot=null"], "E-OPTION robot=null: there is no such option"),
        (["robot=[my_arm,bare]"], "E-OPTION robot=[my_arm,bare]: expected one option"),
        (["export="], "E-OPTION export=: expected one option"),
        (["export=[urdf,obj]"], "E-OPTION export=obj: there is no such option\n      options: mjcf, python"),
        (["export=[]"], "E-VALUE export: no format is chosen"),
        (["actuators=positon"], "did you mean position? options: damper, general, intvelocity"),
        (["mesh/collider=x"], "E-OVERRIDE mesh/collider=x: there is no such group\n      groups: actuators"),
        (["hydra.searchpath=[x]"], "this part of Hydra is set by linkwright"),
        (["~nope"], "E-OVERRIDE ~nope: does not exist, so it cannot be deleted"),
        (["+name=a", "+name=b"], "E-OVERRIDE +name: exists already"),
        (["hydra.run.dir=x"], "E-OVERRIDE hydra.run.dir=x: this part of Hydra is set by linkwright"),
        (["hydra={verbose: true}"], "E-OVERRIDE hydra={{verbose: true}}: this part of Hydra is set"),
        (["hydra/launcher=joblib"], "hydra/launcher=joblib: has no effect: a single build does not run"),
        (["hydra.verbose=true"], "E-OVERRIDE hydra.verbose=true: has no effect: a single build does not"),
        (["ground=glob(*)"], "E-OVERRIDE ground=glob(*): several values, but no sweep"),
        (["ground=glob(x*)"], "cannot be read: no option matches\n      options: none, plane"),
        (["name=glob(*)"], "cannot be read: glob() chooses among the options of a group\n      groups: act"),
        (["robott=x"], "E-KEY robott: unknown key (given 'x')\n      did you mean robot or root?"),
    ],
)  # fmt: skip
def test_a_choice_that_cannot_be_made_is_reported(tmp_path, arguments, shown):
    write(tmp_path, my_arm=MY_ARM)
    (tmp_path / "robot" / "old.yml").write_text("")
    (tmp_path / "robot" / "config.json").write_text("{}")
    assert shown.format(own=tmp_path / "robot") in refused(tmp_path, *arguments)


def test_everything_wrong_with_a_command_line_is_reported_at_once(tmp_path):
    assert codes(refused(tmp_path, "robot=nope", "mesh=hul", "source.url=https://x?a=b", "new", "foo=1")) == [
        "E-OVERRIDE source.url=https://x?a=b:",
        "E-OVERRIDE new:",
        "E-OPTION robot=nope:",
        "E-OPTION mesh=hul:",
        "E-KEY foo:",
    ]


def codes(shown):
    """The code and the place of each problem."""
    return [" ".join(line.split()[:2]) for line in shown.splitlines() if line.startswith("  E-")]


@pytest.mark.parametrize(
    ("arguments", "found"),
    [
        (["ground=foo", "foo=1"], ["E-OPTION ground=foo:", "E-KEY foo:"]),
        (["source=foo", "source.url=1", "foo=1"], ["E-OPTION source=foo:", "E-KEY foo:"]),
        (
            ["source=onshape", "source.url=https://x?a=b", "foo=1"],
            ["E-OVERRIDE source.url=https://x?a=b:", "E-KEY foo:"],
        ),
        (
            ["source=onshape", "source.url=arm", "ground.size=1"],
            ["E-VALUE source.url:", "E-VALUE ground.size:"],
        ),
        (["robot=nope", "foo=1"], ["E-OPTION robot=nope:", "E-KEY foo:"]),
        (["source=sample", "~nope", "foo=1"], ["E-OVERRIDE ~nope:", "E-KEY foo:"]),
        (["robot=sample", "~nope", "foo=1"], ["E-OVERRIDE ~nope:", "E-KEY foo:"]),
        (
            ["source=sample", "root={base: up}", "export=[]", "until=x"],
            ["E-VALUE root.base:", "E-VALUE export:", "E-VALUE until:"],
        ),
    ],
)  # fmt: skip
def test_a_choice_that_cannot_be_made_does_not_hide_what_else_is_wrong(tmp_path, arguments, found):
    assert sorted(codes(refused(tmp_path, *arguments))) == sorted(found)


def test_what_is_known_before_the_first_stage_is_reported_with_what_is_wrong_in_the_configuration(
    tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    for name in ("ONSHAPE_ACCESS_KEY", "ONSHAPE_SECRET_KEY"):
        monkeypatch.delenv(name, raising=False)
    for wrong in ("foo=1", "ground=foo", "source.foo=1", "hydra.verbose=true"):
        with pytest.raises(ConfigError) as caught:
            compose_plan(["source=onshape", f"source.url='{URL}'", wrong], cwd=tmp_path, judge=plan_problems)
        assert len(caught.value.problems) == 2
        assert "no Onshape API key" in caught.value.problems[1].message


def test_an_id_that_is_read_as_a_number_is_reported_to_be_quoted(tmp_path):
    shown = refused(tmp_path, "source=onshape", "source.url=61234567890123456789e012")
    assert "source.url: must be text (given 6.123456789012345e+31)\n      quote it" in shown
    write(tmp_path, mine="# @package _global_\nsource: {kind: onshape, url: 012345670123456701234567}\n")
    assert "source.url: must be text (given 96374504495306324343)\n      quote it" in refused(
        tmp_path, "robot=mine"
    )


def test_a_config_dir_that_is_not_there_is_reported(tmp_path):
    assert refused(tmp_path, config_dirs=["nope"]).startswith("--config-dir: nope is not a folder")


def test_composing_leaves_no_trace(tmp_path):
    compose_plan(["source=sample"], cwd=tmp_path)
    assert list(tmp_path.iterdir()) == []
