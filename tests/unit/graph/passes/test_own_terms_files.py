"""What each key for joints in one's own terms, and the total mass, comes to in both files."""

from pathlib import Path
from typing import Any

import mujoco
import pytest
import yaml
from lxml import etree

from linkwright.stages.export import Exported, export
from linkwright.stages.graph.section import JointSection
from tests.fake_onshape import solids
from tests.fake_onshape.frames import frame
from tests.support.building import NO_MESHES, plan_of, robot_of
from tests.support.kit import Kit

FILE = Path(__file__).parent / "golden" / "own_terms.yaml"
GOLDEN = yaml.safe_load(FILE.read_text(encoding="utf-8"))
"""Title → keys of the configuration, and the elements that they come to."""

OWN = {"zero", "invert", "rotor_inertia", "gear"}


def made(keys: dict[str, Any]) -> Exported:
    """A pinion that drives a rack, and a flap with a screw whose mass is estimated."""
    kit = Kit()
    base, wheel, rack, flap = kit.based("Wheel", "Rack", "Flap")
    pinion = kit.root.revolute("Pinion", (wheel, frame()), (base, frame((0, 0, 0.1))), 0.2, limits=(-1, 2))
    rail = kit.root.slider("Rail", (rack, frame()), (base, frame((0.1, 0, 0))), 0.02, limits=(0, 0.1))
    kit.root.rack("Gearing", pinion, rail, 0.6283185307179586, reverse=True)
    kit.root.revolute("Lid", (flap, frame()), (base, frame((0, 0.1, 0))), limits=(-0.5, 0.5))
    screw = kit.root.add(kit.studio.part("Screw", solids.box(0.002, 0.002, 0.002)))
    kit.root.fasten("Screwed", (screw, frame()), (flap, frame((0, 0, 0.05))))
    return export(robot_of(kit.document, plan_of(**keys)), NO_MESHES, plan_of(**keys))


def elements(outcome: Exported) -> list[str]:
    """The joints of both files and what follows, and the masses, one a line."""
    mjcf, urdf = (etree.fromstring(outcome.files[f"robot.{end}"]) for end in ("xml", "urdf"))
    joints = (e for e in mjcf.iter("joint") if e.get("name") or e.getparent().tag == "equality")
    keys = (key for key in mjcf.iter("key") if key.get("name") not in ("home", "cad"))
    lines = [_line(element) for element in (*joints, *keys)]
    for joint in urdf.iterfind("joint"):
        parts = [_line(part) for part in joint if part.tag in ("axis", "limit", "mimic")]
        lines.append(f"urdf {joint.get('name')}: {'; '.join(parts)}")
    return [*lines, f"mass {sum(float(mass.get('value')) for mass in urdf.iter('mass')):.9g}"]


def _line(element: Any) -> str:
    return " ".join([element.tag, *(f"{key}={value}" for key, value in element.items())])


@pytest.mark.parametrize("title", GOLDEN)
def test_each_key_comes_to_its_golden_and_compiles(title):
    outcome = made(GOLDEN[title]["keys"])
    assert elements(outcome) == GOLDEN[title]["elements"], (
        "if this is meant: python -m tests.unit.graph.passes.test_own_terms_files"
    )
    model = mujoco.MjModel.from_xml_string(outcome.files["robot.xml"].decode())
    for name in ("pinion", "rail", "lid"):
        # At its own zero a joint is where the untouched robot has that value of the mate.
        own = GOLDEN[title]["keys"].get("joints", {}).get(name, {})
        assert model.joint(name).range[0] < model.joint(name).range[1]
        if "armature" in own or "rotor_inertia" in own:
            expected = own["rotor_inertia"] * own.get("gear", 1) ** 2
            assert model.dof_armature[model.joint(name).dofadr[0]] == pytest.approx(expected)


def test_every_key_has_a_golden():
    entries = [entry["keys"] for entry in GOLDEN.values()]
    keys = {key for entry in entries for joint in entry.get("joints", {}).values() for key in joint}
    assert set(JointSection.model_fields) >= keys >= OWN
    assert any("total" in entry.get("mass", {}) for entry in entries)


if __name__ == "__main__":
    written = {
        title: {"keys": entry["keys"], "elements": elements(made(entry["keys"]))}
        for title, entry in GOLDEN.items()
    }
    FILE.write_text(yaml.safe_dump(written, sort_keys=False, width=200), encoding="utf-8")
