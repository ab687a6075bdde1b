"""Checks that a wheel installs `linkwright` and nothing else, and has every file of the product."""

import subprocess
import sys
import zipfile
from pathlib import Path

ROOMS = {"pipeline/package/": "linkwright/", "conf/": "linkwright/conf/"} | {
    f"{room}/": f"linkwright/{room}/" for room in ("pipeline", "stages")
}

place = Path(__file__).resolve().parents[1]
listed = subprocess.run(["git", "ls-files", *ROOMS], cwd=place, capture_output=True, text=True, check=True)
expected = set()
for file in listed.stdout.splitlines():
    room = next(room for room in ROOMS if file.startswith(room))
    expected.add(ROOMS[room] + file.removeprefix(room))
names = zipfile.ZipFile(sys.argv[1]).namelist()
found = {name for name in names if ".dist-info/" not in name}
if found != expected:
    sys.exit(f"missing from the wheel: {sorted(expected - found)}\nnot expected: {sorted(found - expected)}")
print(f"the wheel has all {len(found)} files, below linkwright")
