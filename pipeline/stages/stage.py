"""Defines the five stages: the inputs of each, and the files that it makes from them.

A stage's result is a set of files in the cache; its value is decoded only where a later stage runs.
Besides its value each stage writes `notes.json`, with the diagnostics, figures and one-line summary for the
report, so that a cached stage reports the same.
"""

import contextlib
import json
from collections.abc import Iterator, Mapping
from typing import Any

import linkwright.stages.export
import linkwright.stages.fetch
import linkwright.stages.graph
import linkwright.stages.mesh
import linkwright.stages.validate
from linkwright.pipeline import interrupt
from linkwright.pipeline.caching import bundles
from linkwright.pipeline.caching.actions import Action, Files, MemoResult
from linkwright.pipeline.config.plan import Plan, section
from linkwright.pipeline.digest import sha256
from linkwright.pipeline.element_files import require_valid_elements
from linkwright.pipeline.mesh_details import mesh_notes, progress_of
from linkwright.pipeline.plugins.loader import require_code, user_checks, with_sources
from linkwright.pipeline.stages.context import FILES, NOTES, ROBOT, WRITTEN, BuildContext, call_record, notes
from linkwright.pipeline.stages.stage_base import Stage as Stage
from linkwright.pipeline.stages.stage_base import StageBase
from linkwright.stages.export import export
from linkwright.stages.export.requirements import packages, require
from linkwright.stages.export.section import ExportSections
from linkwright.stages.export.usd.date import with_date
from linkwright.stages.export.writers import WRITERS
from linkwright.stages.fetch import ahead, changes_document, fetch, force, pinned, preflight, spends, summary
from linkwright.stages.fetch.source import Calls, CallsAhead, FetchContext
from linkwright.stages.graph import build_robot
from linkwright.stages.graph.section import GraphSections
from linkwright.stages.mesh import make_geometry
from linkwright.stages.mesh.section import MeshSections
from linkwright.stages.mesh.view.views import views as mesh_views
from linkwright.stages.robot import codec
from linkwright.stages.robot.errors import ConfigError
from linkwright.stages.robot.system.install import installed
from linkwright.stages.robot.text.plural import count
from linkwright.stages.show.graph_view.views import views as graph_views
from linkwright.stages.validate import external, measured, validate
from linkwright.stages.validate.section import ValidateSections


class FetchStage(StageBase):
    name = "fetch"
    face = linkwright.stages.fetch
    modules = ("linkwright.stages.fetch.onshape.triangles.faces",)

    def preflight(self, plan: Plan, environ: Mapping[str, str]) -> None:
        preflight(plan, environ)
        if changes_document(plan) and plan.cache.mode == "bypass":
            msg = "variables cannot be set without the cache, which stores their original values"
            raise ConfigError(msg, "source.variables", "leave out cache.mode=bypass")

    def config(self, context: BuildContext) -> Any:
        identity = pinned(context.plan, context.environ)
        return None if identity is None else {"pinned": identity}

    def force(self, context: BuildContext) -> bool:
        return force(context.plan)

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        return {}

    def ahead(self, context: BuildContext) -> CallsAhead:
        """Returns the API calls that `run` will make to a remote source."""
        with _fetch_context(context) as fetch_context:
            return ahead(context.plan, fetch_context)

    def run(self, context: BuildContext) -> dict[str, bytes]:
        if spends(context.plan):
            context.require_room()
        with _fetch_context(context) as fetch_context:
            fetched = fetch(context.plan, fetch_context)
        bundle = fetched.bundle
        context.cache.check(bundles.readable_files(bundle))
        size = sum(len(body) for body in bundle.blobs.values())
        lasting_note: dict[str, Any] = {} if fetched.lasts else {"lasts": False}
        return {
            **codec.encode_bundle(bundle),
            NOTES: notes(
                f"{summary(bundle)}, {size / 1e6:.2f} MB",
                fetched.diagnostics,
                source={**bundle.root, **({"title": fetched.title} if fetched.title else {})},
                calls=fetched.calls + fetched.saved,
                stale=fetched.stale,
                **lasting_note,
            ),
        }


