"""The files of a build, with sizes and digests."""

from collections.abc import Iterable, Mapping

from linkwright.pipeline.page.html.tables import table
from linkwright.pipeline.page.html.template import file_link, rendered

ASSETS = "assets/"


def top_level(paths: Iterable[str]) -> list[str]:
    """The files but those of the meshes."""
    return [path for path in paths if not path.startswith(ASSETS)]


def files(digests: Mapping[str, str], sizes: Mapping[str, int]) -> str:
    """The section, with the files of the meshes folded; nothing without files."""
    meshes = [path for path in digests if path.startswith(ASSETS)]
    size = sum(sizes[path] for path in meshes)
    summary = f"{len(meshes)} in {ASSETS}, {size / 1e6:.2f} MB"
    rows = {path: [file_link(path), f"{sizes[path]:,}", digests[path]] for path in digests}
    header, classes = ["file", "bytes", "SHA-256"], {"bytes": "number", "SHA-256": "digest"}
    first = table(header, [rows[path] for path in top_level(digests)], classes, heads="file")
    rest = table(header, [rows[path] for path in meshes], classes, heads="file")
    return rendered("files", first=first, summary=summary, rest=rest) if digests else ""
