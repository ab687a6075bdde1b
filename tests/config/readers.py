"""The page of what other readers keep, from the table of the export stage."""

from linkwright.stages.targets.engines import ENGINES
from linkwright.stages.targets.readers import COMPLETE_READERS, READERS

INTRO = """# What each reader takes

Our files say what their formats can. What a reader makes of them is another matter: below is what each drops,
or what it needs to be told. "measured" was so with the version that is named, on robots made for it, on that
day; "read in its documentation", its issues or its source names where. The report of a build (`report.html`,
`details.readers` in `report.json`) has the rows that matter for that robot, with the names of its joints and
links.

A build for a reader (`target=mjx`, `target=[newton,drake]`) meets each row as the column says: "replaced",
its files have something else in that place; "refused", the check C-TARGET fails and names each; "stated", the
report says so. `linkwright check --target mjx FILE` judges any URDF, MJCF or SDF by the same rows.

Generated from `stages/targets/readers.py`.
"""

KEPT = """Measured to keep limits, effort, velocity, damping, friction and mimic (Pinocchio keeps the last
where it is asked for, with `mimic=True`):
"""

HEADER = (
    "| reader | version | what | does with it | as a target | source |\n| --- | --- | --- | --- | --- | --- |"
)

TARGETED = {reader for engine in ENGINES.values() for reader in engine.readers}

TITLES = {"urdf": "URDF", "sdf": "SDF", "mjcf": "MJCF", "usd": "USD"}


def markdown():
    """The whole page."""
    formats = dict.fromkeys(row.format for row in READERS)
    tables = "\n".join(_table(name) for name in formats)
    return f"{INTRO}\n{tables}\n## Nothing lost\n\n{_whole()}"


def _table(name):
    rows = "\n".join(_row(row) for row in READERS if row.format == name)
    return f"## {TITLES[name]}\n\n{HEADER}\n{rows}\n"


def _row(row):
    source = f"[{row.evidence}]({row.source})" if row.source else row.evidence
    response = row.response if row.reader in TARGETED else ""
    return f"| {row.reader} | {row.version} | {row.thing} | {row.does} | {response} | {source} |"


def _whole():
    names = "\n".join(f"- {reader} {version}, {TITLES[form]}" for reader, version, form in COMPLETE_READERS)
    return f"{KEPT}\n{names}\n"
