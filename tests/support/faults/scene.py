"""Faults of a build's scene."""

from lxml import etree

from tests.support.faults.edits import add, all_of, draw, put, remove
from tests.support.faults.fault import table


def within(*tags, **attributes):
    """Adds elements in each other to the scene, the last with attributes."""

    def change(root, rng):
        for tag in tags[:-1]:
            root = etree.SubElement(root, tag)
        add(tags[-1], **attributes)(root, rng)

    return change


def option(**attributes):
    return all_of("/mujoco", add("option", **attributes), "option")


def floor(**attributes):
    return all_of("worldbody/geom[@name='floor']", put(**attributes), 'geom "floor"')


def joint_held(files, rng):
    joint = rng.choice(files.tree("mjcf").xpath("//body/joint/@name"))
    within("equality", "joint", joint1=joint)(files.root, rng)
    return "equality"


def passing(files, rng):
    first, second = rng.sample(files.tree("mjcf").xpath("//body/@name"), 2)
    within("contact", "exclude", body1=first, body2=second)(files.root, rng)
    return "exclude"


def crate(world, rng):
    size = f"{rng.uniform(0.08, 0.12):.3g}"
    etree.SubElement(world, "geom", name="crate", type="box", size=f"{size} {size} {size}", pos="0 0 0.3")


def crate_of_its_own(world, rng):
    body = etree.SubElement(world, "body", name="crate", pos="0 0 0.3")
    etree.SubElement(body, "geom", type="box", size="0.1 0.1 0.1")


FAULTS = table(
    "scene",
    ("gravity off", option(gravity="0 0 0"), "C-OPTION: gravity"),
    ("weight pulls upwards", option(gravity="0 0 9.81"), "C-OPTION: gravity"),
    ("time step too long", option(timestep=draw(0.015, 0.1, 3)), "C-OPTION: timestep"),
    ("contact switched off", all_of("/mujoco", within("option", "flag", contact="disable"), "flag"),
     "C-OPTION: contact"),
    ("robot's angles in degrees", all_of("/mujoco", add("compiler", angle="degree"), "joint"),
     "C-SCENE: range"),
    ("joint held in its place", joint_held, "C-SCENE: "),
    ("links pass through each other", passing, "C-SCENE: body1"),
    ("include missing", all_of("include", put(file="lost.xml"), "include"),
     "C-ASSET C-LINKS C-XML C-REFERENCE C-COMPILE: file"),
    ("gravity of the moon", option(gravity="0 0 -1.62"), "C-SCENE: gravity"),
    ("wind", option(wind="5 0 0"), "C-SCENE: wind"),
    ("air as dense as water", option(density="1000"), "C-SCENE: density"),
    ("another time step", option(timestep="0.005"), "C-SCENE: timestep"),
    ("another integrator", option(integrator="Euler"), "C-SCENE: integrator"),
    ("other friction cones", option(cone="elliptic"), "C-SCENE: cone"),
    ("hardly any iterations", option(iterations="1"), "C-SCENE: iterations"),
    ("limits switched off", all_of("/mujoco", within("option", "flag", limit="disable"), "flag"),
     "C-SCENE: limit"),
    ("ground removed", all_of("worldbody/geom[@name='floor']", remove, 'geom "floor"'), "C-SCENE: name"),
    ("ground 30 cm lower", floor(pos="0 0 -0.3"), "C-SCENE: pos"),
    ("ground 2 cm up", floor(pos="0 0 0.02"), "C-SCENE: pos"),
    ("ground tilted", floor(quat="0.9962 0 0.0872 0"), "C-SCENE: quat"),
    ("ground without friction", floor(friction="0 0 0"), "C-SCENE: friction"),
    ("ground soft", floor(solref="0.2 1"), "C-SCENE: solref"),
    ("ground that is no plane", floor(type="box"), "C-SCENE: type"),
    ("ground without collisions", floor(contype="0", conaffinity="0"), "C-SCENE: contype"),
    ("obstacle inside the robot", all_of("worldbody", crate, "body"), "C-START: pos"),
    ("body of the scene inside the robot", all_of("worldbody", crate_of_its_own, "body"), "C-START: pos"),
)  # fmt: skip
