"""Faults to plant in a finished build, each of which the build's checks must find and name.

A kind changes one place of one file. Where and by how much comes from a seed, so that other seeds are other
faults. `Planted` says what a finding must name: the element of the file, and one of some attributes.
"""

import random
import shutil
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

from linkwright.stages.robot.check import Check

Element = etree._Element


@dataclass(frozen=True)
class Planted:
    """`element`: a finding names it, or one of `others`; `attributes`: one of which it names."""

    element: str
    attributes: tuple[str, ...]
    others: tuple[str, ...] = ()


@dataclass
class Files:
    """A finished build, to be changed. `name`: the robot's."""

    folder: Path
    name: str
    trees: dict[str, Element] = field(default_factory=dict)

    @property
    def urdf(self) -> Element:
        return self.tree(f"{self.name}.urdf")

    @property
    def mjcf(self) -> Element:
        return self.tree(f"{self.name}.xml")

    @property
    def scene(self) -> Element:
        return self.tree("scene.xml")

    @property
    def sdf(self) -> Element:
        return self.tree(f"{self.name}.sdf")

    @property
    def srdf(self) -> Element:
        return self.tree(f"{self.name}.srdf")

    def tree(self, file: str) -> Element:
        if file not in self.trees:
            self.trees[file] = etree.parse(self.folder / file).getroot()
        return self.trees[file]

    def save(self) -> None:
        for file, root in self.trees.items():
            (self.folder / file).write_bytes(etree.tostring(root, xml_declaration=True, encoding="utf-8"))

    def asset(self, file: str) -> Path:
        return self.folder / "assets" / file


class NothingToChange(Exception):
    """The build has nothing that this fault could be planted in."""


NEEDED = {
    "urdf": ("{}.urdf",),
    "mjcf": ("{}.xml",),
    "scene": ("{}.xml", "scene.xml"),
    "assets": ("{}.urdf", "{}.xml"),
    "sdf": ("{}.sdf", "{}.xml"),
    "srdf": ("{}.srdf",),
    "config": ("model.config", "{}.sdf"),
    "usd": ("{}.usda", "{}_meshes.usd"),
    "ros2": ("ros2",),
    "python": ("python", "{}.urdf", "{}.srdf", "{}.xml", "scene.xml", "{}.sdf", "{}.usda", "{}_meshes.usd"),
}
"""By where a fault is planted: that file or folder, and what it is checked with; {} is the robot's name."""

Plant = Callable[[Files, random.Random], Planted]


@dataclass(frozen=True)
class Kind:
    """A kind of fault. `file`: where it is planted, by a word of `NEEDED`; `codes`: of the checks of
    which one names it; `simcheck`: what simcheck calls it, "" if that does not plant it."""

    name: str
    file: str
    codes: tuple[str, ...]
    plant: Plant
    simcheck: str = ""


class Kinds(list[Kind]):
    """The kinds of faults that are planted in one file."""

    def __init__(self, file: str) -> None:
        self.file = file

    def add(self, name: str, *codes: str, simcheck: str = "") -> Callable[[Plant], Plant]:
        """Makes a function that plants a fault a kind of it."""

        def kept(plant: Plant) -> Plant:
            self.append(Kind(name, self.file, codes, plant, simcheck))
            return plant

        return kept


def plant(one: Kind, source: Path, name: str, folder: Path, seed: int, *, whole: bool = False) -> Planted:
    """A copy of the build at `source` in `folder`, with a fault: of the file in which it is, its assets and
    what it includes, or `whole`. NothingToChange where the build has no place for it."""
    if whole:
        shutil.copytree(source, folder)
    else:
        folder.mkdir()
        shutil.copytree(source / "assets", folder / "assets")
        for file in ("robot.json", *(file.format(name) for file in NEEDED[one.file])):
            copied = shutil.copytree if (source / file).is_dir() else shutil.copy
            copied(source / file, folder / file)
    files = Files(folder, name)
    planted = one.plant(files, random.Random(f"{one.name} in {one.file}, {seed}"))
    files.save()
    return planted


def catches(one: Kind, planted: Planted, checks: Sequence[Check]) -> list[str]:
    """The codes of the checks that did not pass and name what was planted, by element and attribute."""
    names = (planted.element, *planted.others)
    return [
        check.code
        for check in checks
        if not check.passed
        and check.code in one.codes
        and any(
            any(name in found.element for name in names)
            and any(attribute in found.attribute for attribute in planted.attributes)
            for found in check.findings
        )
    ]
