"""Fills templates, and is the only module that imports jinja2.

Values are escaped in templates of HTML and XML. A template holds loops and conditions, and no other logic.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any
from xml.sax.saxutils import escape

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

ESCAPED = (".html.jinja", ".svg.jinja", ".xml.jinja")


class Templates:
    """The templates of a folder. `filters`: functions of values, by name; `shown`: converts each value before
    it is escaped."""

    def __init__(
        self,
        folder: Path,
        filters: Mapping[str, Callable[..., Any]],
        shown: Callable[[Any], Any] | None = None,
    ) -> None:
        self._environment = Environment(
            loader=FileSystemLoader(folder),
            autoescape=lambda name: name is not None and name.endswith(ESCAPED),
            finalize=shown,
            undefined=StrictUndefined,
            trim_blocks=True,
            lstrip_blocks=True,
            keep_trailing_newline=True,
            auto_reload=False,
        )
        self._environment.filters.update(filters)

    def filled(self, name: str, /, **values: Any) -> str:
        """Returns the text of the template `<name>.jinja` with its values."""
        return self._environment.get_template(f"{name}.jinja").render(values)


def xml_text(text: str) -> Markup:
    """Returns a text for between two tags of XML, as lxml writes it: quotes stay."""
    return Markup(escape(text))
