"""The files that `elements` names are read before a build, and what they hold decides its result."""

import pytest

from linkwright.pipeline.config.plan import Plan
from linkwright.pipeline.element_files import MAX_BYTES, element_texts, require_valid_elements
from linkwright.pipeline.errors import ConfigError
from linkwright.pipeline.run.build import build_files
from linkwright.pipeline.run.preflight import plan_problems


def plan_with(file, **more):
    mount = {"into": {"name": "forearm"}, "file": file}
    keys = {"mesh": {"collider": "visual"}, "until": "export", **more}
    return Plan.parse({"name": "arm", "source": {"kind": "sample"}, "elements": {"mount": mount}, **keys})


def test_a_new_content_makes_new_files_and_the_old_one_the_old_ones(tmp_path):
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


def test_a_folder_is_no_file_paths_start_where_one_works_and_xml_has_a_format(tmp_path, monkeypatch):
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
