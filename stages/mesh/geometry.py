"""Makes the geometry of a robot: the meshes and colliders of each link, and their file names."""

from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

from linkwright.stages.mesh import link_uses
from linkwright.stages.mesh.assets import convert_assets
from linkwright.stages.mesh.by_contact.build import by_contact, false_contact_reports
from linkwright.stages.mesh.by_contact.meeting import fine_links
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair, fixed_pieces
from linkwright.stages.mesh.collide import primitives
from linkwright.stages.mesh.collide.choices import default_choice
from linkwright.stages.mesh.collide.collision import Collider, colliders
from linkwright.stages.mesh.collide.make import ColliderJob, MadeCollider, collide, collider_indices
from linkwright.stages.mesh.collide.report import collider_reports, figures_of
from linkwright.stages.mesh.collide.reshaped import target_reports
from linkwright.stages.mesh.com_check import com_reports
from linkwright.stages.mesh.contact_parts import small_part_reports, with_basis
from linkwright.stages.mesh.contacts.analysis import Contacts, self_contacts
from linkwright.stages.mesh.contacts.excluded_pairs import chosen_pairs, excluded_pairs
from linkwright.stages.mesh.diagnostics import diagnostics
from linkwright.stages.mesh.files.mesh_file import MeshFile
from linkwright.stages.mesh.files.names import FileCounts, file_names, part_words
from linkwright.stages.mesh.idle_keys import idle_key_reports
from linkwright.stages.mesh.library import MeshLibrary
from linkwright.stages.mesh.link_uses import LinkUses
from linkwright.stages.mesh.part_choices import PartChoice, part_choices, with_properties, with_shown_shapes
from linkwright.stages.mesh.visuals import textures
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.mesh.visuals.whole import with_glb
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import Diagnostic, MeshError
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Link, Part, Robot
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.targets.engines import ShapeLimits, shape_limits

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown
    from linkwright.stages.mesh.section import MeshSections


class _Selection(NamedTuple):
    """The links as the configuration selects their shapes, and its choices for them."""

    links: list[Link]
    choices: dict[tuple[str, int], PartChoice]
    """The choices for each part, by its link's name and its index in the link."""
    excluded_pairs: frozenset[Pair]
    """Pairs of links that the configuration excludes from contact."""
    fine_link_names: set[str] | None
    """Links that `mesh.fine` names, see `ContactRequest.fine`."""
    reports: list[Diagnostic]
    """Reports on optional globs that match nothing."""


class _Inputs(NamedTuple):
    """The inputs that the steps of a build share."""

    robot: Robot
    selection: _Selection
    sections: "MeshSections"
    library: MeshLibrary
    memo: "Memo"


class _MadeMeshes(NamedTuple):
    """The meshes and colliders of all links, without file names."""

    uses: dict[str, LinkUses]
    """Link → its parts that have a mesh."""
    visuals: dict[str, LinkVisuals]
    """Link → its visual meshes."""
    colliders: list[MadeCollider]
    """The colliders link by link, the colliders by contact last in each link."""
    false_pairs: Sequence[FalsePair]
    """Pairs of links whose colliders by contact touch where the links do not."""

    def parts_of(self, collider: MadeCollider) -> list[Part]:
        """Returns the parts for which a collider was made."""
        return self.uses[collider.job.link].parts_of(collider.job)


class _ColliderPiece(NamedTuple):
    """A piece of a collider, as a solid that the engines take."""

    collider_index: int
    """Index of the collider among the colliders of its link."""
    solid: Collider
    parts: list[Part]
    """Parts for which the collider was made."""


class _ShapeWithMesh(NamedTuple):
    """A shape, and the mesh for its file; the mesh of a primitive is None."""

    shape: Shape
    mesh: MeshFile | None


def build_geometry(
    robot: Robot, bundle: Bundle, sections: "MeshSections", memo: "Memo", show_progress: "Shown | None" = None
) -> Geometry:
    """Makes the shapes of all links. Raises ProtocolError if triangles cannot be read, and MeshError with
    each glob that matches nothing. `show_progress`: shows the progress of colliders."""
    mesh_section, limits = sections.mesh, shape_limits(sections.target.chosen)
    selection = _select_shapes(robot, bundle.kind, sections)
    inputs = _Inputs(robot, selection, sections, MeshLibrary(selection.links, bundle), memo)
    made = _make_meshes(inputs, show_progress)
    shapes_by_link, files = _name_shapes(selection.links, made, limits)
    files |= textures.images(made.visuals.values(), bundle)
    shapes = [shape for link in selection.links for shape in shapes_by_link[link.name]]
    reports = _reports(inputs, made, shapes, files, bundle.kind)
    figures = [
        figures_of(collider, [part.name for part in made.parts_of(collider)]) for collider in made.colliders
    ]
    contacts = _contacts(inputs, shapes, files, figures)
    choices = link_uses.choices_by_collider(made.colliders, made.uses)
    contact_shapes = with_properties(shapes, choices, sections.geoms, contacts.by_source)
    assets = convert_assets(contact_shapes, files, mesh_section, obj_only=limits.needs_obj)
    result = Geometry(
        assets.shapes,
        assets.files,
        (*reports, *contacts.diagnostics, *assets.reports),
        self_contact=contacts.on,
        excludes=contacts.excludes,
        touching=contacts.touching,
        colliders=tuple(figures),
        by_source=contacts.by_source,
    )
    return with_glb(result, shapes_by_link, mesh_section.glb_up) if mesh_section.format == "glb" else result


