"""Faults of a build's SRDF."""

from lxml import etree

from tests.support.faults.edits import all_of, at, holder, named, pick, put, remove
from tests.support.faults.fault import NothingToChange, Planted, table

DISABLED = "/robot/disable_collisions"
ADJACENT, NEVER = (f"{DISABLED}[@reason='{reason}']" for reason in ("Adjacent", "Never"))
CHAIN, EFFECTOR, JOINT = "/robot/group/chain", "/robot/end_effector", "/robot/group_state/joint"


def pair(node):
    return f'disable_collisions "{node.get("link1")}" "{node.get("link2")}"'


def state(joint):
    above = joint.getparent()
    return f'{named("group_state", above)} of group "{above.get("group")}"'


def suffixed(key):
    def change(node, rng):
        node.set(key, f"{node.get(key)}_x")

    return change


def another(key, pool):
    """Another of the names on a path."""

    def change(node, rng):
        node.set(key, rng.choice(sorted({str(name) for name in node.xpath(pool)} - {node.get(key)})))

    return change


def another_group(effector, rng):
    key = rng.choice(("group", "parent_group"))
    another(key, "/robot/group/@name")(effector, rng)
    return Planted((holder(effector),), (key,))


def of_state(change):
    """Changes the value of a joint in a pose; a finding names the pose and the joint."""

    def plant(files, rng):
        joint = pick(files.root.xpath(JOINT), rng)
        planted = Planted((state(joint),), (f"joint {joint.get('name')}",))
        change(joint, rng)
        return planted

    return plant


def value_off(joint, rng):
    joint.set("value", f"{float(joint.get('value')) + rng.choice((1e-4, 0.1, -7)):.12g}")


def beyond_limits(files, rng):
    chosen = pick(files.root.xpath(JOINT), rng).getparent()
    far = etree.SubElement(files.root, "group_state", dict(chosen.attrib), name="far")
    for joint in chosen:
        etree.SubElement(far, "joint", joint.attrib)
    limited = pick(
        [joint for joint in far if joint.get("name") in ("shoulder", "lift", "Neck", "Reach")], rng
    )
    limited.set("value", rng.choice(("50", "-50")))
    return Planted(('group_state "far"',), (f"joint {limited.get('name')}",))


def other_reason(*reasons):
    def change(node, rng):
        node.set("reason", rng.choice(reasons) if len(reasons) > 1 else reasons[0])

    return change


def switched_off(reason):
    def plant(files, rng):
        every = files.root.findall("disable_collisions")
        links = sorted({node.get(key) for node in every for key in ("link1", "link2")})
        off = {frozenset((node.get("link1"), node.get("link2"))) for node in every}
        free = [(a, b) for a in links for b in links if a < b and frozenset((a, b)) not in off]
        if not free:
            raise NothingToChange
        first, second = rng.choice(free)
        return pair(
            etree.SubElement(files.root, "disable_collisions", link1=first, link2=second, reason=reason)
        )

    return plant


def collides_again(files, rng):
    reason = rng.choice(("Adjacent", "Default"))
    return at(f"{DISABLED}[@reason='{reason}']", remove, names=pair)(files, rng)


def other_base(virtual, rng):
    virtual.set("type", "floating" if virtual.get("type") == "fixed" else "fixed")


def driven_passive(files, rng):
    passive = {str(name) for name in files.root.xpath("/robot/passive_joint/@name")}
    name = rng.choice(sorted({str(name) for name in files.root.xpath(f"{JOINT}/@name")} - passive))
    etree.SubElement(files.root, "passive_joint", name=name)
    return f'passive_joint "{name}"'


FAULTS = table(
    "srdf",
    ("link that is not there", at(ADJACENT, suffixed("link2"), lambda node, _: pair(node)), "C-SRDF: link2"),
    ("joint that is not there",
     at("/robot/group/joint", suffixed("name"), names=lambda node: holder(node.getparent())),
     "C-SRDF: joint"),
    ("chain ends elsewhere", at(CHAIN, another("tip_link", f"{DISABLED}/@link2")), "C-SRDF: chain"),
    ("chain begins elsewhere", at(CHAIN, another("base_link", f"{DISABLED}/@link2")), "C-SRDF: chain"),
    ("joint taken out of a group",
     at("/robot/group[@name='all']/joint", remove, names=lambda _: 'group "all"'),
     "C-SRDF: joint | name"),
    ("group of a frame gone", at("/robot/group[@name='tool' or @name='Mast' or @name='mast']", remove),
     "C-SRDF: name"),
    ("hand on another link", at(EFFECTOR, another("parent_link", f"{DISABLED}/@link1")),
     "C-SRDF: parent_link | group | parent_group"),
    ("hand of another group", at(EFFECTOR, another_group), "C-SRDF: group"),
    ("pose elsewhere", of_state(value_off), "C-SRDF: joint"),
    ("pose without a joint", of_state(remove), "C-SRDF: joint"),
    ("pose removed", at(JOINT, lambda joint, rng: remove(joint.getparent(), rng), names=state),
     "C-SRDF: name"),
    ("pose beyond limits", beyond_limits, "C-SRDF: joint"),
    ("reason Adjacent for links that are not",
     at(NEVER, other_reason("Adjacent", "User", "Default"), names=pair),
     "C-SRDF: reason"),
    ("reason Never for links that are next to each other", at(ADJACENT, other_reason("Never"), names=pair),
     "C-SRDF: reason"),
    ("collision of a pair switched off", switched_off("User"), "C-SRDF: reason"),
    ("reason Never for links that may meet", switched_off("Never"), "C-SRDF: reason"),
    ("pair that never meets left out", at(NEVER, remove, names=pair), "C-SRDF: reason"),
    ("pair collides again", collides_again, "C-SRDF: reason"),
    ("base fixed or floating", at("/robot/virtual_joint", other_base), "C-SRDF: type"),
    ("base on another link", at("/robot/virtual_joint", another("child_link", f"{DISABLED}/@link2")),
     "C-SRDF: child_link"),
    ("driven joint passive", driven_passive, "C-SRDF: name"),
    ("robot renamed", all_of("/robot", put(name="other"), 'robot "other"'), "C-SRDF: name"),
)  # fmt: skip
