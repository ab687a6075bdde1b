"""Makes the geometry of a robot: the meshes and colliders of each link, which are then given file names."""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from linkwright.stages.mesh.assets import converted
from linkwright.stages.mesh.by_contact.build import by_contact, false_contacts
from linkwright.stages.mesh.by_contact.meeting import fine_links
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair
from linkwright.stages.mesh.collide import primitives
from linkwright.stages.mesh.collide.choices import default_choice
from linkwright.stages.mesh.collide.collision import Collider, colliders
from linkwright.stages.mesh.collide.make import ColliderJob, MadeCollider, collide
from linkwright.stages.mesh.collide.report import colliders_reported, figures_of
from linkwright.stages.mesh.collide.reshaped import reshaped
from linkwright.stages.mesh.com_check import com_outside_hull
from linkwright.stages.mesh.contact_parts import reported as too_small_reported
from linkwright.stages.mesh.contact_parts import with_basis
from linkwright.stages.mesh.contacts.analysis import self_contacts
from linkwright.stages.mesh.contacts.excluded_pairs import chosen_pairs, excluded_pairs
from linkwright.stages.mesh.diagnostics import diagnostics
from linkwright.stages.mesh.files import mesh_file
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.files.names import file_names, part_words
from linkwright.stages.mesh.idle_keys import idle_keys
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_mesh import PartFinding
from linkwright.stages.mesh.link_uses import LinkUses, link_visuals, used_meshes
from linkwright.stages.mesh.part_choices import PartChoice, part_choices, with_properties, with_shown_shapes
from linkwright.stages.mesh.surfaces.pieces import Piece, placed
from linkwright.stages.mesh.visuals import textures
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.mesh.visuals.whole import with_glb
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geom_form import PLAIN
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Link, Part, Primitive, Robot
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.targets.engines import ShapeLimits, shape_limits

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown
    from linkwright.stages.mesh.section import MeshSections


_Piece = tuple[int, Collider, list[Part]]
"""The index of a collider in its link, a piece of the collider, and the collider's parts."""


def geometry(
    robot: Robot, bundle: Bundle, keys: "MeshSections", memo: "Memo", shown: "Shown | None" = None
) -> Geometry:
    """Makes the shapes of all links. Raises ProtocolError if triangles cannot be read, and MeshError with
    each glob that matches nothing."""
    log = Diagnostics(optional=keys.optional)
    limits = shape_limits(keys.target.chosen)
    as_is = robot.mjcf is not None
    links = [with_basis(link, bundle.kind, keys.mesh.basis, as_is) for link in robot.links]
    choices = part_choices(links, keys, as_is, log)
    links = [with_shown_shapes(link, keys.ignore) for link in links]
    excluded = chosen_pairs([link.name for link in links], keys.contact.exclude, log)
    fine = fine_links(keys.mesh.fine, links, log)
    if log.problems:
        raise MeshError("the configuration names links or parts that are not there", problems=log.problems)
    library = MeshLibrary(links, bundle)
    uses = used_meshes(links, library, choices, memo, keys.mesh.min_size, as_is)
    jobs = [job for link in links for job in uses[link.name].jobs(link.name)]
    pairs_of = partial(excluded_pairs, robot, keys=keys.contact, chosen=excluded)
    with ThreadPoolExecutor(1, thread_name_prefix="visuals") as pool:
        visuals_future = pool.submit(link_visuals, uses, library, keys.mesh, memo)
        outcomes, still_false = _collided(robot, links, jobs, pairs_of, fine, library, memo, shown)
        visuals = visuals_future.result()
    shapes_by_link, files = _named_shapes(links, uses, visuals, outcomes, limits)
    files |= textures.images(visuals.values(), bundle)
    shapes = [shape for link in links for shape in shapes_by_link[link.name]]
    problems = diagnostics(links, visuals, {link.name: _findings(link, uses[link.name]) for link in links})
    problems += log.found
    makers = [default_choice(keys.mesh, limits), *(choice.maker for choice in choices.values())]
    parts = [[uses[outcome.job.link].parts[index] for index in outcome.job.parts] for outcome in outcomes]
    outcomes_with_parts = [*zip(outcomes, parts, strict=True)]
    problems += reshaped(links, outcomes_with_parts, makers, shapes, keys.mesh, keys.target.chosen)
    problems += idle_keys(keys, {maker.how for maker in makers}, bundle.kind)
    problems += colliders_reported(outcomes)
    problems += false_contacts(still_false)
    problems += too_small_reported({name: names for name in uses if (names := _small_names(uses[name]))})
    problems += com_outside_hull(links, library.of_parts, shapes, files)
    figures, choice_of = list[ColliderFigures](), dict[tuple[str, int], PartChoice]()
    for outcome, number in zip(outcomes, _numbers(outcomes), strict=True):
        link_uses = uses[outcome.job.link]
        choice_of[outcome.job.link, number] = link_uses.chosen[outcome.job.parts[0]]
        figures.append(figures_of(outcome, [link_uses.parts[part].name for part in outcome.job.parts]))
    # Only the shapes that are written: an exclude counts them.
    solid = [shape for shape in shapes if shape.file is None or keys.mesh.assets == "files"]
    contacts = self_contacts(
        robot, solid, files, keys.contact, memo, excluded, figures, keys.mesh.basis == "declared"
    )
    problems += contacts.diagnostics
    (written_shapes, assets), left_out = converted(
        with_properties(shapes, choice_of, keys.geoms, contacts.by_source),
        files,
        keys.mesh,
        obj_only=limits.obj,
    )
    contact = contacts.on, contacts.excludes, contacts.touching, tuple(figures), contacts.by_source
    result = Geometry(written_shapes, assets, (*problems, *left_out), *contact)
    return with_glb(result, shapes_by_link, keys.mesh.glb_up) if keys.mesh.format == "glb" else result


