"""Says which files of the repository are pages of the site, and rewrites their links.

A link in a page names a file of the repository, so that it works where the repository is read. On the site
it leads to that file's page, or to a copy of the file; a picture that links to the file of a robot of the
gallery starts that robot.
"""

import re
import shutil
from collections.abc import Collection, Iterator, Mapping
from os.path import normpath, relpath
from pathlib import Path, PurePosixPath

PROJECT = Path(__file__).resolve().parents[2]

RENAMED = {
    "README.md": "index.md",
    "docs/contributing.md": "contribute/contributing.md",
    "docs/architecture.md": "contribute/architecture.md",
    "docs/engines.md": "contribute/engines.md",
    ".github/SECURITY.md": "contribute/security.md",
    "stages/DIAGNOSTICS.md": "reference/diagnostics.md",
    "stages/CHECKS.md": "reference/checks.md",
    "pipeline/reference/formats/READERS.md": "reference/readers.md",
}
"""File of the repository → its page, where the rules of `places` do not say it."""

FENCE = re.compile(r"^( *)(```+).*?^\1\2 *$", re.DOTALL | re.MULTILINE)
CODE = re.compile(r"(`+)(?:(?!\1).)+\1", re.DOTALL)
COMMENT = re.compile(r"^ *<!--.*?-->\n", re.DOTALL | re.MULTILINE)
LINK = re.compile(r"(\]\()([^)\s#]*)(#[^)\s]*)?(\))")
EXTERNAL = re.compile(r"[a-z]+:")


class DeadLinkError(Exception):
    """Names pages, and links of them that lead to no file and no page."""


def places() -> dict[str, str]:
    """File of the repository → path of its page, of all pages that are files."""
    names = dict(RENAMED)
    for folder, section in (
        ("docs", ""),
        ("pipeline/reference", "reference/"),
        ("pipeline/reference/formats", "reference/formats/"),
    ):
        for file in sorted((PROJECT / folder).glob("**/*.md" if folder == "docs" else "*.md")):
            path = file.relative_to(PROJECT).as_posix()
            name = path.removeprefix(f"{folder}/")
            names.setdefault(path, section + (name if folder == "docs" else name.lower()))
    return names


def write(source: Path, generated: Mapping[str, str], robots: Collection[str]) -> None:
    """Writes all pages into a folder, and beside them what they link to. `generated`: path of a page → its
    text, with links as from `docs/`; `robots`: those whose pages are in the folder `robots`."""
    targets = places() | {f"docs/{page}": page for page in generated}
    texts = {path: (PROJECT / path).read_text(encoding="utf-8") for path in places()}
    texts |= {f"docs/{page}": text for page, text in generated.items()}
    dead = []
    for path, text in texts.items():
        page = Page(path, targets, robots)
        file = source / targets[path]
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(page.rewritten(text), encoding="utf-8")
        dead += page.dead
        for copied in page.copied:
            copy = source / file_place(copied)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(PROJECT / copied, copy)
    if dead:
        raise DeadLinkError("\n".join(dead))


def file_place(path: str) -> str:
    """Where the site has a file of the repository that is no page."""
    return path.removeprefix("docs/") if path.startswith("docs/pictures/") else f"files/{path}"


class Page:
    """Rewrites a page: `path` is its file's, `targets` all pages by their files. `copied` collects the files
    that it links to, and `dead` messages about links that lead nowhere."""

    def __init__(self, path: str, targets: Mapping[str, str], robots: Collection[str]) -> None:
        self.path = path
        self.targets = targets
        self.robots = robots
        self.copied: list[str] = []
        self.dead: list[str] = []

    def rewritten(self, text: str) -> str:
        """The text with the site's links and without comments; code stays as it is."""
        return "".join(
            piece if code else LINK.sub(self._link, COMMENT.sub("", piece)) for piece, code in pieces(text)
        )

    def _link(self, match: re.Match[str]) -> str:
        target, anchor = match[2], match[3] or ""
        if not target or EXTERNAL.match(target):
            return match[0]
        file = normpath(PurePosixPath(self.path).parent / target)
        robot = file.removeprefix("conf/robot/").removesuffix(".yaml")
        before = match.string[: match.start()]
        if robot in self.robots and before.endswith(")"):  # a picture is the link's text
            place, anchor = f"robots/{robot}/report.html", "#live"
        elif file in self.targets:
            place = self.targets[file]
        elif (PROJECT / file).is_file():
            self.copied.append(file)
            place = file_place(file)
        else:
            self.dead.append(f"{self.path}: the link {target} leads to no file of the repository and no page")
            return match[0]
        here = PurePosixPath(self.targets[self.path]).parent
        return f"{match[1]}{relpath(place, here)}{anchor}{match[4]}"


def pieces(text: str) -> Iterator[tuple[str, bool]]:
    """The pieces of a Markdown text in their order, and whether each is code."""
    end = 0
    for fence in FENCE.finditer(text):
        yield from _inline(text[end : fence.start()])
        yield fence[0], True
        end = fence.end()
    yield from _inline(text[end:])


def _inline(text: str) -> Iterator[tuple[str, bool]]:
    end = 0
    for code in CODE.finditer(text):
        yield text[end : code.start()], False
        yield code[0], True
        end = code.end()
    yield text[end:], False
