"""Writes scene.xml: the robot in a small world with a floor, light and sky, ready for a viewer."""

from collections.abc import Collection, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from linkwright.stages.export.configuration.mujoco_section import ROBOT_FILE_OPTIONS
from linkwright.stages.export.mjcf.keyframes import write_keyframes
from linkwright.stages.export.mjcf.placement import placement
from linkwright.stages.export.mjcf.sections import write_sections
from linkwright.stages.export.mjcf.sensing.cameras import write_camera, write_overview
from linkwright.stages.export.mjcf.settings import attribute_text
from linkwright.stages.export.scene import ground_pose
from linkwright.stages.formats.numbers import number, spaced
from linkwright.stages.formats.xml import Element, element, parse, to_bytes
from linkwright.stages.robot.text.names import free_name

if TYPE_CHECKING:
    from linkwright.stages.export.configuration.scene_section import GroundSection, LightSection, SkySection
    from linkwright.stages.export.writer import WriterInput

TEMPLATE = Path(__file__).with_name("scene.xml")

FLOOR_PATHS = (
    "asset/texture[@name='checker']",
    "asset/material[@name='checker']",
    "worldbody/geom[@name='floor']",
)
"""XPaths of the elements that make the floor in the template: texture, material and geom."""

PLAIN_COLOUR = "0.5 0.5 0.5 1"
"""RGBA of a floor without a pattern."""

MIN_EXTENT = 1e-3
"""Smallest extent [m] of the scene: MuJoCo does not accept an extent of 0."""


def write_scene(inputs: "WriterInput", model: bytes) -> bytes:
    """Returns the content of the scene around `<robot>.xml`, which the scene includes. `model`: the content
    of that file."""
    robot, keys, standing = inputs.written.robot.name, inputs.keys, inputs.standing
    extras = inputs.written.extras
    # Each link of a chain is a level: `large` allows 2048 of them.
    root, robot_root = parse(TEMPLATE.read_bytes()), parse(model, large=True)
    root.set("model", f"{robot}_scene")
    root.find("include").set("file", f"{robot}.xml")
    _settings(root, "compiler", keys.scene.compiler)
    robot_options = {*ROBOT_FILE_OPTIONS, *dict(extras.option)}
    _settings(root, "option", keys.scene.option, robot_options, dict(extras.flag))
    world = root.find("worldbody")
    _sky(root.find("asset"), keys.scene.skybox)
    _ground(root, keys.ground)
    scene_names = {(node.tag, node.name) for section in extras.scene for node in section.inside()}
    robot_names = {(node.tag, node.get("name")) for node in robot_root.iter("camera", "geom", "light")}
    used_names = scene_names | robot_names
    if "sun" in keys.scene.lights or any(tag == "light" for tag, _ in scene_names):
        world.remove(world.find("light[@name='sun']"))
    for element_of_template in world.iterchildren("geom", "light"):
        _make_name_free(element_of_template, used_names)
    _lights(world, keys.scene.lights)
    write_sections(root, extras.scene)
    if np.isfinite(standing.low).all():
        center, size = (standing.low + standing.high) / 2, standing.high - standing.low
        extent = max(float(np.max(size)), MIN_EXTENT)
        statistic = element(
            None, "statistic", center=spaced(_in_millimetres(center)), extent=number(_in_millimetres(extent))
        )
        root.find("include").addnext(statistic)
        if "overview" not in keys.scene.cameras and ("camera", "overview") not in used_names:
            write_overview(world, center, float(np.linalg.norm(size)) / 2)
    for name, camera in keys.scene.cameras.items():
        if camera.frame is None:
            write_camera(world, name, camera, np.eye(4))
    if extras.moves_in_scene:
        write_keyframes(root, inputs, robot_root)
    return to_bytes(root)


def _make_name_free(node: Element, used_names: Collection[tuple[str, str]]) -> None:
    """Renames an element of the template if another element has its name. `used_names`: (tag, name)."""
    node.set("name", free_name(node.get("name"), {name for tag, name in used_names if tag == node.tag}))


def _in_millimetres(value: Any) -> Any:
    """Returns lengths [m], rounded to millimetres."""
    return np.round(value, 3) + 0.0  # -0 becomes 0


def _settings(
    root: Element,
    name: str,
    keys: Any,
    excluded: Collection[str] = (),
    excluded_in_sections: Collection[str] = (),
) -> None:
    """Writes an element with the MuJoCo attributes that are set, and a child for each section; nothing if
    none are set.

    `excluded`, `excluded_in_sections`: attributes of the element and of its children that are not written.
    They are separate, since an option and a flag can have the same name: `gravity`.
    """
    attributes = {key: attribute_text(value) for key, value in keys.explicit().items() if key not in excluded}
    sections = {
        key: {
            attribute: value
            for attribute, value in section.explicit().items()
            if attribute not in excluded_in_sections
        }
        for key, section in keys.sections().items()
    }
    if not attributes and not any(sections.values()):
        return
    node = element(None, name, **attributes)
    for key, values in sections.items():
        if values:
            element(node, key, **{attribute: attribute_text(value) for attribute, value in values.items()})
    root.find("include").addnext(node)


def _sky(asset: Element, sky: "SkySection") -> None:
    """Colours the template's sky, or removes it."""
    texture = asset.find("texture[@type='skybox']")
    if sky.kind == "none":
        asset.remove(texture)
        return
    texture.set("rgb1", spaced(sky.top))
    texture.set("rgb2", spaced(sky.bottom))


def _ground(root: Element, ground: "GroundSection") -> None:
    """Gives the template's floor its place, size, friction and look, or removes it."""
    texture, material, floor = (root.find(path) for path in FLOOR_PATHS)
    if ground.kind == "none" or ground.material == "plain":
        for part in (texture, material):
            part.getparent().remove(part)
        del floor.attrib["material"]
    if ground.kind == "none":
        floor.getparent().remove(floor)
        return
    if ground.material == "plain":
        floor.set("rgba", PLAIN_COLOUR)
    # Half lengths; 0 is infinite. The third number only sets the spacing of grid lines.
    half_lengths = "0 0" if ground.size is None else spaced(np.array(ground.size) / 2)
    floor.set("size", f"{half_lengths} 0.05")
    floor.set("friction", spaced(ground.friction))
    for name, value in placement(ground_pose(ground)).items():
        floor.set(name, value)


def _lights(world: Element, lights: Mapping[str, "LightSection"]) -> None:
    """Writes the user's lights."""
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
            castshadow=attribute_text(light.shadow),
            cutoff=number(light.cutoff) if light.kind == "spot" else None,
        )
