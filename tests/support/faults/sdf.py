"""Faults of a build's SDF, and of the file by which Gazebo finds it."""

from lxml import etree

from tests.support.faults.edits import all_of, at, either, pick, put, remove
from tests.support.faults.fault import Planted, table

COLLISION, LINK = "//link/collision", "//link"


def within(path, value):
    """Puts a text into the element at the end of a path, whose elements are made where they are missing."""

    def change(node, rng):
        for tag in path.split("/"):
            child = node.find(tag)
            node = etree.SubElement(node, tag) if child is None else child
        node.text = value if isinstance(value, str) else value(rng)

    return change


def offset(before, low, high, after):
    return lambda rng: f"{before}{rng.uniform(low, high):.6g}{after}"


def another_mesh(shape, rng):
    uri = shape.find("geometry/mesh/uri")
    uri.text = rng.choice(sorted({other.text for other in shape.getroottree().iter("uri")} - {uri.text}))


def shape_of_another_part(files, rng):
    role = rng.choice(("visual", "collision"))
    names = at(f"//link/{role}[geometry/mesh]", another_mesh)(files, rng)
    return Planted((names,), (role,))


def ten_times(collision, rng):
    size = pick(collision.xpath(".//size | .//radius"), rng)
    size.text = " ".join(f"{10 * float(word):.12g}" for word in size.text.split())


def other_bits(rng):
    return "0x00" if rng.random() < 0.5 else "0"


def self_collision(model, rng):
    collides = model.findtext("self_collide") == "true"
    within("self_collide", "false" if collides else "true")(model, rng)


def model_elsewhere(model, rng):
    words = (model.findtext("pose") or "0 0 0 0 0 0").split()
    # A free robot's height depends on its joints, which the MJCF may start elsewhere.
    at = rng.choice((0, 1, 3, 4, 5))
    words[at] = f"{float(words[at]) + rng.uniform(0.001, 1):.6g}"
    within("pose", " ".join(words))(model, rng)


def heavier(link, rng):
    mass = link.find("inertial/mass")
    mass.text = f"{1.01 * float(mass.text):.12g}"


SHAPES = table(
    "sdf",
    ("mesh scaled", at("//link/visual[geometry/mesh]",
                       within("geometry/mesh/scale", either("2 2 2", "0.001 0.001 0.001", "1 1 -1"))),
     "C-SDF: visual"),
    ("mesh of another part", shape_of_another_part, "C-SDF: visual"),
    ("collider gone", at(COLLISION, remove), "C-SDF: collision"),
    ("visual gone", at("//link/visual", remove), "C-SDF: visual"),
    ("collider moved", at(f"{COLLISION}[not(pose)]", within("pose", offset("0 ", 0.0001, 0.1, " 0 0 0 0"))),
     "C-SDF: collision"),
    ("visual turned", at("//link/visual[not(pose)]", within("pose", offset("0 0 0 0 0 ", 0.001, 3, ""))),
     "C-SDF: visual"),
    ("collider ten times as large", at(f"{COLLISION}[.//size or .//radius]", ten_times), "C-SDF: collision"),
    ("collider without friction", at(COLLISION, within("surface/friction/ode/mu", "0")), "C-SDF: collision"),
    ("all pass through a collider", at(COLLISION, within("surface/contact/collide_bitmask", other_bits)),
     "C-SDF: collision"),
    ("link without weight", at(LINK, within("gravity", either("false", "0"))), "C-SDF: gravity"),
    ("link that no force moves", at(LINK, within("kinematic", "true")), "C-SDF: kinematic"),
    ("links collide with each other", at("/sdf/model", self_collision), "C-SDF: self_collide"),
    ("collider that misses the world",
     at(COLLISION, within("surface/contact/collide_bitmask", either("0", "256", "0xff00"))),
     "C-SDF: collision"),
    ("model elsewhere", at("/sdf/model", model_elsewhere), "C-SDF: pose"),
    ("model renamed", all_of("/sdf/model", put(name="other"), 'model "other"'), "C-SDF: name"),
    ("limits without effect", at("//joint[@type='revolute'][axis/limit/lower]", put(type="continuous")),
     "C-SDF: type"),
    ("mass 1 % off", at(LINK, heavier), "C-SDF: mass"),
)  # fmt: skip


def another_file(files, rng):
    files.root.find("sdf").text = rng.choice(("model.sdf", f"{files.name}.urdf", ""))
    return "sdf"


CONFIG = table(
    "config",
    ("SDF that is not there", another_file, "C-SDF: "),
    ("version of another SDF", all_of("sdf", put(version=either("1.4", "1.11")), "sdf"), "C-SDF: version"),
    ("no SDF named", all_of("sdf", remove, "sdf"), "C-SDF: "),
)  # fmt: skip
