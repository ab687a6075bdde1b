"""scene.xml: the robot in a small world, with a floor, light and sky, ready for a viewer."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.export.configuration.mujoco_section import IN_THE_ROBOT
from linkwright.stages.export.mjcf.keyframes import write_keyframes
from linkwright.stages.export.mjcf.placement import placement
from linkwright.stages.export.mjcf.sections import write_sections
from linkwright.stages.export.mjcf.sensing.cameras import overview, write_camera
from linkwright.stages.export.mjcf.settings import text
from linkwright.stages.export.scene import ground_pose
from linkwright.stages.formats.numbers import number, spaced
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.model.scene import FLOOR as GROUND
from linkwright.stages.robot.text.names import free

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection, LightSection, SkySection
    from linkwright.stages.export.writer import WriterInput

TEMPLATE = Path(__file__).with_name("scene.xml")

FLOOR = ("asset/texture[@name='checker']", "asset/material[@name='checker']", "worldbody/geom[@name='floor']")
"""The elements of the template that make the floor."""

PLAIN = "0.5 0.5 0.5 1"


def write_scene(given: "WriterInput", model: bytes) -> bytes:
    """The scene around `<robot>.xml`, which it includes and whose text is `model`."""
    robot, keys, standing = given.written.robot.name, given.keys, given.standing
    extras = given.written.extras
    root = parse(TEMPLATE.read_bytes())
    root.set("model", f"{robot}_scene")
    root.find("include").set("file", f"{robot}.xml")
    _settings(root, "compiler", keys.scene.compiler)
    in_the_robot = {*IN_THE_ROBOT, *dict(extras.option), *dict(extras.flag)}
    _settings(root, "option", keys.scene.option, in_the_robot)
    world = root.find("worldbody")
    _sky(root.find("asset"), keys.scene.skybox)
    _ground(root, keys.ground)
    beside = {(node.tag, node.name) for section in extras.scene for node in section.inside()}
    _lights(world, keys.scene.lights, any(tag == "light" for tag, _ in beside))
    floor, geoms = world.find(f"geom[@name='{GROUND}']"), {name for tag, name in beside if tag == "geom"}
    if floor is not None:
        floor.set("name", free(GROUND, geoms))
    write_sections(root, extras.scene)
    if np.isfinite(standing.low).all():
        middle, size = (standing.low + standing.high) / 2, standing.high - standing.low
        extent = max(float(np.max(size)), 1e-3)
        statistic = element(None, "statistic", center=spaced(_short(middle)), extent=number(_short(extent)))
        root.find("include").addnext(statistic)
        if "overview" not in keys.scene.cameras and ("camera", "overview") not in beside:
            overview(world, middle, float(np.linalg.norm(size)) / 2)
    for name, camera in keys.scene.cameras.items():
        if camera.frame is None:
            write_camera(world, name, camera, np.eye(4))
    if extras.moves_in_scene:
        write_keyframes(root, given, parse(model))
    return to_bytes(root)


def _short(value: Any) -> Any:
    """Lengths [m] that need no more than millimetres."""
    return np.round(value, 3) + 0.0


def _settings(root: Element, name: str, keys: Any, without: Collection[str] = ()) -> None:
    """An element of MuJoCo's own attributes, and one for each section of them, where something is given."""
    given = {key: text(value) for key, value in keys.given().items() if key not in without}
    below = {
        key: {attribute: value for attribute, value in section.given().items() if attribute not in without}
        for key, section in keys.sections().items()
    }
    if not given and not any(below.values()):
        return
    made = element(None, name, **given)
    for key, values in below.items():
        if values:
            element(made, key, **{attribute: text(value) for attribute, value in values.items()})
    root.find("include").addnext(made)


def _sky(asset: Element, sky: "SkySection") -> None:
    texture = asset.find("texture[@type='skybox']")
    if sky.kind == "none":
        asset.remove(texture)
        return
    texture.set("rgb1", spaced(sky.top))
    texture.set("rgb2", spaced(sky.bottom))


def _ground(root: Element, ground: "GroundSection") -> None:
    texture, material, floor = (root.find(path) for path in FLOOR)
    if ground.kind == "none" or ground.material == "plain":
        for part in (texture, material):
            part.getparent().remove(part)
        del floor.attrib["material"]
    if ground.kind == "none":
        floor.getparent().remove(floor)
        return
    if ground.material == "plain":
        floor.set("rgba", PLAIN)
    half = "0 0" if ground.size is None else spaced(np.array(ground.size) / 2)
    floor.set("size", f"{half} 0.05")
    floor.set("friction", spaced(ground.friction))
    for name, value in placement(ground_pose(ground)).items():
        floor.set(name, value)


def _lights(world: Element, lights: Mapping[str, "LightSection"], lit: bool) -> None:
    """The template's sun, unless it is given or the scene is `lit` without it, and the user's lights."""
    if "sun" in lights or lit:
        world.remove(world.find("light[@name='sun']"))
    for name, light in lights.items():
        if light.kind == "none":
            continue
        element(
            world,
            "light",
            name=name,
            type=light.kind,
            pos=spaced(light.xyz),
            dir=spaced(light.direction),
            diffuse=spaced(light.diffuse),
            ambient=spaced(light.ambient),
            specular=spaced(light.specular),
            castshadow=text(light.shadow),
            cutoff=number(light.cutoff) if light.kind == "spot" else None,
        )
