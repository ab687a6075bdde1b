"""The colours of the pages: each can be read on each ground, in the light and in the dark."""

import re

import pytest

from linkwright.pipeline.page.html.shell import STYLE

LEAST = 4.5
"""WCAG 2.2, 1.4.3: the contrast of text."""

NAMES = ("text", "soft", "line", "back", "accent", "bad", "warn", "good", "panel")


def schemes():
    """The variables of the light and of the dark scheme."""
    css = STYLE.read_text(encoding="utf-8")
    dark = css.index("prefers-color-scheme: dark")
    light, dark = re.findall(r":root \{(.*?)\}", css[:dark], re.DOTALL), [css[dark : css.index("* {")]]
    return [dict(re.findall(r"--(\w+): (#[0-9a-f]{6});", "".join(block))) for block in (light, dark)]


def luminance(colour):
    """Relative luminance, WCAG 2.2."""
    parts = [int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)]
    red, green, blue = (
        part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
    )
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue


def contrast(first, other):
    dim, bright = sorted((luminance(first), luminance(other)))
    return (bright + 0.05) / (dim + 0.05)


def test_contrast_is_that_of_the_standard():
    assert contrast("#ffffff", "#000000") == pytest.approx(21.0)
    # An example that WebAIM and the W3C give: the lightest grey that passes on white.
    assert contrast("#767676", "#ffffff") == pytest.approx(4.54, abs=0.005)


@pytest.mark.parametrize("scheme", [0, 1], ids=["light", "dark"])
@pytest.mark.parametrize("ground", ["back", "panel"])
@pytest.mark.parametrize("colour", ["text", "soft", "accent", "bad", "warn", "good"])
def test_text_can_be_read(scheme, ground, colour):
    colours = schemes()[scheme]
    assert set(NAMES) == set(colours)
    assert contrast(colours[colour], colours[ground]) >= LEAST


def test_no_rule_has_a_colour_of_its_own():
    css = STYLE.read_text(encoding="utf-8")
    rules = re.sub(r":root \{.*?\}", "", css, flags=re.DOTALL)
    assert not re.search(r"#[0-9a-fA-F]{3,8}\b(?![^{]*\{)|rgba?\(|hsla?\(", rules)
    for name in re.findall(r"var\(--(\w+)\)", css):
        assert name in NAMES, name
