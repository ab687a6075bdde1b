"""Materials have names that a reader knows them by."""

import colorsys

import pytest

from linkwright.stages.export.paints import NAMED_COLOURS, materials, word
from linkwright.stages.robot.model.geometry import Geometry, Shape


@pytest.mark.parametrize("name", NAMED_COLOURS)
def test_colour_that_has_a_name_gets_it(name):
    assert (word((*NAMED_COLOURS[name], 1.0)), word((*NAMED_COLOURS[name], 0.4))) == (name, f"clear_{name}")


@pytest.mark.parametrize(
    ("hue", "names"),
    [(0, {"red"}), (30, {"orange"}), (60, {"yellow"}), (120, {"green", "light_green"}), (230, {"blue"})],
)
def test_strong_colours_have_the_name_of_their_hue(hue, names):
    assert word((*colorsys.hsv_to_rgb(hue / 360, 0.95, 0.95), 1.0)) in names


def test_each_material_has_a_name_of_its_own():
    colours = [(0.9, 0.1, 0.1, 1.0), (0.88, 0.1, 0.1, 1.0), (0.7, 0.7, 0.7, 1.0)]
    shapes = [
        Shape("base", "visual", f"m{n}.stl", colour, 8, 12, 1.0, 1.0) for n, colour in enumerate(colours)
    ]
    skin = Shape("base", "visual", "skin.obj", colours[0], 8, 12, 1.0, 1.0, texture="skin.png")
    names = materials(Geometry((*shapes, skin), {}))
    assert (names[colours[1], ""], names[colours[0], ""]) == ("red", "red_2")
    assert (names[colours[2], ""], names[colours[0], "skin.png"]) == ("light_grey", "skin_material")
    assert len(set(names.values())) == 4
