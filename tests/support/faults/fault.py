"""A fault to plant in a file, which the checks must find and name: a row of a table `kind, plant, expects`.

A fault changes one place of one file. Where and by how much comes from a seed, so that other seeds are other
faults. What a finding must name is an element of the file, and one of some attributes.
"""

import random
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from lxml import etree

Element = etree._Element

PLACES = {
    "urdf": "{}.urdf",
    "mjcf": "{}.xml",
    "scene": "scene.xml",
    "sdf": "{}.sdf",
    "srdf": "{}.srdf",
    "usd": "{}.usda",
    "config": "model.config",
    "bare urdf": "{}.urdf",
    "bare mjcf": "{}.xml",
}
"""The file in which a fault is planted, by the word for it in a row; {} is the robot's name."""


@dataclass
class Files:
    """A robot's files, to be changed. `name`: the robot's; `file`: as in `Fault`."""

    folder: Path
    name: str
    file: str
    trees: dict[str, Element] = field(default_factory=dict)

    @property
    def path(self):
        return self.folder / PLACES[self.file].format(self.name)

    @property
    def root(self):
        """The root of the file in which the fault is planted."""
        return self.tree(self.file)

    def tree(self, file):
        path = PLACES[file].format(self.name)
        if path not in self.trees:
            self.trees[path] = etree.parse(self.folder / path).getroot()
        return self.trees[path]

    def save(self):
        for path, root in self.trees.items():
            (self.folder / path).write_bytes(etree.tostring(root, xml_declaration=True, encoding="utf-8"))


class NothingToChange(Exception):
    """The robot has nothing that this fault could be planted in."""


@dataclass(frozen=True)
class Planted:
    """A finding names one of the `elements` and one of the `attributes`."""

    elements: tuple[str, ...]
    attributes: tuple[str, ...]


Names = str | tuple[str, ...]

Plant = Callable[[Files, random.Random], Names | Planted]
"""Plants a fault and returns the elements of which a finding names one, or what it names if that depends on
the place."""


@dataclass(frozen=True)
class Fault:
    """`file`: where it is planted, by a word of `PLACES` or `NEEDED`; `expects`: the codes of the checks of
    which one names it and the attributes of which one is named, or what else its test expects; `simcheck`:
    simcheck's name of it, "" for none."""

    kind: str
    file: str
    plant: Plant
    expects: str
    simcheck: str = ""

    @property
    def codes(self):
        return tuple(self.expects.partition(":")[0].split())

    @property
    def attributes(self):
        return tuple(attribute.strip() for attribute in self.expects.partition(":")[2].split("|"))

    @property
    def title(self):
        return f"{self.file}: {self.kind}"

    def change(self, folder, name, seed=0):
        """Plants it in the files in a folder."""
        files = Files(folder, name, self.file)
        names = self.plant(files, random.Random(f"{self.kind} in {self.file}, {seed}"))
        files.save()
        if isinstance(names, Planted):
            return names
        return Planted((names,) if isinstance(names, str) else names, self.attributes)


def table(file, *rows):
    """The faults of a file: `kind, plant, expects`, and simcheck's name of it where that plants it too.
    `expects`: codes, a colon, and attributes with bars between them."""
    return [Fault(kind, file, plant, *words) for kind, plant, *words in rows]


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
"""By where a fault is planted in a build: that file or folder, and what it is checked with."""


def plant(fault, source, name, folder, seed, *, whole=False):
    """Copies the build at `source` to `folder`, with a fault: the file in which it is, its assets and what it
    includes, or `whole`. NothingToChange where the build has no place for it."""
    if whole:
        shutil.copytree(source, folder)
    else:
        folder.mkdir()
        shutil.copytree(source / "assets", folder / "assets")
        for file in ("robot.json", *(file.format(name) for file in NEEDED[fault.file])):
            copied = shutil.copytree if (source / file).is_dir() else shutil.copy
            copied(source / file, folder / file)
    return fault.change(folder, name, seed)


def catches(fault, planted, checks):
    """The codes of the checks that did not pass and name what was planted, by element and attribute."""
    return [
        check.code
        for check in checks
        if not check.passed
        and check.code in fault.codes
        and any(
            any(name in finding.element for name in planted.elements)
            and any(attribute in finding.attribute for attribute in planted.attributes)
            for finding in check.findings
        )
    ]
