"""Collects the robot's files for the output folder."""

from collections.abc import Mapping

from linkwright.pipeline.digest import sha256
from linkwright.pipeline.stages.context import FILES, ROBOT, BuildContext
from linkwright.pipeline.stages.stage import EXPORT, libraries
from linkwright.stages.export import VERSION
from linkwright.stages.show.graph_view.views import PICTURE


def products(context: BuildContext) -> dict[str, bytes]:
    """Returns the robot's files: the exported files and the graph's picture. For a build that stops before
    the export, they are `robot.json` and the picture."""
    files: dict[str, bytes] = {}
    if "export" in context.files:
        files = dict(context.files["export"].below(FILES))
    elif "graph" in context.files:
        files = {"robot.json": robot_json(context)}
    if "graph" in context.files and PICTURE in context.files["graph"]:
        files[PICTURE] = context.files["graph"][PICTURE]
    return files


def digests(context: BuildContext, files: Mapping[str, bytes]) -> dict[str, str]:
    """Returns the SHA-256 of each product; the cache knows most of them."""
    known_digests: dict[str, str] = {}
    if "export" in context.files:
        known_digests = context.files["export"].below(FILES).digests
    if PICTURE in files:
        known_digests[PICTURE] = context.files["graph"].digests[PICTURE]
    return {path: known_digests.get(path) or sha256(data) for path, data in sorted(files.items())}


def robot_json(context: BuildContext) -> bytes:
    """Returns `robot.json` as `description` writes it, without drives, since their trial run needs the
    meshes. The result is cached, since writing it needs slow imports."""

    def make() -> bytes:
        from linkwright.pipeline.run.description import description  # slow, and a cached build has it already

        return description(context.robot, context.plan)

    memo = context.cache.memo("export", VERSION, libraries(EXPORT))
    key = {
        "robot": context.files["graph"].digests[ROBOT],
        "formats": context.plan.export.identity(),
        "sensors": {name: keys.identity() for name, keys in context.plan.sensors.items()},
        # What an MJCF has beside the robot depends on it.
        "scene": context.plan.scene.identity(),
    }
    return memo("description", key, make)
