"""The XML files of one format, in which elements are looked for by name and by tag."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.own_xml import SECTIONS, kind_of, name_of, names, section_of
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import did_you_mean, listed

ROLES: Mapping[str, tuple[str, ...]] = {"urdf": ("robot",), "mjcf": ("robot", "scene")}
"""Format → what its files are, in the order in which its writer names them; the SRDF, which comes after the
URDF, has no role: nothing is added to it."""


class Refused(Exception):
    """An entry that cannot be applied, and why."""

    def __init__(self, message: str, where: str, hint: str) -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic("E-ELEMENT", message, where, hint)


@dataclass(frozen=True, slots=True)
class XmlFile:
    """One file. `role`: whether it is the robot's own, or the scene around it."""

    path: str
    role: str
    root: Element


class Documents:
    """The files of a format."""

    def __init__(self, form: str, paths: Sequence[str], files: Mapping[str, bytes]) -> None:
        self.form = form
        pairs = zip(paths, ROLES[form], strict=False)
        self.every = [XmlFile(path, role, parse(files[path], large=True)) for path, role in pairs]

    def named(self, name: str, tag: str | None, role: str | None, where: str) -> tuple[XmlFile, Element]:
        """The element of a name, and its file: the first that has it. `tag`: its own, or that of its section;
        `role`: of the file. Refused where there is none, or where several have the name."""
        for document in self._of(role):
            every = [one for one in document.root.iter() if name_of(one) == name]
            found = [one for one in every if tag is None or tag in (one.tag, section_of(one))]
            if len(found) == 1:
                return document, found[0]
            if found:
                raise Refused(*_ambiguous(name, found, document, where))
        raise Refused(*self._no_name(name, tag, role, where))

    def first(self, tag: str, role: str | None, where: str) -> tuple[XmlFile, Element]:
        """The first element with a tag in the robot's file, or in that of `role`. Refused where there is
        none; a section of an MJCF is made."""
        (document,) = self._of(role or "robot")
        if self.form == "mjcf" and tag in SECTIONS:
            found = document.root.find(tag)
            found = element(document.root, tag) if found is None else found
        else:
            # The classes of an MJCF have elements of the same tags as what they are for.
            every = document.root.iter(tag)
            found = next((one for one in every if self.form != "mjcf" or section_of(one) != "default"), None)
        if found is None:
            tags = {str(one.tag) for one in document.root.iter()}
            tags |= SECTIONS if self.form == "mjcf" else set()
            text = f"{document.path} has no element <{tag}>"
            raise Refused(text, where, _near(tag, tags) or f"its elements are: {listed(tags)}")
        return document, found

    def taken(self) -> dict[tuple[str, str], tuple[str, Element]]:
        """(kind, name) → file and element of all that has a name of its own."""
        return {
            (kind, name): (document.path, one)
            for document in self.every
            for kind, name, one in names(document.root, self.form == "urdf")
        }

    def written(self) -> Iterator[tuple[str, bytes]]:
        """(path, text) of each file."""
        return ((one.path, to_bytes(one.root)) for one in self.every)

    def _of(self, role: str | None) -> list[XmlFile]:
        return [one for one in self.every if role in (None, one.role)]

    def _no_name(self, name: str, tag: str | None, role: str | None, where: str) -> tuple[str, str, str]:
        every = {
            found
            for document in self._of(role)
            for one in document.root.iter()
            if (found := name_of(one)) and (tag is None or tag in (one.tag, section_of(one)))
        }
        what = f"no element <{tag}>" if tag else "no element"
        files = " nor ".join(one.path for one in self._of(role))
        text = f"{what} is named {name!r} in {files}"
        return text, where, _near(name, every) or f"there are: {listed(every) or 'none'}"


def said(one: Element) -> str:
    """An element in words: "body torso"."""
    name = name_of(one)
    return f"{one.tag} {name}" if name else f"<{one.tag}>"


def _ambiguous(name: str, found: Sequence[Element], document: XmlFile, where: str) -> tuple[str, str, str]:
    tags = [str(one.tag) for one in found]
    hint = f"say which: tag: {' or '.join(sorted(set(tags) | {kind_of(one) for one in found}))}"
    return f"{len(found)} elements of {document.path} are named {name!r}: {', '.join(tags)}", where, hint


def _near(name: str, every: Iterable[str]) -> str:
    return did_you_mean(name, sorted(every), 3)