def _select_shapes(robot: Robot, source_kind: str, sections: "MeshSections") -> _Selection:
    """Returns the links with the shapes that the configuration selects. Raises MeshError with each glob that
    matches nothing."""
    log = Diagnostics(optional=sections.optional)
    source_decides = robot.mjcf is not None
    links = [with_basis(link, source_kind, sections.mesh.basis, source_decides) for link in robot.links]
    choices = part_choices(links, sections, source_decides, log)
    excluded = chosen_pairs([link.name for link in links], sections.contact.exclude, log)
    fine_link_names = fine_links(sections.mesh.fine, links, log)
    if log.problems:
        raise MeshError("the configuration names links or parts that do not exist", problems=log.problems)
    # `part_choices` needs the shapes that `ignore` removes: its globs match them too.
    links = [with_shown_shapes(link, sections.ignore) for link in links]
    return _Selection(links, choices, excluded, fine_link_names, log.notes)


def _make_meshes(inputs: _Inputs, show_progress: "Shown | None") -> _MadeMeshes:
    """Makes the visual meshes and the colliders of all links."""
    robot, selection, sections, library, memo = inputs
    links, mesh_section, source_decides = selection.links, sections.mesh, robot.mjcf is not None
    min_size = mesh_section.min_size
    uses = link_uses.used_meshes(links, library, selection.choices, memo, min_size, source_decides)
    jobs = [job for link in links for job in uses[link.name].jobs(link.name)]
    # Visual meshes are made beside the colliders, which take longer.
    with ThreadPoolExecutor(1, thread_name_prefix="visuals") as pool:
        visuals_future = pool.submit(link_uses.link_visuals, uses, library, mesh_section, memo)
        made_colliders, false_pairs = _make_colliders(inputs, jobs, show_progress)
        return _MadeMeshes(uses, visuals_future.result(), made_colliders, false_pairs)


def _make_colliders(
    inputs: _Inputs, jobs: Sequence[ColliderJob], show_progress: "Shown | None"
) -> tuple[list[MadeCollider], Sequence[FalsePair]]:
    """Makes the colliders of all jobs; see `_MadeMeshes` for the order and the pairs."""
    robot, selection, sections, library, memo = inputs
    other_jobs = [job for job in jobs if not job.choice.by_contact]
    other_colliders = collide(other_jobs, library, memo, show_progress)
    contact_jobs = [job for job in jobs if job.choice.by_contact]
    fixed = fixed_pieces(selection.links, other_colliders)
    solid_links = {*fixed, *(job.link for job in contact_jobs)}
    excluded = excluded_pairs(robot, solid_links, sections.contact, selection.excluded_pairs)
    request = ContactRequest(robot, contact_jobs, fixed, excluded, selection.fine_link_names)
    collisions, false_pairs = by_contact(request, library, memo)
    contact_colliders = [
        MadeCollider(job, collision) for job, collision in zip(contact_jobs, collisions, strict=True)
    ]
    link_positions = {link.name: index for index, link in enumerate(selection.links)}
    # A stable sort: within a link, the order stays.
    made_colliders = [*other_colliders, *contact_colliders]
    return sorted(made_colliders, key=lambda collider: link_positions[collider.job.link]), false_pairs


def _contacts(
    inputs: _Inputs, shapes: Sequence[Shape], files: Mapping[str, bytes], figures: Sequence[ColliderFigures]
) -> Contacts:
    """Analyses the contact of the robot with itself. `figures`: those of all colliders."""
    mesh_section = inputs.sections.mesh
    # An exclude refers to shapes by their numbers, so only shapes that are written count.
    written_shapes = [shape for shape in shapes if shape.file is None or mesh_section.assets == "files"]
    return self_contacts(
        inputs.robot,
        written_shapes,
        files,
        inputs.sections.contact,
        memo=inputs.memo,
        chosen=inputs.selection.excluded_pairs,
        figures=figures,
        declared=mesh_section.basis == "declared",
    )


def _reports(
    inputs: _Inputs, made: _MadeMeshes, shapes: Sequence[Shape], files: Mapping[str, bytes], source_kind: str
) -> list[Diagnostic]:
    """Returns the reports on the configuration, the meshes and the colliders, but not on contacts and files.
    `files`: the meshes of the `shapes` by name."""
    _, selection, sections, library, _ = inputs
    links, targets = selection.links, sections.target.chosen
    findings = {link.name: link_uses.part_findings(link, made.uses[link.name]) for link in links}
    default = default_choice(sections.mesh, shape_limits(targets))
    makers = [default, *(choice.maker for choice in selection.choices.values())]
    colliders_with_parts = [(collider, made.parts_of(collider)) for collider in made.colliders]
    return [
        *diagnostics(links, made.visuals, findings),
        *selection.reports,
        *target_reports(links, colliders_with_parts, makers, shapes, sections.mesh, targets),
        *idle_key_reports(sections, {maker.how for maker in makers}, source_kind),
        *collider_reports(made.colliders),
        *false_contact_reports(made.false_pairs),
        *small_part_reports(link_uses.small_part_names(made.uses)),
        *com_reports(links, library.meshes_of_parts, shapes, files),
    ]


