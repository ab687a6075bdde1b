"""Checks that the links of a URDF are a tree without cycles, from a single root, and checks its mimics."""

from collections.abc import Iterator

from linkwright.stages.formats.xml import Element
from linkwright.stages.validate.bare.findings import CodedFinding
from linkwright.stages.validate.reading.documents import ModelDocument


def check(document: ModelDocument) -> Iterator[CodedFinding]:
    """Yields findings on second parents, cycles and second roots, on joints that follow themselves or a joint
    without a value, and on fixed, floating and planar joints that follow another."""
    yield from _tree(document)
    yield from _mimics(document)


def _tree(document: ModelDocument) -> Iterator[CodedFinding]:
    links = [link for link in document.root.iterfind("link") if link.get("name")]
    if not links:
        yield "C-TREE", document.finding(document.root, "", "the robot has no link")
    names = {link.get("name") for link in links}
    above: dict[str, tuple[str, Element]] = {}
    for joint in document.root.iterfind("joint"):
        parent, child = _link_at(joint, "parent"), _link_at(joint, "child")
        if parent not in names or child not in names:
            continue
        if parent == child:
            message = f'its parent and its child are one link, "{child}"'
            yield "C-TREE", document.finding(joint, "child", message)
        elif child in above:
            other = above[child][1].get("name")
            message = f'the link "{child}" has another parent by joint "{other}"'
            yield "C-TREE", document.finding(joint, "child", message)
        else:
            above[child] = parent, joint
    for cycle in _cycles(above):
        joint = above[cycle[0]][1]
        path = " → ".join([*reversed(cycle), cycle[-1]])
        yield "C-TREE", document.finding(joint, "child", f"a cycle of links: {path}")
    roots = [link for link in links if link.get("name") not in above]
    for link in roots[1:]:
        first = roots[0].get("name")
        message = f'it is the child of no joint, and neither is "{first}": a robot has one root'
        yield "C-TREE", document.finding(link, "name", message)


def _link_at(joint: Element, role: str) -> str:
    """Returns the name of a joint's parent or child link (`role`); "" if it is missing."""
    end = joint.find(role)
    return "" if end is None else str(end.get("link", ""))


def _cycles(above: dict[str, tuple[str, Element]]) -> Iterator[list[str]]:
    """Yields the links of each cycle once, each link followed by its parent. `above`: link → its parent and
    the joint between them."""
    visited: set[str] = set()
    for start in above:
        path: list[str] = []
        link = start
        while link in above and link not in visited:
            visited.add(link)
            path.append(link)
            link = above[link][0]
        if link in path:
            yield path[path.index(link) :]


def _mimics(document: ModelDocument) -> Iterator[CodedFinding]:
    joints = {joint.get("name"): joint for joint in document.root.iterfind("joint")}
    follows = {}
    for name, joint in joints.items():
        mimic = joint.find("mimic")
        if mimic is None:
            continue
        driver = mimic.get("joint", "")
        follows[name] = driver
        if joint.get("type") in ("fixed", "floating", "planar"):
            message = f"a {joint.get('type')} joint cannot follow another: readers ignore the <mimic>"
            yield "C-PLAUSIBLE", document.finding(mimic, "joint", message)
        elif driver in joints and joints[driver].get("type") in ("fixed", "floating", "planar"):
            message = f'it follows "{driver}", a {joints[driver].get("type")} joint, which has no value'
            yield "C-MIMIC", document.finding(mimic, "joint", message)
    for name in follows:
        path, at = [name], follows[name]
        while at in follows and at not in path:
            path.append(at)
            at = follows[at]
        if at == name:
            words = "it follows itself" + (f", by {' → '.join(path[1:])}" if len(path) > 1 else "")
            yield "C-MIMIC", document.finding(joints[name].find("mimic"), "joint", words)
