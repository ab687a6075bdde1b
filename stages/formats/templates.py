"""Fills templates, and is the only module that imports jinja2.

Values are escaped in templates of HTML, SVG and XML. A template holds loops and conditions, and no other
logic.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

_ESCAPED_SUFFIXES = (".html.jinja", ".svg.jinja", ".xml.jinja")
"""Suffixes of the templates whose values are escaped."""


class Templates:
    """The templates of a folder. `filters`: the filters that templates use, by name; `convert`: a function
    that converts each value before it is escaped."""

    def __init__(
        self,
        folder: Path,
        filters: Mapping[str, Callable[..., Any]],
        convert: Callable[[Any], Any] | None = None,
    ) -> None:
        self._environment = Environment(
            loader=FileSystemLoader(folder),
            autoescape=lambda name: name is not None and name.endswith(_ESCAPED_SUFFIXES),
            finalize=convert,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
            auto_reload=False,
        )
        self._environment.filters.update(filters)

    def filled(self, name: str, /, **values: Any) -> str:
        """Returns the text of the template `<name>.jinja` with its values. A value that is missing is an
        error of jinja2."""
        return self._environment.get_template(f"{name}.jinja").render(values)


def xml_text(text: str) -> Markup:
    """Returns a text, escaped for a place between two tags of XML, as lxml escapes it: quotes stay."""
    return Markup(escape(text))