def _name_shapes(
    links: Sequence[Link], made: _MadeMeshes, limits: ShapeLimits
) -> tuple[dict[str, list[Shape]], dict[str, bytes]]:
    """Returns the shapes of each link, and the files of all meshes and colliders by name."""
    pieces_by_link = _pieces_by_link(links, made, limits)
    primitives_by_link = {
        link.name: [
            _ShapeWithMesh(shape, primitives.replacement_mesh(shape, limits))
            for shape in primitives.shapes(link)
        ]
        for link in links
    }
    counts = {
        link: _file_counts(made, link, pieces, primitives_by_link[link])
        for link, pieces in pieces_by_link.items()
    }
    names = file_names(counts)
    shapes_by_link: dict[str, list[Shape]] = {}
    files: dict[str, bytes] = {}
    for link, pieces in pieces_by_link.items():
        visual_names, collider_names = names[link]
        remaining_names = iter(collider_names)  # taken in the order of `_file_counts`
        link_shapes = [
            *(_collider_shape(link, piece, remaining_names, limits) for piece in pieces),
            *(
                _ShapeWithMesh(_mesh_shape(link, "visual", name, mesh), mesh)
                for name, mesh in zip(visual_names, made.visuals[link].files, strict=True)
            ),
            *(_primitive_shape(link, primitive, remaining_names) for primitive in primitives_by_link[link]),
        ]
        shapes_by_link[link] = [shape for shape, _ in link_shapes]
        files |= {shape.file: mesh.data for shape, mesh in link_shapes if shape.file and mesh}
    return shapes_by_link, dict(sorted(files.items()))


def _pieces_by_link(
    links: Sequence[Link], made: _MadeMeshes, limits: ShapeLimits
) -> dict[str, list[_ColliderPiece]]:
    """Returns the pieces of each link's colliders, in the order of the colliders."""
    pieces_by_link: dict[str, list[_ColliderPiece]] = {link.name: [] for link in links}
    for collider, index in zip(made.colliders, collider_indices(made.colliders), strict=True):
        parts = made.parts_of(collider)
        pieces_by_link[collider.job.link] += (
            _ColliderPiece(index, primitives.engine_solid(solid, limits), parts)
            for solid in colliders(collider.collision, collider.job.link_from_subject)
        )
    return pieces_by_link


def _collider_shape(
    link: str, piece: _ColliderPiece, remaining_names: Iterator[str], limits: ShapeLimits
) -> _ShapeWithMesh:
    """Returns the shape of a collider's piece; a mesh takes the next of the remaining file names."""
    if isinstance(piece.solid, MeshFile):
        mesh, shape = piece.solid, _mesh_shape(link, "collision", next(remaining_names), piece.solid)
    else:
        mesh, shape = None, primitives.collider(link, piece.solid)
    shape = replace(shape, collider=piece.collider_index)
    return _ShapeWithMesh(primitives.with_form(shape, piece.parts, limits), mesh)


def _primitive_shape(link: str, primitive: _ShapeWithMesh, remaining_names: Iterator[str]) -> _ShapeWithMesh:
    """Returns a link's own primitive, or the mesh that replaces it, with the next of the remaining names."""
    if primitive.mesh is None:
        return primitive
    shape = _mesh_shape(link, "collision", next(remaining_names), primitive.mesh)
    return _ShapeWithMesh(replace(shape, form=primitive.shape.form), primitive.mesh)


def _file_counts(
    made: _MadeMeshes, link: str, pieces: Sequence[_ColliderPiece], link_primitives: Sequence[_ShapeWithMesh]
) -> FileCounts:
    """Counts the files that a link needs. `link_primitives`: see `_primitive_shape`."""
    visuals = made.visuals[link]
    visual_words = part_words([made.uses[link].parts[index].name for index in visuals.owners])
    solids = (*(piece.solid for piece in pieces), *(primitive.mesh for primitive in link_primitives))
    collider_count = sum(isinstance(solid, MeshFile) for solid in solids)
    return FileCounts(visual_words or len(visuals.files), collider_count)


def _mesh_shape(link: str, role: Role, name: str, mesh: MeshFile) -> Shape:
    """Returns the shape of a mesh. `name`: its file name."""
    texture = textures.image_name(mesh.texture) if mesh.texture else None
    figures = mesh.vertices, mesh.faces, mesh.area, mesh.volume
    return Shape(link, role, name, mesh.colour, *figures, texture=texture, bounds=tuple(mesh.bounds))
