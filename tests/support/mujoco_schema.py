"""The elements and attributes of MJCF that the installed MuJoCo knows."""

import re

import mujoco

LINE = re.compile(r"( *)(\S+) \(.\) *(.*)")


def schema():
    """The path of each element and its attributes."""
    elements = []
    for line in mujoco.mj_printSchema(False, True).splitlines():
        match = LINE.match(line)
        if match:
            level = len(match[1]) // 3
            above = next((where for where, _ in reversed(elements) if len(where) == level), ())
            name = {"(world)body": "body", "mujoco": ""}.get(match[2], match[2])
            elements.append(((*above[:level], name), match[3].split()))
        elif line.strip():
            elements[-1][1].extend(line.split())
    return [(where[1:], attributes) for where, attributes in elements if attributes]