@contextlib.contextmanager
def _fetch_context(context: BuildContext) -> Iterator[FetchContext]:
    """Yields the context of a fetch, and counts its API calls even if it fails."""
    calls = Calls()
    try:
        yield FetchContext(
            context.cache.replies(),
            context.environ,
            progress=context.detail,
            transient=context.transient,
            ledger=context.ledger,
            calls=calls,
            sweep=context.sweep,
            while_waiting=context.import_ahead,
        )
    finally:
        context.calls |= call_record(calls)


class GraphStage(StageBase):
    name = "graph"
    face = linkwright.stages.graph
    libraries = ("numpy", "scipy", "networkx", "lxml")
    modules = ("linkwright.stages.graph.build", "linkwright.stages.show.graph_view.views")

    def config(self, context: BuildContext) -> Any:
        return section(context.plan, GraphSections)

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        # The manifest names every reply by its digest.
        return {"manifest": context.files["fetch"].digests["manifest.json"]}

    def run(self, context: BuildContext) -> dict[str, bytes]:
        robot = build_robot(context.bundle, context.plan)
        figures = {
            "links": len(robot.links),
            "joints": len(robot.joints),
            "dofs": len(robot.dofs),
            "coordinates": robot.mobility.coordinates,
            "gruebler": robot.mobility.gruebler,
            "dof": robot.mobility.dof,
            "loops": len(robot.loops),
            "mass": sum(link.inertial.mass for link in robot.links),
            "parts": sum(len(link.parts) for link in robot.links),
        }
        kinds = {"link": robot.links, "joint": robot.joints, "loop": robot.loops}
        summary = ", ".join(count(len(items), kind) for kind, items in kinds.items())
        return {
            ROBOT: codec.encode_robot(robot),
            **graph_views(robot),
            NOTES: notes(summary, robot.diagnostics, figures),
        }


class MeshStage(StageBase):
    name = "mesh"
    face = linkwright.stages.mesh
    libraries = ("numpy", "scipy", "manifold3d", "mujoco")
    modules = ("linkwright.stages.mesh.geometry", "scipy.spatial", "scipy.sparse.csgraph")

    def config(self, context: BuildContext) -> Any:
        return section(context.plan, MeshSections)

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        # The robot names each tessellation by its digest. The whole robot is the input: a change that
        # touches no part runs this stage again, but the results of each part are in the memo.
        return context.digests("graph")

    def run(self, context: BuildContext) -> dict[str, bytes]:
        # Late: a stage whose inputs did not change needs none of it.
        from linkwright.pipeline.stages.robot_names import require_names

        require_names(context.robot, context.plan)
        # MuJoCo makes no mesh: results that it decides have its version in their own keys.
        versions = {name: version for name, version in libraries(self).items() if name != "mujoco"}
        memo_results: list[MemoResult] = []
        memo = context.cache.memo(self.name, self.version, versions, memo_results.append)
        geometry = make_geometry(context.robot, context.bundle, context.plan, memo, progress_of(context))
        return {
            **codec.encode_geometry(geometry),
            **mesh_views(geometry, memo),
            NOTES: mesh_notes(geometry, memo_results),
        }