def _collided(
    robot: Robot,
    links: Sequence[Link],
    jobs: Sequence[ColliderJob],
    pairs_of: Callable[[Collection[str]], set[Pair] | None],
    fine: Collection[str] | None,
    library: MeshLibrary,
    memo: "Memo",
    shown: "Shown | None",
) -> tuple[list[MadeCollider], Sequence[FalsePair]]:
    """Makes the collider of each job, and returns them by link: in the order of the link's jobs, colliders by
    contact last. Also returns the pairs of links whose colliders by contact touch where the links do not.
    `pairs_of`: see `excluded_pairs`."""
    other = collide([job for job in jobs if not job.choice.by_contact], library, memo, shown)
    contact_jobs = [job for job in jobs if job.choice.by_contact]
    fixed: dict[str, list[Piece]] = {}
    for collider in other:
        pieces = [placed(piece, collider.job.link_from_subject) for piece in collider.collision.pieces]
        fixed.setdefault(collider.job.link, []).extend(pieces)
    for link in links:
        fixed.setdefault(link.name, []).extend(shape for shape in link.shapes if shape.collision)
    fixed = {link: pieces for link, pieces in fixed.items() if pieces}
    solid = {*fixed, *(job.link for job in contact_jobs)}
    collisions, false_pairs = by_contact(
        ContactRequest(robot, contact_jobs, fixed, pairs_of(solid), fine), library, memo
    )
    outcomes = [
        *other,
        *(MadeCollider(job, collision) for job, collision in zip(contact_jobs, collisions, strict=True)),
    ]
    position = {link.name: number for number, link in enumerate(links)}
    return sorted(outcomes, key=lambda collider: position[collider.job.link]), false_pairs


def _with_form(shape: Shape, parts: Sequence[Part], limits: ShapeLimits) -> Shape:
    """Returns the collider of these parts. The collider of a single part gets the form of its MJCF geom."""
    form = parts[0].form if len(parts) == 1 else PLAIN
    if not form.ellipsoid or "ellipsoid" in limits.without:
        return replace(shape, form=form)
    ellipsoid = Primitive("ellipsoid", form.ellipsoid, parts[0].link_from_part)
    return replace(shape, form=form, ellipsoid=ellipsoid)


def _findings(link: Link, uses: LinkUses) -> list[tuple[Part, PartFinding]]:
    without_mesh = [(part, PartFinding(False, None)) for part in link.parts if part.mesh is None]
    return [*zip(uses.parts, uses.link_parts.findings, strict=True), *without_mesh]


