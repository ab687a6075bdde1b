"""The entries of `elements` and `attributes`: what each does to the files of a format."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from linkwright.stages.export.amend.documents import Documents, Refused, XmlFile, said
from linkwright.stages.formats.numbers import number
from linkwright.stages.formats.own_xml import language_of, names, unknown_tag
from linkwright.stages.formats.xml import Element, Malformed, element, fragment
from linkwright.stages.robot.model.amendments import Amendment
from linkwright.stages.robot.text.globs import listed

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.element_section import IntoSection
    from linkwright.stages.export.section import ExportSections

FORMATS, TAG = "formats", "tag"
"""What stands beside attributes."""


@dataclass(frozen=True, slots=True)
class Insertion:
    """An entry of `elements`."""

    key: str
    formats: tuple[str, ...]
    into: "IntoSection"
    elements: tuple[Element, ...]

    def apply(self, documents: Documents) -> Amendment:
        """Adds the elements. Refused where the target is not there, or a name of theirs is taken."""
        where, into = f"{self.key}.into", self.into
        if into.name is not None:
            document, target = documents.named(into.name, into.tag, into.file, where)
        else:
            document, target = documents.first(str(into.tag), into.file, where)
        taken = documents.taken()
        holder = _in_place_of(target) if documents.form == "mjcf" else target
        added = [deepcopy(one) for one in self.elements]
        holder.extend(added)
        self._require_new(document, added, taken, documents.form == "urdf")
        return Amendment(self.key, document.path, said(target), tuple(map(said, added)))

    def _require_new(
        self,
        document: XmlFile,
        added: Sequence[Element],
        taken: Mapping[tuple[str, str], tuple[str, Element]],
        urdf: bool,
    ) -> None:
        own = {id(one) for top in added for one in top.iter()}
        seen: set[tuple[str, str]] = set()
        for kind, name, one in names(document.root, urdf):
            if id(one) not in own or not _has_own_name(one):
                continue
            if (kind, name) in taken:
                path, other = taken[kind, name]
                text = f"its {one.tag} is named {name!r}, and so is a {other.tag} in {path}"
                raise Refused(text, self.key, "give it another name")
            if (kind, name) in seen:
                raise Refused(f"two of its elements are named {name!r}", self.key, "give one another name")
            seen.add((kind, name))


@dataclass(frozen=True, slots=True)
class Setting:
    """An entry of `attributes`. `values`: attribute → text; None takes it away."""

    key: str
    formats: tuple[str, ...]
    name: str
    tag: str | None
    values: Mapping[str, str | None]

    def apply(self, documents: Documents) -> Amendment:
        """Sets the attributes. Refused where the element, or an attribute to take away, is not there."""
        document, target = documents.named(self.name, self.tag, None, self.key)
        what = said(target)
        for attribute, text in self.values.items():
            if text is not None:
                target.set(attribute, text)
            elif attribute in target.attrib:
                del target.attrib[attribute]
            else:
                hint = f"its own attributes are: {listed(target.attrib)}; those of its class stay"
                raise Refused(f"{what} has no attribute {attribute!r}", f"{self.key}.{attribute}", hint)
        return Amendment(self.key, document.path, what, sets=tuple(self.values))


Entry = Insertion | Setting


def entries(keys: "ExportSections", texts: Mapping[str, str]) -> list[Entry]:
    """All entries, in the order in which they are applied. `texts`: of the files that `elements` name, by the
    name of the entry. Refused where such a text is not XML, or of no format."""
    found: list[Entry] = []
    for name, one in keys.elements.items():
        key = f"elements.{name}"
        elements = own_elements(one.xml or texts[name], f"{key}.file" if one.file else f"{key}.xml")
        formats = one.formats or (_language(elements, key),)
        found.append(Insertion(key, formats, one.into, tuple(elements)))
    for name, given in keys.attributes.items():
        values = {key: _text(value) for key, value in given.items() if key not in (FORMATS, TAG)}
        formats = tuple(given.get(FORMATS, ("mjcf",)))
        found.append(Setting(f"attributes.{name}", formats, name, given.get(TAG), values))
    return found


def own_elements(text: str, where: str) -> list[Element]:
    """The elements of a text; Refused where it is not XML."""
    try:
        return fragment(text)
    except Malformed as error:
        raise Refused(
            f"not XML: {error.place}", where, "one element or several, each of them closed"
        ) from None


def _language(elements: Sequence[Element], key: str) -> str:
    found = language_of(elements)
    if found is None:
        text = f"neither MJCF nor URDF has an element <{unknown_tag(elements)}>"
        raise Refused(text, key, "correct it, or say which format it is for: formats: [mjcf] or [urdf]")
    return found


def _in_place_of(target: Element) -> Element:
    """What holds what is added to a target: the target, or, for a site, a frame in its place."""
    if target.tag != "site":
        return target
    pose = {key: target.get(key) for key in ("pos", "quat") if target.get(key) is not None}
    return element(target.getparent(), "frame", **pose)


def _has_own_name(one: Element) -> bool:
    """Whether a name is a thing's own, and not that of a class that several sections may add to."""
    return bool(one.tag != "default")


def _text(value: Any) -> str | None:
    if value is None or isinstance(value, str):
        return value
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return " ".join(str(_text(one)) for one in value)
    return str(value) if isinstance(value, int) else number(value)
