"""Robots whose YAML tries to run code: nothing that they name is run.

One of them meets the installed command in every way; the others meet it in this process, where it takes a
tenth of the time.
"""

import pytest

from tests.support.command import called, environment, linkwright, tree
from tests.support.hostile import CODE, ROBOTS, write

WAYS = {
    "single": ["robot=mine"],
    "sweep": ["-m", "robot=mine", "root=auto,free"],
    "swept over": ["-m", "robot=mine,sample"],
    "in other processes": ["-m", "robot=mine", "root=auto,free", "hydra/launcher=workstation"],
    "by an experiment": ["-m", "+experiment=mine", "root=auto,free"],
}


CASES = [
    (name, way)
    for name, (chosen, *_) in ROBOTS.items()
    for way in WAYS
    # A launcher that is typed takes the place of the file's.
    if way != "in other processes" or "hydra/launcher" not in chosen
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "way"), CASES)
def test_a_hostile_robot_is_refused_and_leaves_nothing(tmp_path, name, way):
    for file in ("robot/mine.yaml", "experiment/mine.yaml"):
        write(tmp_path, name, file)
    before = tree(tmp_path)
    command = linkwright if name == next(iter(ROBOTS)) else called
    done = command(tmp_path, *WAYS[way], environ=environment(tmp_path, seeded=False, EVIL=CODE))
    assert (done.returncode, done.stdout) == (2, "")
    assert "Traceback" not in done.stderr
    assert "bug in linkwright" not in done.stderr
    assert tree(tmp_path) == before


@pytest.mark.slow
@pytest.mark.parametrize("file", ["hydra_plugins/evil.py", "conf/__init__.py", "pipeline/__init__.py"])
def test_modules_in_the_working_folder_are_not_imported(tmp_path, file):
    (tmp_path / file).parent.mkdir()
    (tmp_path / file).write_text("open('i-was-here', 'w')")
    linkwright(tmp_path, "source=sample", "until=fetch", status=0)
    assert not (tmp_path / "i-was-here").exists()
