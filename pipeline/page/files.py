"""Renders the files of a build, with sizes and digests, and the values that vary in its variants."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import file_link, inline, name, rendered
from linkwright.stages.robot.text.plural import count

ASSETS = "assets/"

MAX_NAMES = 6
"""Largest number of names of varying quantities in a row; robot.json has all."""


def top_level(paths: Iterable[str]) -> list[str]:
    """Returns the paths outside of the folder of meshes."""
    return [path for path in paths if not path.startswith(ASSETS)]


def files(digests: Mapping[str, str], sizes: Mapping[str, int]) -> str:
    """Renders the section, with the files of meshes folded; "" without files."""
    meshes = [path for path in digests if path.startswith(ASSETS)]
    size = sum(sizes[path] for path in meshes)
    summary = f"{len(meshes)} in {ASSETS}, {size / 1e6:.2f} MB"
    rows = {path: [file_link(path), f"{sizes[path]:,}", digests[path]] for path in digests}
    header, classes = ["file", "bytes", "SHA-256"], {"bytes": "number", "SHA-256": "digest"}
    top_files = table(header, [rows[path] for path in top_level(digests)], classes, heads="file")
    mesh_files = table(header, [rows[path] for path in meshes], classes, heads="file")
    return rendered("files", first=top_files, summary=summary, rest=mesh_files) if digests else ""


def variants(details: Mapping[str, Any]) -> str:
    """Renders the values that vary in the robot's variants, and by how much; "" without variants.
    `details`: the part `variants` of the report's details."""
    if not details:
        return ""
    header = ["the value is", "varies by", "quantities", "of"]
    cells = [
        [
            inline(row["origin"]),
            inline(f"±{100 * row['share']:.3g} %"),
            inline(str(len(row["of"]))),
            name(_first_names(row["of"])),
        ]
        for row in details["rows"]
    ]
    fields = count(len(details["fields"]), "field")
    words = f"{count(details['n'], 'variant')} of the seed {details['seed']}, in {fields}"
    return rendered("variants", words=words, table=table(header, cells, heads="the value is"))


def _first_names(names: Sequence[str]) -> str:
    rest = len(names) - MAX_NAMES
    return ", ".join(names[:MAX_NAMES]) + (f" and {rest} more" if rest > 0 else "")
