"""Errors found before anything is built: files of `elements`, and names in the configuration."""

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.element_files import MAX_BYTES, element_texts, require_valid_elements
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.run.build import build, build_files
from linkwright.pipeline.run.preflight import plan_problems
from linkwright.stages.robot.errors import LinkwrightError, MeshError
from tests.support.building import plan_of


def plan_with(file, **more):
    mount = {"into": {"name": "forearm"}, "file": file}
    keys = {"mesh": {"collider": "visual"}, "until": "export", **more}
    return Plan.parse({"name": "arm", "source": {"kind": "sample"}, "elements": {"mount": mount}, **keys})


def test_content_of_a_file_decides_the_result(tmp_path):
    file = tmp_path / "mount.xml"
    plan = plan_with(str(file), cache={"dir": str(tmp_path / "cache")})

    def built(text):
        file.write_text(text, encoding="utf-8")
        made = build_files(plan, in_memory=True)
        return made.files["arm.xml"], [stage.cached for stage in made.report.stages]

    first, _ = built("<site name='here'/>")
    second, cached = built("<site name='there'/>")
    assert cached == [True, True, True, False]
    assert b'<site name="here"/>' in first
    assert b'<site name="there"/>' in second
    assert built("<site name='here'/>") == (first, [True] * 4)


@pytest.mark.parametrize(("content", "said"), [
    (None, "does not exist"),
    (b"<site>", "is not XML: line 1, column 7: an element of line 1 is not closed"),
    (b"<site name='\xff'/>", "is not readable as text"),
    (b"<!-- nothing -->", "there is no element"),
    (b" " * (MAX_BYTES + 1), "more than"),
])  # fmt: skip
def test_a_file_that_cannot_be_read_is_named_before_the_build(tmp_path, content, said):
    file = tmp_path / "mount.xml"
    if content is not None:
        file.write_bytes(content)
    (problem,) = plan_problems(plan_with(str(file)), {})
    assert problem.where == "elements.mount.file"
    assert said in problem.message


def test_folder_and_unknown_element_are_refused(tmp_path, monkeypatch):
    with pytest.raises(ConfigError, match="is a folder"):
        element_texts(plan_with(str(tmp_path)))
    (tmp_path / "mount.xml").write_text("<sitee/>")
    monkeypatch.chdir(tmp_path)
    assert element_texts(plan_with("mount.xml")) == {"mount": "<sitee/>"}
    with pytest.raises(ConfigError) as caught:
        require_valid_elements(plan_with("mount.xml"))
    (problem,) = caught.value.problems
    assert (problem.code, problem.where) == ("E-ELEMENT", "elements.mount")
    assert "<sitee>" in problem.message


ASKED = {
    "actuators": {"elbw": "position", "zz*": "motor"},
    "sensors": {
        "angles": {"type": "joint", "joints": "nope*"},
        "forces": {"type": "actuator", "actuators": "nope*"},
        "imu": "imu",
        "gap": {"type": "frame", "frame": "palm", "relative_to": "plam"},
        "eye": {"type": "camera", "frame": "palm", "sees": ["palm", "nobody"]},
    },
    "scene": {"cameras": {"top": {"frame": "roof"}}},
    "validate": {"payload": {"tol": 1.0}},
}
UNKNOWN = [
    ("E-GLOB", "actuators"),
    ("E-GLOB", "actuators"),
    ("E-FRAME", "scene.cameras.top.frame"),
    ("E-GLOB", "sensors.angles.joints"),
    ("E-FRAME", "sensors.eye.sees"),
    ("E-GLOB", "sensors.forces.actuators"),
    ("E-FRAME", "sensors.gap.relative_to"),
    ("E-FRAME", "sensors.imu.frame"),
    ("E-VALUE", "validate.payload.tol"),
]
KNOWN = {
    "actuators": {"elbow": "position"},
    "sensors": {"angles": {"type": "joint", "joints": "el*"}, "tool": "imu", "a": {"type": "actuator"}},
    "scene": {"cameras": {"top": {"frame": "tool"}}},
    "validate": {"payload": {"tool": 1.0}},
}


@pytest.mark.parametrize(("keys", "until", "count"), [
    (ASKED, "validate", 9), (ASKED, "export", 8), (ASKED, "mesh", 0), (KNOWN, "validate", 0),
])  # fmt: skip
def test_unknown_names_are_told_together_before_the_meshes(tmp_path, monkeypatch, keys, until, count):
    """As many of them as the stages until the last would meet."""

    def made(*_):
        raise MeshError("the meshes are made")

    monkeypatch.setattr("linkwright.pipeline.stages.stage.make_geometry", made)
    plan = plan_of(**keys, until=until, output=str(tmp_path / "arm"), cache={"dir": str(tmp_path / "cache")})
    with pytest.raises(LinkwrightError) as caught:
        build(plan, environ={})
    assert [(problem.code, problem.where) for problem in caught.value.problems] == UNKNOWN[:count]
    assert (caught.value.message == "the meshes are made") == (count == 0)
