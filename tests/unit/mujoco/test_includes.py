"""Included files in the place of each <include>, with MuJoCo's own reading as the oracle."""

from pathlib import Path

import mujoco

from linkwright.stages.formats.xml import parse, to_bytes
from linkwright.stages.mujoco.compile import compiled_file, compiled_text
from linkwright.stages.mujoco.includes import resolve

FILES = {
    "scene.xml": '<mujoco><worldbody><body name="a"><geom size="1"/></body></worldbody>'
    '<include file="parts/b.xml"/><include file="e.xml"/>'
    '<worldbody><body name="f"><geom size="1"/></body></worldbody></mujoco>',
    "parts/b.xml": '<mujoco><worldbody><body name="b"><geom size="1"/><include file="parts/c.xml"/></body>'
    '<body name="d"><geom size="1"/></body></worldbody></mujoco>',
    "parts/c.xml": '<mujoco><body name="c"><geom size="1"/></body></mujoco>',
    "e.xml": '<mujoco><worldbody><body name="e"><geom size="1"/></body></worldbody></mujoco>',
}
"""Paths count from the folder of the first file."""


def bodies(model: mujoco.MjModel) -> list[str]:
    return [model.body(index).name for index in range(1, model.nbody)]


def test_a_document_without_includes_is_what_mujoco_makes_of_the_files(tmp_path: Path) -> None:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    root = parse(FILES["scene.xml"].encode())
    resolve(root, lambda include: parse(FILES[include.get("file")].encode()))
    found = bodies(compiled_text(to_bytes(root), {}))
    assert found == bodies(compiled_file(tmp_path / "scene.xml")) == list("abcdef")


def test_of_what_is_not_read_nothing_is_included() -> None:
    root = parse(FILES["scene.xml"].encode())
    resolve(root, lambda _: None)
    assert list(root.iter("include")) == []
    assert bodies(compiled_text(to_bytes(root), {})) == ["a", "f"]
