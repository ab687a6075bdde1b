"""C-VARIANTS: variants of another model, with values that no robot can have, or that do not hold."""

import shutil
from dataclasses import replace

import mujoco
import numpy as np
import pytest

from linkwright.stages.formats.variants import Variants
from linkwright.stages.robot.text.file_names import VARIANTS as FILE
from linkwright.stages.validate.checks.simulation.variants import check
from linkwright.stages.validate.compiled import CompiledModel
from tests.support.building import plan_of, write
from tests.unit.export.test_variants import hinges

ZERO = np.zeros(1, np.int32)


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("built")
    plan = plan_of(
        actuators={"*": "position"},
        variants={"n": 7, "seed": 1},
        scene__pose={"xyz": [0, 0, 3], "rpy": [1.5, 0.2, 0]},
    )
    return folder, write(hinges(), folder, plan)


def results(folder, exported):
    model = mujoco.MjModel.from_xml_path(str(folder / "scene.xml"))
    compiled = CompiledModel(folder / "scene.xml", model, exported.written)
    return {check.name.removeprefix("scene.xml: "): check for check in check(compiled)}


def test_good_variants_pass(built):
    outcomes = results(*built)
    assert list(outcomes) == ["variants", "variants run", "variants rest"]
    assert all(check.passed for check in outcomes.values())
    assert "0, 2, 4, 6" in outcomes["variants run"].detail


def test_without_a_file_nothing_is_said(built, tmp_path):
    folder = shutil.copytree(built[0], tmp_path / "copy")
    (folder / FILE).unlink()
    assert results(folder, built[1]) == {}


def with_field(field, change):
    def changed(variants):
        return replace(variants, fields={**variants.fields, field: change(variants.fields[field].copy())})

    return changed


def having(**values):
    """Other values of some attributes of the variants."""
    return lambda variants: replace(variants, **values)


def put(index, value):
    def change(values):
        values[index] = value
        return values

    return change


BODIES = {"body": ("world", "base", "x", "y")}

BAD = {
    "nan": (with_field("body_ipos", put((3, 1, 0), np.nan)), "not finite"),
    "no mass": (with_field("body_mass", put((3, 2), 0.0)), "body_mass"),
    "mass of the world": (with_field("body_mass", put((3, 0), 1.0)), "body_mass"),
    "inertia": (with_field("body_inertia", put((3, 1, 0), 9.0)), "body_inertia"),
    "damping": (with_field("dof_damping", put((3, 0), -0.1)), "dof_damping"),
    "fewer": (with_field("dof_damping", lambda values: values[:5]), "another number"),
    "shape": (with_field("body_mass", lambda values: values[:, :-1].T), "body_mass"),
    "no field": (lambda model: replace(model, fields={"timestep": model.fields["body_mass"]}), "timestep"),
    "names": (lambda model: replace(model, names={**model.names, **BODIES}), "body_names"),
    "geoms": (having(geom_bodyid=np.full(1, 99, np.int32), geom_in_body=ZERO), "geom_bodyid"),
    "places": (having(geom_bodyid=ZERO, geom_in_body=np.full(1, 9, np.int32)), "geom_bodyid"),
    "lengths": (having(geom_bodyid=ZERO), "geom_bodyid"),
    "digest": (having(mjcf="0" * 64), "is not the file"),
}


@pytest.mark.parametrize("fault", BAD)
def test_planted_fault_is_found(built, tmp_path, fault):
    change, words = BAD[fault]
    folder = shutil.copytree(built[0], tmp_path / "copy")
    good = Variants.from_bytes((folder / FILE).read_bytes())
    (folder / FILE).write_bytes(change(good).to_bytes())
    outcomes = results(folder, built[1])
    assert list(outcomes) == ["variants"]
    assert not outcomes["variants"].passed
    assert outcomes["variants"].level == "error"
    assert words in outcomes["variants"].detail


def test_edited_mjcf_is_found(built, tmp_path):
    folder = shutil.copytree(built[0], tmp_path / "copy")
    mjcf = folder / "robot.xml"
    mjcf.write_bytes(mjcf.read_bytes().replace(b"\n", b"\r\n"))
    assert results(folder, built[1])["variants"].passed
    mjcf.write_text(mjcf.read_text().replace('damping="0.2"', 'damping="0.3"'))
    assert "robot.xml is not the file" in results(folder, built[1])["variants"].detail


@pytest.mark.parametrize("data", [b"", b"PK\x03\x04", b"nothing" * 9])
def test_what_is_no_npz_is_found(built, tmp_path, data):
    folder = shutil.copytree(built[0], tmp_path / "copy")
    (folder / FILE).write_bytes(data)
    assert "cannot be read" in results(folder, built[1])["variants"].detail


def test_variants_that_do_not_hold_are_found(built, tmp_path):
    folder = shutil.copytree(built[0], tmp_path / "copy")
    good = Variants.from_bytes((folder / FILE).read_bytes())
    gains = {name: np.array(good.fields[name]) for name in ("actuator_gainprm", "actuator_biasprm")}
    for values in gains.values():
        values[4] *= 1e-3
    limp = replace(good, fields={**good.fields, **gains})
    (folder / FILE).write_bytes(limp.to_bytes())
    outcomes = results(folder, built[1])
    assert outcomes["variants run"].passed
    assert not outcomes["variants rest"].passed
    assert outcomes["variants rest"].level == "warning"
    assert "except 4;" in outcomes["variants rest"].detail
    for values in gains.values():
        values[6] *= 1e9
    (folder / FILE).write_bytes(replace(good, fields={**good.fields, **gains}).to_bytes())
    outcomes = results(folder, built[1])
    assert not outcomes["variants run"].passed
    assert "variant 6: after" in outcomes["variants run"].detail
