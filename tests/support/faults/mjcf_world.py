"""Faults of an MJCF's loops, relations, actuators, keyframes, sensors and excludes, and of its root."""

from lxml import etree

from tests.support.faults.edits import at, holder, moved, named, numbers, of, put, remove, write
from tests.support.faults.fault import NothingToChange, Planted, table
from tests.support.faults.mjcf import contact_of

LOOP = "//equality/connect | //equality/weld"
RELATION = "//equality/joint"
MOTOR = "//actuator/*[@joint]"
KEY = "//key[@qpos]"
FRAME = "//site[@name][not(@name = //equality/*/@site1 | //equality/*/@site2)]"


def with_its_loop(site):
    (connect, *_) = site.xpath("//connect[@site1 = $name or @site2 = $name]", name=site.get("name"))
    return named("site", site), named("connect", connect)


def loop_removed(equality, rng):
    remove(equality, rng)
    return f'connect "{equality.get("name").removesuffix("_axis")}"'


def welded(files, rng):
    first, second = rng.sample([node.get("name") for node in files.root.xpath("//body")], 2)
    etree.SubElement(files.root.find("equality"), "weld", name="glue", body1=first, body2=second)
    return 'weld "glue"'


def slack(values, rng):
    return rng.uniform(0.1, 0.5), 1.0


def on_another_joint(motor, rng):
    joints = {str(name) for name in motor.xpath("//body/joint[@name][not(@type='ball')]/@name")}
    motor.set("joint", rng.choice(sorted(joints - {motor.get("joint")})))


def motor_removed(motor, rng):
    for key in motor.xpath("//key[@ctrl]"):
        key.set("ctrl", " ".join(key.get("ctrl").split()[:-1]))
    remove(motor, rng)


def gear_turned_round(motor, rng):
    motor.set("gear", f"{-numbers(motor, 'gear', '1')[0]:g}")


def key_off(key, rng):
    values = numbers(key, "qpos")
    at = rng.randrange(7 if key.xpath("//freejoint") else 0, len(values))
    values[at] += rng.choice((-1, 1)) * rng.uniform(0.01, 0.5)
    write(key, "qpos", values)


def control_off(values, rng):
    at = rng.randrange(len(values))
    values[at] += rng.uniform(0.01, 0.5)
    return values


def moving(key, rng):
    write(key, "qvel", [rng.uniform(0.1, 1) for _ in key.xpath("//body/joint")])


SENSED = ("site", "joint", "actuator", "objname")


def elsewhere(sensor, rng):
    key = next(key for key in SENSED if sensor.get(key))
    pool = {
        "site": "//body//site/@name",
        "joint": "//body/joint[not(@type='ball')]/@name",
        "actuator": "//actuator/*/@name",
        "objname": "//body//site/@name" if sensor.get("objtype") == "site" else "//body/@name",
    }
    names = sorted(set(map(str, sensor.xpath(pool[key]))) - {sensor.get(key)})
    if not names:
        raise NothingToChange
    sensor.set(key, rng.choice(names))
    return Planted((holder(sensor),), (key, "site", "objname"))


def freejoint_removed(freejoint, rng):
    for key in freejoint.xpath("//key"):
        key.set("qpos", " ".join(key.get("qpos").split()[7:]))
    remove(freejoint, rng)


def freejoint_added(files, rng):
    if files.root.find(".//freejoint") is not None:
        raise NothingToChange
    files.root.find("worldbody/body").insert(0, etree.Element("freejoint", name="floats"))
    for key in files.root.iter("key"):
        key.set("qpos", "0 0 0 1 0 0 0 " + key.get("qpos"))
    return 'joint "floats"'


def pair(node):
    first, second = node.get("body1"), node.get("body2")
    return f'exclude "{first}" "{second}"', f'exclude "{second}" "{first}"'


def exclude_added(files, rng):
    holder = contact_of(files.root)
    excluded = {frozenset((node.get("body1"), node.get("body2"))) for node in holder.iter("exclude")}
    solid = files.root.xpath("//body[geom[contains(@class, 'collision')]]")
    pairs = [
        (first.get("name"), second.get("name"))
        for first in solid
        for second in solid
        if first.get("name") < second.get("name")
        and first.getparent() is not second
        and second.getparent() is not first
        and frozenset((first.get("name"), second.get("name"))) not in excluded
    ]
    if not pairs:
        raise NothingToChange
    first, second = rng.choice(pairs)
    return pair(etree.SubElement(holder, "exclude", body1=first, body2=second))