class ExportStage(StageBase):
    name = "export"
    face = linkwright.stages.export
    libraries = ("numpy", "scipy", "lxml", "mujoco")

    @property
    def modules(self) -> tuple[str, ...]:
        return tuple(module for writer in WRITERS.values() for module in writer.modules)

    def preflight(self, plan: Plan, environ: Mapping[str, str]) -> None:
        require(plan)
        require_valid_elements(plan)
        with_date(plan, environ)

    def config(self, context: BuildContext) -> Any:
        return section(with_date(context.plan, context.environ), ExportSections)

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        texts = {f"elements/{name}": sha256(text.encode()) for name, text in context.element_texts.items()}
        versions = {f"libraries/{name}": sha256(installed(name).encode()) for name in packages(context.plan)}
        return {**context.digests("graph"), **context.digests("mesh"), **texts, **versions}

    def run(self, context: BuildContext) -> dict[str, bytes]:
        # Late: a stage whose inputs did not change needs none of it.
        from linkwright.stages.formats.written import encode

        keys = with_date(context.plan, context.environ)
        exported = export(context.robot, context.geometry, keys, context.element_texts)
        size = sum(len(data) for data in exported.files.values())
        summary = f"{count(len(exported.files), 'file')}, {size / 1e6:.2f} MB"
        return {
            **{FILES + path: data for path, data in exported.files.items()},
            WRITTEN: encode(exported.written),
            NOTES: notes(summary, exported.diagnostics, advice=exported.advice, details=exported.details),
        }


class ValidateStage(StageBase):
    name = "validate"
    face = linkwright.stages.validate
    libraries = ("numpy", "mujoco", "lxml", "pin")

    @property
    def modules(self) -> tuple[str, ...]:
        return ("linkwright.stages.validate.engines", "linkwright.stages.validate.checks")

    def preflight(self, plan: Plan, environ: Mapping[str, str]) -> None:
        require_code(plan)
        external.require(plan.validate.external, plan.export.chosen, environ)

    def config(self, context: BuildContext) -> Any:
        return with_sources(section(context.plan, ValidateSections), context.plan)

    def inputs(self, context: BuildContext) -> Mapping[str, str]:
        shapes = context.digests("mesh")["mesh/geometry.json"]
        tools = external.versions(context.plan.validate.external, context.environ)
        versions = {f"external/{name}": sha256(version.encode()) for name, version in tools.items()}
        return {
            **context.digests("graph"),
            **context.digests("export"),
            "mesh/geometry.json": shapes,
            **versions,
        }

    def run(self, context: BuildContext) -> dict[str, bytes]:
        tools = context.plan.validate.external
        with context.cache.store.scratch(context.files["export"].below(FILES)) as folder:
            checks = validate(folder, context.written, context.plan, user_checks(context.plan))
            checks += external.check_externally(folder, context.robot.name, tools, context.environ)
            figures = measured(folder, context.robot.name, context.plan.validate.level)
        summary = f"{sum(check.passed for check in checks)} of {count(len(checks), 'check')} passed"
        lasting_note: dict[str, Any] = {"lasts": False} if any(map(external.gave_no_verdict, checks)) else {}
        return {
            "checks.json": codec.encode_checks(checks),
            NOTES: notes(summary, figures=figures, **lasting_note),
        }


EXPORT: Stage = ExportStage()

STAGES: tuple[Stage, ...] = (FetchStage(), GraphStage(), MeshStage(), EXPORT, ValidateStage())


def stages_until(name: str, stages: tuple[Stage, ...] = STAGES) -> tuple[Stage, ...]:
    """Returns the stages up to and including the stage `name`."""
    last = [stage.name for stage in stages].index(name)
    return stages[: last + 1]


def libraries(stage: Stage) -> dict[str, str]:
    """Returns the installed versions of linkwright and of the libraries that affect the stage's result."""
    return {library: installed(library) for library in ("linkwright", *stage.libraries)}


def perform(stage: Stage, context: BuildContext) -> tuple[Files, bool]:
    """Runs a stage, or takes its result from the cache; returns its files, and whether they are cached."""
    interrupt.check()
    config = stage.config(context)
    if config is None:
        return context.cache.keep(stage.run(context)), False
    action = Action(stage.name, stage.version, config, stage.inputs(context), libraries(stage))
    context.actions[stage.name] = action
    return context.cache.run(
        action,
        lambda: stage.run(context),
        force=stage.force(context),
        lasts=lambda files: bool(json.loads(files[NOTES]).get("lasts", True)),
    )
