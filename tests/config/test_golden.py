"""Every file in `conf` is composed, judged and held against its golden."""

import pytest
import yaml

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.config.presets import GROUPS, OURS, Presets
from tests.config.regenerate import GOLDEN, names, text


@pytest.mark.parametrize("name", names())
def test_a_file_of_conf_comes_to_its_golden(name, tmp_path):
    golden = GOLDEN / f"{name}.yaml"
    assert text(name, tmp_path) == golden.read_text(encoding="utf-8"), (
        "if this is meant: python -m tests.config.regenerate"
    )


def test_a_golden_of_a_whole_plan_reads_back_as_the_same_plan():
    tree = yaml.safe_load((GOLDEN / "robot.sample.yaml").read_text(encoding="utf-8"))
    assert Plan.parse(tree).tree() == tree


def test_conf_holds_yaml_only_and_each_file_has_a_golden(tmp_path):
    surplus = [file for file in OURS.rglob("*") if file.is_file() and file.suffix not in (".yaml", ".pyc")]
    assert surplus == [OURS / "__init__.py"]
    assert surplus[0].read_bytes() == b""
    assert sorted(file.stem for file in GOLDEN.iterdir()) == sorted(names())
    options = [option for group in GROUPS for option in Presets(cwd=tmp_path).options(group)]
    assert [option for option in options if not isinstance(yaml.safe_load(option), str)] == []
