"""What is edited into a finished URDF is found, and what was asked for is not."""

from pathlib import Path

import pytest

from tests.support.mutated_builds import built, checks_of, hinge_document


@pytest.mark.parametrize("package", [None, "arm_description"])
def test_meshes_of_the_package_that_was_asked_for_are_found_and_others_not(
    package: str | None, tmp_path: Path
) -> None:
    urdf = {"meshes": "package", "package": package}
    build = built(hinge_document(), tmp_path / "build", {"export": {"urdf": urdf, "mjcf": {}}})
    path = build.folder / f"{build.name}.urdf"
    assert [one for one in checks_of(build.folder) if one.code == "C-PATH" and one.fails] == []
    text = path.read_text()
    own = f"package://{package or build.name}/assets"
    assert own in text
    path.write_text(text.replace(own, "package://other/assets", 1))
    (check,) = [one for one in checks_of(build.folder) if one.code == "C-PATH" and one.fails]
    assert 'no folder of a package "other" has this file' in check.findings[0].message


def test_a_velocity_that_is_gone_is_said_to_be_missing(tmp_path: Path) -> None:
    build = built(hinge_document(), tmp_path / "build", {"joints": {"*": {"velocity": 3, "effort": 2}}})
    path = build.folder / f"{build.name}.urdf"
    path.write_text(path.read_text().replace(' velocity="3"', "", 1))
    messages = [
        one.message
        for check in checks_of(build.folder)
        for one in check.findings
        if one.attribute == "limit velocity"
    ]
    assert messages == ["is missing, expected 3"]
