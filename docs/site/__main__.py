"""`python -m docs.site [FOLDER]` builds the site into FOLDER/site, by default build/docs/site.

FOLDER/pages has the pages in plain Markdown as Zensical reads them. A dead link, a page that is not in the
navigation, and any warning of Zensical are errors.
"""

import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from docs.site import pages, reference, robots

DOCS = pages.PROJECT / "docs"


def build(folder: Path) -> Path:
    """Builds the site in a folder, in place of an older one; the path of its first page."""
    shutil.rmtree(folder, ignore_errors=True)
    source = folder / "pages"
    check_navigation()
    shutil.copytree(DOCS / "site" / "assets", source / "assets")
    shutil.copy(DOCS / "zensical.toml", folder)
    names = robots.gallery()
    robots.build(names, folder / "work", source / "robots")
    try:
        pages.write(source, {page: make() for page, make in reference.PAGES.items()}, names)
    except pages.DeadLinkError as error:
        sys.exit(str(error))
    run_zensical(folder)
    return folder / "site" / "index.html"


def check_navigation() -> None:
    """Exits unless the navigation has each page once, and no other."""
    nav = tomllib.loads((DOCS / "zensical.toml").read_text(encoding="utf-8"))["project"]["nav"]
    listed = Counter(_listed(nav))
    wanted = Counter((*pages.places().values(), *reference.PAGES))
    if odd := [page for page in listed | wanted if listed[page] != wanted[page]]:
        sys.exit(f"docs/zensical.toml: `nav` must list each page once; look at {', '.join(sorted(odd))}")


def _listed(entry: Any) -> Iterator[str]:
    """The pages of a part of the navigation."""
    if isinstance(entry, str):
        yield entry
    for inside in entry.values() if isinstance(entry, dict) else entry if isinstance(entry, list) else ():
        yield from _listed(inside)


def run_zensical(folder: Path) -> None:
    """Makes the site of the pages; exits with what Zensical prints if that has a warning."""
    command = [sys.executable, "-m", "zensical", "build", "--strict", "--clean"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    printed = done.stdout + done.stderr
    if done.returncode or "warning" in printed.lower():
        sys.exit(printed)


if __name__ == "__main__":
    place = Path(sys.argv[1]) if len(sys.argv) > 1 else pages.PROJECT / "build" / "docs"
    print(build(place.resolve()))
