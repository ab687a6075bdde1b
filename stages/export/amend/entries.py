"""Reads the entries of `elements` and `attributes`, each of which can change the files of a format."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.amend.documents import Documents, Refused, XmlFile, in_words
from linkwright.stages.export.configuration.element_section import FORMATS, TAG
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.own_xml import language_of, named_elements, unknown_tag
from linkwright.stages.formats.xml import Element, Malformed, element, fragment
from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.robot.text.globs import name_list

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.element_section import IntoSection
    from linkwright.stages.export.section import ExportSections


@dataclass(frozen=True, slots=True)
class Insertion:
    """An entry of `elements`: elements to add to a target."""

    key: str
    """The key path of the entry in the configuration."""

    formats: tuple[str, ...]
    into: "IntoSection"
    elements: tuple[Element, ...]

    def apply(self, documents: Documents) -> Amendment:
        """Adds the elements. Raises Refused if the target does not exist, or a name of theirs is taken."""
        where, into = f"{self.key}.into", self.into
        if into.name is not None:
            document, target = documents.find_named(into.name, into.tag, into.file, where)
        else:
            document, target = documents.find_first(str(into.tag), into.file, where)
        taken = documents.named_elements()
        holder = _parent_for(target) if documents.form == "mjcf" else target
        added = [deepcopy(node) for node in self.elements]
        holder.extend(added)
        self._require_new_names(document, added, taken, documents.form == "urdf")
        return Amendment(self.key, document.path, in_words(target), tuple(map(in_words, added)))

    def _require_new_names(
        self,
        document: XmlFile,
        added: Sequence[Element],
        taken: Mapping[tuple[str, str], tuple[str, Element]],
        urdf: bool,
    ) -> None:
        """Raises Refused if an added element has the name of another. `taken`: (kind, name) → path of the
        file and element, before the addition; `urdf`: whether the names are those of a URDF."""
        added_ids = {id(node) for added_element in added for node in added_element.iter()}
        seen: set[tuple[str, str]] = set()
        for kind, name, node in named_elements(document.root, urdf):
            if id(node) not in added_ids or not _has_unique_name(node):
                continue
            if (kind, name) in taken:
                path, other = taken[kind, name]
                text = f"its {node.tag} is named {name!r}, and so is a {other.tag} in {path}"
                raise Refused(text, self.key, "give it another name")
            if (kind, name) in seen:
                raise Refused(f"two of its elements are named {name!r}", self.key, "give one another name")
            seen.add((kind, name))


@dataclass(frozen=True, slots=True)
class Setting:
    """An entry of `attributes`: attributes to set on an element."""

    key: str
    """The key path of the entry in the configuration."""

    formats: tuple[str, ...]

    name: str
    """The name of the element."""

    tag: str | None
    """The tag of the element or of its section, if several elements have the name."""

    values: Mapping[str, str | None]
    """Attribute → text; None removes the attribute."""

    def apply(self, documents: Documents) -> Amendment:
        """Sets the attributes. Raises Refused if the element, or an attribute to remove, does not exist."""
        document, target = documents.find_named(self.name, self.tag, None, self.key)
        subject = in_words(target)
        for attribute, text in self.values.items():
            if text is not None:
                target.set(attribute, text)
            elif attribute in target.attrib:
                del target.attrib[attribute]
            else:
                hint = f"its own attributes are: {name_list(target.attrib)}; those of its class stay"
                raise Refused(f"{subject} has no attribute {attribute!r}", f"{self.key}.{attribute}", hint)
        return Amendment(self.key, document.path, subject, sets=tuple(self.values))


Entry = Insertion | Setting


def entries(keys: "ExportSections", texts: Mapping[str, str]) -> list[Entry]:
    """Returns all entries, in the order in which they are applied. `texts`: name of an entry → the text of
    the file that it names. Raises Refused if a text is not XML, or of no format."""
    all_entries: list[Entry] = []
    for name, section in keys.elements.items():
        key = f"elements.{name}"
        elements = own_elements(section.xml or texts[name], f"{key}.file" if section.file else f"{key}.xml")
        formats = section.formats or (_language(elements, key),)
        all_entries.append(Insertion(key, formats, section.into, tuple(elements)))
    for name, attributes in keys.attributes.items():
        values = {key: _text(value) for key, value in attributes.items() if key not in (FORMATS, TAG)}
        formats = tuple(attributes.get(FORMATS, ("mjcf",)))
        all_entries.append(Setting(f"attributes.{name}", formats, name, attributes.get(TAG), values))
    return all_entries


def own_elements(text: str, where: str) -> list[Element]:
    """Returns the elements of a text. Raises Refused if it is not XML."""
    try:
        return fragment(text)
    except Malformed as error:
        raise Refused(
            f"not XML: {error.place}", where, "one element or several, each of them closed"
        ) from None


def _language(elements: Sequence[Element], key: str) -> str:
    language = language_of(elements)
    if language is None:
        text = f"neither MJCF nor URDF has an element <{unknown_tag(elements)}>"
        raise Refused(text, key, "correct it, or say which format it is for: formats: [mjcf] or [urdf]")
    return language


def _parent_for(target: Element) -> Element:
    """Returns the parent of added elements: the target, or, for a site, a new frame with the pose of the
    site."""
    if target.tag != "site":
        return target
    pose = {key: target.get(key) for key in ("pos", "quat") if target.get(key) is not None}
    return element(target.getparent(), "frame", **pose)


def _has_unique_name(node: Element) -> bool:
    """Returns whether a name must be unique; the name of a default class may occur in several sections."""
    return bool(node.tag != "default")


def _text(value: Any) -> str | None:
    """Returns the value of an attribute as XML has it; None for null, which removes the attribute."""
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return " ".join(str(_text(item)) for item in value)
    return str(value) if isinstance(value, int) else number(value)