def _small_names(uses: LinkUses) -> list[str]:
    return [uses.parts[index].name for index in uses.small]


def _named_shapes(
    links: Sequence[Link],
    uses_by_link: Mapping[str, LinkUses],
    visuals: Mapping[str, LinkVisuals],
    outcomes: Sequence[MadeCollider],
    limits: ShapeLimits,
) -> tuple[dict[str, list[Shape]], dict[str, bytes]]:
    """Returns the shapes of each link, and the files of all meshes and colliders by name."""
    solid: dict[str, list[_Piece]] = {link.name: [] for link in links}
    for outcome, number in zip(outcomes, _numbers(outcomes), strict=True):
        pieces = colliders(outcome.collision, outcome.job.link_from_subject)
        parts = [uses_by_link[outcome.job.link].parts[index] for index in outcome.job.parts]
        solid[outcome.job.link] += ((number, _for_engine(piece, limits), parts) for piece in pieces)
    primitive_shapes = {link.name: list(primitives.shapes(link)) for link in links}
    meshed = {name: [_meshed(shape, limits) for shape in shapes] for name, shapes in primitive_shapes.items()}
    names = file_names(
        {name: _counts(uses_by_link[name], visuals[name], solid[name], meshed[name]) for name in solid}
    )
    shapes: dict[str, list[Shape]] = {}
    files: dict[str, bytes] = {}
    for link, collider_pieces in solid.items():
        visual_names, collider_names = names[link]
        shapes[link] = []
        free_names = iter(collider_names)
        for number, collider, parts in collider_pieces:
            if isinstance(collider, MeshFile):
                name = next(free_names)
                shape = _shape(link, "collision", name, collider)
                files[name] = collider.data
            else:
                shape = primitives.collider(link, collider)
            shapes[link].append(_with_form(replace(shape, collider=number), parts, limits))
        for name, file in zip(visual_names, visuals[link].files, strict=True):
            shapes[link].append(_shape(link, "visual", name, file))
            files[name] = file.data
        for shape, mesh in zip(primitive_shapes[link], meshed[link], strict=True):
            if mesh is None:
                shapes[link].append(shape)
            else:
                name = next(free_names)
                shapes[link].append(replace(_shape(link, "collision", name, mesh), form=shape.form))
                files[name] = mesh.data
    return shapes, dict(sorted(files.items()))


def _for_engine(collider: Collider, limits: ShapeLimits) -> Collider:
    """Returns the collider, or a prism of equal volume instead of a cylinder that a target cannot collide."""
    if isinstance(collider, MeshFile) or collider.kind != "cylinder" or "cylinder" not in limits.without:
        return collider
    prism = primitives.prism(collider)
    return collider if prism is None else mesh_file.collider(prism)


def _meshed(shape: Shape, limits: ShapeLimits) -> MeshFile | None:
    """Returns the mesh that replaces a primitive of the link itself; None if the primitive stays."""
    if shape.role == "visual" or shape.primitive is None:
        return None
    engine_collider = _for_engine(shape.primitive, limits)
    return engine_collider if isinstance(engine_collider, MeshFile) else None


def _numbers(outcomes: Sequence[MadeCollider]) -> list[int]:
    """Returns the index of each collider among the colliders of its link."""
    counts: Counter[str] = Counter()
    numbers = []
    for outcome in outcomes:
        numbers.append(counts[outcome.job.link])
        counts[outcome.job.link] += 1
    return numbers


def _counts(
    uses: LinkUses, visuals: LinkVisuals, solid: Sequence[_Piece], meshed: Sequence[MeshFile | None]
) -> tuple[int | list[str], int]:
    """Returns the number of a link's visual files, or a word for each if each belongs to one part; and the
    number of its collider files."""
    words = part_words([uses.parts[index].name for index in visuals.owners])
    files = [file for file in (*(piece for _, piece, _ in solid), *meshed) if isinstance(file, MeshFile)]
    return words or len(visuals.files), len(files)


def _shape(link: str, role: Role, name: str, file: MeshFile) -> Shape:
    texture = textures.image_name(file.texture) if file.texture else None
    figures = file.vertices, file.faces, file.area, file.volume
    return Shape(link, role, name, file.colour, *figures, texture=texture, bounds=tuple(file.bounds))
