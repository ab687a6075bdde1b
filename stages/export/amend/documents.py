"""Finds elements in the XML files of one format, by name and by tag."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from linkwright.stages.formats.own_xml import SECTION_TAGS, kind_of, name_of, named_elements, section_of
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.text.globs import did_you_mean, name_list

ROLES: Mapping[str, tuple[str, ...]] = {"urdf": ("robot",), "mjcf": ("robot", "scene")}
"""Format → the roles of its files, in the order in which its writer names them. The SRDF, which comes after
the URDF, has no role: nothing is added to it."""


class Refused(Exception):
    """Raised for an entry that cannot be applied."""

    def __init__(self, message: str, where: str, hint: str) -> None:
        super().__init__(message)
        self.diagnostic = Diagnostic("E-ELEMENT", message, where, hint)


@dataclass(frozen=True, slots=True)
class XmlFile:
    """An XML file."""

    path: str

    role: str
    """`robot`, or `scene` for the world around it."""

    root: Element


class Documents:
    """The XML files of a format."""

    def __init__(self, form: str, paths: Sequence[str], files: Mapping[str, bytes]) -> None:
        self.form = form
        pairs = zip(paths, ROLES[form], strict=False)
        self.files = [XmlFile(path, role, parse(files[path], large=True)) for path, role in pairs]

    def find_named(self, name: str, tag: str | None, role: str | None, where: str) -> tuple[XmlFile, Element]:
        """Returns the first file that has an element with the name, and the element. `tag`: the tag of the
        element or of its section; `role`: the role of the file. Raises Refused if no element has the name, or
        if several have it."""
        for document in self._with_role(role):
            with_name = [node for node in document.root.iter() if name_of(node) == name]
            matching = [node for node in with_name if tag is None or tag in (node.tag, section_of(node))]
            if len(matching) == 1:
                return document, matching[0]
            if matching:
                raise Refused(*_ambiguous(name, matching, document, where))
        raise Refused(*self._missing_name(name, tag, role, where))

    def find_first(self, tag: str, role: str | None, where: str) -> tuple[XmlFile, Element]:
        """Returns the first element with a tag in the robot's file, or in the file of `role`, and that file.
        A section that an MJCF lacks is added. Raises Refused if the file lacks any other element."""
        (document,) = self._with_role(role or "robot")
        if self.form == "mjcf" and tag in SECTION_TAGS:
            match = document.root.find(tag)
            match = element(document.root, tag) if match is None else match
        else:
            # In a default class of an MJCF, an element has the tag of the elements that it sets defaults for.
            candidates = document.root.iter(tag)
            match = next(
                (
                    candidate
                    for candidate in candidates
                    if self.form != "mjcf" or section_of(candidate) != "default"
                ),
                None,
            )
        if match is None:
            tags = {str(candidate.tag) for candidate in document.root.iter()}
            tags |= SECTION_TAGS if self.form == "mjcf" else set()
            text = f"{document.path} has no element <{tag}>"
            raise Refused(text, where, _near(tag, tags) or f"its elements are: {name_list(tags)}")
        return document, match

    def named_elements(self) -> dict[tuple[str, str], tuple[str, Element]]:
        """Returns (kind, name) → path of the file and element, for all elements with a name."""
        return {
            (kind, name): (document.path, node)
            for document in self.files
            for kind, name, node in named_elements(document.root, self.form == "urdf")
        }

    def contents(self) -> Iterator[tuple[str, bytes]]:
        """Returns (path, content) of each file."""
        return ((document.path, to_bytes(document.root)) for document in self.files)

    def _with_role(self, role: str | None) -> list[XmlFile]:
        return [document for document in self.files if role in (None, document.role)]

    def _missing_name(self, name: str, tag: str | None, role: str | None, where: str) -> tuple[str, str, str]:
        all_names = {
            element_name
            for document in self._with_role(role)
            for node in document.root.iter()
            if (element_name := name_of(node)) and (tag is None or tag in (node.tag, section_of(node)))
        }
        subject = f"no element <{tag}>" if tag else "no element"
        files = " nor ".join(node.path for node in self._with_role(role))
        text = f"{subject} is named {name!r} in {files}"
        return text, where, _near(name, all_names) or f"there are: {name_list(all_names) or 'none'}"


def in_words(node: Element) -> str:
    """Returns an element in words, such as "body torso"."""
    name = name_of(node)
    return f"{node.tag} {name}" if name else f"<{node.tag}>"


def _ambiguous(
    name: str, candidates: Sequence[Element], document: XmlFile, where: str
) -> tuple[str, str, str]:
    """Returns the message, key and hint for a name that several elements have."""
    tags = [str(node.tag) for node in candidates]
    hint = f"say which: tag: {' or '.join(sorted(set(tags) | {kind_of(node) for node in candidates}))}"
    return f"{len(candidates)} elements of {document.path} are named {name!r}: {', '.join(tags)}", where, hint


def _near(name: str, names: Iterable[str]) -> str:
    """Returns a question with up to three similar names, or ""."""
    return did_you_mean(name, sorted(names), 3)