def of_root(change):
    """Changes the body of the robot's root."""

    def plant(files, rng):
        body = files.root.find("worldbody/body")
        change(body, rng)  # type: ignore[operator]
        return named("body", body)

    return plant


def of_home(start, change, above=0.0):
    """Changes numbers of the free joint at `home`, from `start` on, or the height to `above` the root's."""

    def plant(files, rng):
        if files.root.find(".//freejoint") is None:
            raise NothingToChange
        (key,) = files.root.xpath("//key[@name='home']")
        height = numbers(files.root.find("worldbody/body"), "pos", "0 0 0")[2]
        values = numbers(key, "qpos")
        values[start : start + max(1, len(change))] = change or (height + above,)
        write(key, "qpos", values)
        return 'key "home"'

    return plant


FAULTS = table(
    "mjcf",
    ("loop's site 1 mm off", at("//site[@name = //connect/@site1 | //connect/@site2]", moved("pos", 0.001),
                                names=with_its_loop), "C-LOOP C-CLOSED: pos | site1"),
    ("loop's equality removed", at(LOOP, loop_removed), "C-LOOP: site1"),
    ("loop's equality switched off", at(LOOP, put(active="false")), "C-LOOP: active"),
    ("loop's equality slack", at(LOOP, of("solref", slack)), "C-LOOP: solref"),
    ("bodies welded together", welded, "C-LOOP: site1"),
    ("relation switched off", at(RELATION, put(active="false")), "C-RELATION: active"),
    ("relation slack", at(RELATION, of("solref", slack)), "C-RELATION: solref"),
    ("relation's sign", at(RELATION, of("polycoef", lambda v, _: (v[0], -v[1], *v[2:]))),
     "C-RELATION: polycoef"),
    ("relation's offset",
     at(RELATION, of("polycoef", lambda v, rng: (v[0] + rng.uniform(0.01, 0.2), *v[1:]))),
     "C-RELATION: polycoef"),
    ("relation removed", at(RELATION, remove), "C-RELATION: | polycoef"),
    ("actuator on another joint", at(MOTOR, on_another_joint), "C-ACTUATOR: joint"),
    ("actuator removed", at(MOTOR, motor_removed), "C-ACTUATOR: name"),
    ("gear's sign", at(MOTOR, gear_turned_round), "C-ACTUATOR: gear"),
    ("servo without stiffness", at(f"{MOTOR}[@kp]", put(kp="0")), "C-ACTUATOR: kp"),
    ("range of control",
     at(f"{MOTOR}[@ctrlrange]", of("ctrlrange", lambda v, rng: (v[0], v[1] + rng.uniform(0.01, 1)))),
     "C-ACTUATOR: ctrlrange"),
    ("range of force", at(MOTOR, put(forcerange="-0.001 0.001")), "C-ACTUATOR: forcerange"),
    ("keyframe off", at(KEY, key_off), "C-KEYFRAME: qpos"),
    ("keyframe removed", at("//key", remove), "C-KEYFRAME: name"),
    ("control of the keyframe", at("//key[@name='home'][@ctrl]", of("ctrl", control_off)),
     "C-ACTUATOR: ctrl"),
    ("keyframe moves", at("//key[not(//freejoint)][not(//joint/@type = 'ball')]", moving),
     "C-KEYFRAME: qvel"),
    ("sensor on another place", at("//sensor/*[@site or @joint or @actuator or @objname]", elsewhere),
     "C-SENSOR: site"),
    ("sensor removed", at("//sensor/*", remove), "C-SENSOR: name"),
    ("site of a frame moved", at(FRAME, moved("pos", 0.001)), "C-MOTION: pos"),
    ("freejoint removed",
     at("//freejoint", freejoint_removed, names=lambda node: named("body", node.getparent())),
     "C-LINKS: freejoint"),
    ("freejoint added", freejoint_added, "C-LINKS C-COMPILE: type"),
    ("exclude removed", at("//exclude", remove, names=pair), "C-EXCLUDE: body1"),
    ("exclude added", exclude_added, "C-EXCLUDE: body1"),
    ("root 5 mm up", of_root(of("pos", lambda v, _: (v[0], v[1], v[2] + 0.005), "0 0 0")), "C-PLACE: pos"),
    ("root turned by 90 degrees", of_root(of("quat", lambda *_: (0.5**0.5, 0, 0, 0.5**0.5))),
     "C-PLACE: quat"),
    ("free base 5 cm up at home", of_home(2, (), above=0.05), "C-PLACE: qpos"),
    ("free base turned at home", of_home(3, (0.8, 0.0, 0.0, 0.6)), "C-PLACE: qpos"),
)  # fmt: skip
