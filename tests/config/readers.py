"""The page of what other readers keep, from the table of the export stage."""

from linkwright.stages.export.readers import READERS, WHOLE, ReaderRow

INTRO = """# What each reader keeps

Our files say what their formats can. What a reader makes of them is another matter: below is what each drops,
or what it needs to be told. "measured" was so with the version that is named, on robots made for it; anything
else names its source. The report of a build (`report.html`, `details.readers` in `report.json`) has the rows
that matter for that robot, with the names of its joints and links.

Generated from `stages/export/readers.py`.
"""

KEPT = """Measured to keep limits, effort, velocity, damping, friction and mimic (Pinocchio keeps the last
where it is asked for, with `mimic=True`):
"""

HEADER = "| reader | version | what | does with it | source |\n| --- | --- | --- | --- | --- |"

TITLES = {"urdf": "URDF", "sdf": "SDF", "mjcf": "MJCF", "usd": "USD"}


def markdown() -> str:
    """The whole page."""
    formats = dict.fromkeys(row.format for row in READERS)
    tables = "\n".join(_table(name) for name in formats)
    return f"{INTRO}\n{tables}\n## Nothing lost\n\n{_whole()}"


def _table(name: str) -> str:
    rows = "\n".join(_row(row) for row in READERS if row.format == name)
    return f"## {TITLES[name]}\n\n{HEADER}\n{rows}\n"


def _row(row: ReaderRow) -> str:
    source = f"[cited]({row.source})" if row.source else "measured"
    return f"| {row.reader} | {row.version} | {row.thing} | {row.does} | {source} |"


def _whole() -> str:
    names = "\n".join(f"- {reader} {version}, {TITLES[form]}" for reader, version, form in WHOLE)
    return f"{KEPT}\n{names}\n"
