"""Golden YAML of every file in `conf`, and the reference of all keys: `python -m tests.config.regenerate`.

An option's golden is its section of the plan, a robot's and `build`'s the whole plan, that of a motor what
the plan has of it, that of a launcher what it sets itself, and that of another file for Hydra itself Hydra's
own composed section.
"""

from pathlib import Path

import yaml

from linkwright.pipeline.config.compose import HYDRA_ARGUMENTS, compose_plan
from linkwright.pipeline.config.presets import OURS
from linkwright.pipeline.reference import (
    COMMAND_JSON,
    DATA,
    HELP,
    MUTATIONS,
    PAGE,
    PEERS,
    READERS,
    ROBOT_JSON,
    ROBOT_JSON_SCHEMA,
    SCHEMA,
)
from tests.config import command_json, peers, readers, reference, robot_json

GOLDEN = Path(__file__).parent / "golden"

URL = "https://cad.onshape.com/documents/5f1a0c2b9d8e7f6a5b4c3d2e/w/0a1b2c3d4e5f60718293a4b5/e/a1b2c3d4e5f60718293a4b5c"

GIVEN = {
    "source.onshape": [f"source.url='{URL}'"],
    "source.urdf": ["source.path=arm.urdf"],
    "source.mjcf": ["source.path=arm.xml"],
    "source.bundle": ["source.path=arm.zip"],
}
"""What an option needs besides itself."""


def names():
    """Golden's name → the file in `conf` that it is of."""
    files = [file.relative_to(OURS).as_posix() for file in OURS.rglob("*.yaml")]
    return {file.removesuffix(".yaml").replace("/", "."): file for file in sorted(files)}


def composed(name, empty):
    """What the file of a golden comes to, composed in an empty folder."""
    if name == "build":
        return compose_plan(["source=sample"], cwd=empty).plan.tree()
    group, _, option = name.rpartition(".")
    if group == "hydra.launcher":
        # What it sets itself: all the rest is of a plug-in, of the version that is installed.
        return {group: yaml.safe_load((OURS / names()[name]).read_text(encoding="utf-8"))}
    if group.startswith("hydra."):
        return _hydra_section(group, option)
    if group == "actuators.motors":
        arguments = ["source=sample", f"actuators.lift.motor={option}"]
        return {"motors": compose_plan(arguments, cwd=empty).plan.tree()["motors"]}
    choice = [f"{group}={option}"]
    if group != "source" and (group != "robot" or option in ("bare", "legged")):
        choice.append("source=sample")
    tree = compose_plan([*choice, *GIVEN.get(name, [])], cwd=empty).plan.tree()
    return tree if group == "robot" else {group: tree[group]}


def text(name, empty):
    """The golden's text."""
    return yaml.safe_dump(composed(name, empty), sort_keys=False, allow_unicode=True, width=100)


def _hydra_section(group, option):
    from hydra import compose, initialize_config_module
    from omegaconf import OmegaConf

    with initialize_config_module("linkwright.conf", **HYDRA_ARGUMENTS):
        override = f"{group.replace('.', '/')}={option}"
        config = compose("build", [override], return_hydra_config=True)
    section = OmegaConf.to_container(OmegaConf.select(config, group), resolve=False)
    return {group: section}


def _mutations():
    # Imported where it is asked for: goldens are checked where the faults that tests plant are not.
    from tests.support.faults import page

    return page.markdown()


REFERENCE = {
    DATA: reference.json_text,
    HELP: reference.help_text,
    MUTATIONS: _mutations,
    PAGE: reference.markdown,
    PEERS: peers.markdown,
    READERS: readers.markdown,
    COMMAND_JSON: command_json.markdown,
    ROBOT_JSON: robot_json.markdown,
    ROBOT_JSON_SCHEMA: robot_json.schema_text,
    SCHEMA: reference.schema_text,
    peers.TOOLKIT_PAGE: peers.toolkit_page,
    **command_json.schemas(),
}
"""Generated file → its text."""


def main():
    import tempfile

    GOLDEN.mkdir(exist_ok=True)
    for old in GOLDEN.glob("*.yaml"):
        old.unlink()
    with tempfile.TemporaryDirectory() as empty:
        for name in names():
            (GOLDEN / f"{name}.yaml").write_text(text(name, Path(empty)), encoding="utf-8")
    for path, made in REFERENCE.items():
        path.parent.mkdir(exist_ok=True)
        path.write_text(made(), encoding="utf-8")
    print(f"{len(names())} goldens written")


if __name__ == "__main__":
    main()
