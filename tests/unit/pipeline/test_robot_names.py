"""Names that the robot does not have are told all at once, before a mesh is made."""

import pytest

from linkwright.pipeline.run.build import build
from linkwright.stages.robot.errors import LinkwrightError, MeshError
from tests.support.building import plan_of

ASKED = {
    "actuators": {"elbw": "position", "zz*": "motor"},
    "sensors": {
        "angles": {"type": "joint", "joints": "nope*"},
        "forces": {"type": "actuator", "actuators": "nope*"},
        "imu": "imu",
        "gap": {"type": "frame", "frame": "palm", "relative_to": "plam"},
        "eye": {"type": "camera", "frame": "palm", "sees": ["palm", "nobody"]},
    },
    "scene": {"cameras": {"top": {"frame": "roof"}}},
    "validate": {"payload": {"tol": 1.0}},
}
UNKNOWN = [
    ("E-GLOB", "actuators"),
    ("E-GLOB", "actuators"),
    ("E-FRAME", "scene.cameras.top.frame"),
    ("E-GLOB", "sensors.angles.joints"),
    ("E-FRAME", "sensors.eye.sees"),
    ("E-GLOB", "sensors.forces.actuators"),
    ("E-FRAME", "sensors.gap.relative_to"),
    ("E-FRAME", "sensors.imu.frame"),
    ("E-VALUE", "validate.payload.tol"),
]
KNOWN = {
    "actuators": {"elbow": "position"},
    "sensors": {"angles": {"type": "joint", "joints": "el*"}, "tool": "imu", "a": {"type": "actuator"}},
    "scene": {"cameras": {"top": {"frame": "tool"}}},
    "validate": {"payload": {"tool": 1.0}},
}


@pytest.mark.parametrize(("keys", "until", "count"), [
    (ASKED, "validate", 9), (ASKED, "export", 8), (ASKED, "mesh", 0), (KNOWN, "validate", 0),
])  # fmt: skip
def test_unknown_names_are_told_together_before_the_meshes(tmp_path, monkeypatch, keys, until, count):
    """As many of them as the stages until the last would meet."""

    def made(*_):
        raise MeshError("the meshes are made")

    monkeypatch.setattr("linkwright.pipeline.stages.stage.make_geometry", made)
    plan = plan_of(**keys, until=until, output=str(tmp_path / "arm"), cache={"dir": str(tmp_path / "cache")})
    with pytest.raises(LinkwrightError) as caught:
        build(plan, environ={})
    assert [(problem.code, problem.where) for problem in caught.value.problems] == UNKNOWN[:count]
    assert (caught.value.message == "the meshes are made") == (count == 0)
