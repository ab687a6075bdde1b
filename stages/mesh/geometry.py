"""Makes the geometry of a robot: the meshes and colliders of each link, which are then given file names."""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

from linkwright.stages.mesh.assets import convert_assets
from linkwright.stages.mesh.by_contact.build import by_contact, false_contacts
from linkwright.stages.mesh.by_contact.meeting import fine_links
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair
from linkwright.stages.mesh.collide import primitives
from linkwright.stages.mesh.collide.choices import default_choice
from linkwright.stages.mesh.collide.collision import Collider, colliders
from linkwright.stages.mesh.collide.make import ColliderJob, MadeCollider, collide
from linkwright.stages.mesh.collide.report import collider_reports, figures_of
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
from linkwright.stages.robot.model.geometry import Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Link, Part, Primitive, Robot
from linkwright.stages.robot.motion.adjacency import Pair
from linkwright.stages.targets.engines import ShapeLimits, shape_limits

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown
    from linkwright.stages.mesh.section import MeshSections


class _ColliderPiece(NamedTuple):
    """A piece of a collider, in a form that the engines take."""

    collider_index: int
    """Index of the collider among the colliders of its link."""
    piece: Collider
    parts: list[Part]
    """Parts for which the collider was made."""


def build_geometry(
    robot: Robot, bundle: Bundle, keys: "MeshSections", memo: "Memo", shown: "Shown | None" = None
) -> Geometry:
    """Makes the shapes of all links. Raises ProtocolError if triangles cannot be read, and MeshError with
    each glob that matches nothing. `shown`: shows the progress of colliders."""
    log = Diagnostics(optional=keys.optional)
    limits = shape_limits(keys.target.chosen)
    source_decides = robot.mjcf is not None
    links = [with_basis(link, bundle.kind, keys.mesh.basis, source_decides) for link in robot.links]
    choices = part_choices(links, keys, source_decides, log)
    links = [with_shown_shapes(link, keys.ignore) for link in links]
    user_excludes = chosen_pairs([link.name for link in links], keys.contact.exclude, log)
    fine = fine_links(keys.mesh.fine, links, log)
    if log.problems:
        raise MeshError("the configuration names links or parts that do not exist", problems=log.problems)
    library = MeshLibrary(links, bundle)
    uses = used_meshes(links, library, choices, memo, keys.mesh.min_size, source_decides)
    jobs = [job for link in links for job in uses[link.name].jobs(link.name)]
    excluded_pairs_of = partial(excluded_pairs, robot, keys=keys.contact, chosen=user_excludes)
    # Visual meshes are made beside the colliders, which take longer.
    with ThreadPoolExecutor(1, thread_name_prefix="visuals") as pool:
        visuals_future = pool.submit(link_visuals, uses, library, keys.mesh, memo)
        made_colliders, false_pairs = _make_colliders(
            robot, links, jobs, excluded_pairs_of, fine, library, memo, shown
        )
        visuals = visuals_future.result()
    shapes_by_link, files = _name_shapes(links, uses, visuals, made_colliders, limits)
    files |= textures.images(visuals.values(), bundle)
    shapes = [shape for link in links for shape in shapes_by_link[link.name]]
    reports = diagnostics(links, visuals, {link.name: _findings(link, uses[link.name]) for link in links})
    reports += log.found
    makers = [default_choice(keys.mesh, limits), *(choice.maker for choice in choices.values())]
    colliders_with_parts = [(made, _parts_of(made, uses)) for made in made_colliders]
    reports += reshaped(links, colliders_with_parts, makers, shapes, keys.mesh, keys.target.chosen)
    reports += idle_keys(keys, {maker.how for maker in makers}, bundle.kind)
    reports += collider_reports(made_colliders)
    reports += false_contacts(false_pairs)
    reports += too_small_reported(_small_part_names(uses))
    reports += com_outside_hull(links, library.meshes_of_parts, shapes, files)
    figures = [figures_of(made, [part.name for part in parts]) for made, parts in colliders_with_parts]
    # An exclude refers to shapes by their numbers, so only shapes that are written count.
    written = [shape for shape in shapes if shape.file is None or keys.mesh.assets == "files"]
    declared = keys.mesh.basis == "declared"
    contacts = self_contacts(robot, written, files, keys.contact, memo, user_excludes, figures, declared)
    reports += contacts.diagnostics
    choice_of = _choices_by_collider(made_colliders, uses)
    contact_shapes = with_properties(shapes, choice_of, keys.geoms, contacts.by_source)
    (final_shapes, assets), left_out = convert_assets(contact_shapes, files, keys.mesh, obj_only=limits.obj)
    result = Geometry(
        final_shapes,
        assets,
        (*reports, *left_out),
        self_contact=contacts.on,
        excludes=contacts.excludes,
        touching=contacts.touching,
        colliders=tuple(figures),
        by_source=contacts.by_source,
    )
    return with_glb(result, shapes_by_link, keys.mesh.glb_up) if keys.mesh.format == "glb" else result


def _make_colliders(
    robot: Robot,
    links: Sequence[Link],
    jobs: Sequence[ColliderJob],
    excluded_pairs_of: Callable[[Collection[str]], set[Pair] | None],
    fine_names: Collection[str] | None,
    library: MeshLibrary,
    memo: "Memo",
    shown: "Shown | None",
) -> tuple[list[MadeCollider], Sequence[FalsePair]]:
    """Makes the colliders of all jobs.

    Returns them link by link, the colliders by contact last in each link, and the pairs of links whose
    colliders by contact touch where the links do not. `excluded_pairs_of`: returns the pairs of some solid
    links that need not be kept apart, see `excluded_pairs`; `fine_names`: see `ContactRequest.fine`.
    """
    other_colliders = collide([job for job in jobs if not job.choice.by_contact], library, memo, shown)
    contact_jobs = [job for job in jobs if job.choice.by_contact]
    fixed_pieces: dict[str, list[Piece]] = {}
    for made in other_colliders:
        pieces = [placed(piece, made.job.link_from_subject) for piece in made.collision.pieces]
        fixed_pieces.setdefault(made.job.link, []).extend(pieces)
    for link in links:
        fixed_pieces.setdefault(link.name, []).extend(shape for shape in link.shapes if shape.collision)
    fixed_pieces = {link: pieces for link, pieces in fixed_pieces.items() if pieces}
    solid_links = {*fixed_pieces, *(job.link for job in contact_jobs)}
    request = ContactRequest(robot, contact_jobs, fixed_pieces, excluded_pairs_of(solid_links), fine_names)
    collisions, false_pairs = by_contact(request, library, memo)
    contact_colliders = [
        MadeCollider(job, collision) for job, collision in zip(contact_jobs, collisions, strict=True)
    ]
    position = {link.name: index for index, link in enumerate(links)}
    # A stable sort: within a link, the order stays.
    made_colliders = [*other_colliders, *contact_colliders]
    return sorted(made_colliders, key=lambda made: position[made.job.link]), false_pairs


def _parts_of(made: MadeCollider, uses_by_link: Mapping[str, LinkUses]) -> list[Part]:
    """Returns the parts for which a collider was made."""
    uses = uses_by_link[made.job.link]
    return [uses.parts[index] for index in made.job.parts]


def _choices_by_collider(
    made_colliders: Sequence[MadeCollider], uses_by_link: Mapping[str, LinkUses]
) -> dict[tuple[str, int], PartChoice]:
    """Returns the choice for the first part of each collider, by link and index of the collider in it. Parts
    that share a collider have the same choice of contact."""
    return {
        (made.job.link, index): uses_by_link[made.job.link].choices[made.job.parts[0]]
        for made, index in zip(made_colliders, _collider_indices(made_colliders), strict=True)
    }


def _with_form(shape: Shape, parts: Sequence[Part], limits: ShapeLimits) -> Shape:
    """Returns a collider with the form of its part's MJCF geom; the form is plain if several `parts` share
    the collider. A mesh of an ellipsoid also gets the ellipsoid, if all targets can collide it."""
    form = parts[0].form if len(parts) == 1 else PLAIN
    if not form.ellipsoid or "ellipsoid" in limits.without:
        return replace(shape, form=form)
    ellipsoid = Primitive("ellipsoid", form.ellipsoid, parts[0].link_from_part)
    return replace(shape, form=form, ellipsoid=ellipsoid)


def _findings(link: Link, uses: LinkUses) -> list[tuple[Part, PartFinding]]:
    """Returns all parts of a link with the findings about their meshes, parts without a mesh last."""
    without_mesh = [(part, PartFinding(found=False, volume=None)) for part in link.parts if part.mesh is None]
    return [*zip(uses.parts, uses.link_parts.findings, strict=True), *without_mesh]


def _small_part_names(uses_by_link: Mapping[str, LinkUses]) -> dict[str, list[str]]:
    """Returns the names of the parts that are too small for a collider, for each link that has such parts."""
    return {
        link: [uses.parts[index].name for index in uses.small]
        for link, uses in uses_by_link.items()
        if uses.small
    }


def _name_shapes(
    links: Sequence[Link],
    uses_by_link: Mapping[str, LinkUses],
    visuals: Mapping[str, LinkVisuals],
    made_colliders: Sequence[MadeCollider],
    limits: ShapeLimits,
) -> tuple[dict[str, list[Shape]], dict[str, bytes]]:
    """Returns the shapes of each link, and the files of all meshes and colliders by name."""
    pieces_by_link: dict[str, list[_ColliderPiece]] = {link.name: [] for link in links}
    for made, index in zip(made_colliders, _collider_indices(made_colliders), strict=True):
        parts = _parts_of(made, uses_by_link)
        pieces_by_link[made.job.link] += (
            _ColliderPiece(index, _for_engine(piece, limits), parts)
            for piece in colliders(made.collision, made.job.link_from_subject)
        )
    primitive_shapes = {link.name: list(primitives.shapes(link)) for link in links}
    replacements = {
        link: [_replacement_mesh(shape, limits) for shape in shapes]
        for link, shapes in primitive_shapes.items()
    }
    names = file_names(
        {
            link: _file_counts(uses_by_link[link], visuals[link], pieces, replacements[link])
            for link, pieces in pieces_by_link.items()
        }
    )
    shapes: dict[str, list[Shape]] = {}
    files: dict[str, bytes] = {}
    for link, pieces in pieces_by_link.items():
        visual_names, collider_names = names[link]
        shapes[link] = []
        next_names = iter(collider_names)
        for index, piece, parts in pieces:
            if isinstance(piece, MeshFile):
                name = next(next_names)
                shape = _mesh_shape(link, "collision", name, piece)
                files[name] = piece.data
            else:
                shape = primitives.collider(link, piece)
            shapes[link].append(_with_form(replace(shape, collider=index), parts, limits))
        for name, file in zip(visual_names, visuals[link].files, strict=True):
            shapes[link].append(_mesh_shape(link, "visual", name, file))
            files[name] = file.data
        for shape, mesh in zip(primitive_shapes[link], replacements[link], strict=True):
            if mesh is None:
                shapes[link].append(shape)
            else:
                name = next(next_names)
                shapes[link].append(replace(_mesh_shape(link, "collision", name, mesh), form=shape.form))
                files[name] = mesh.data
    return shapes, dict(sorted(files.items()))


def _for_engine(piece: Collider, limits: ShapeLimits) -> Collider:
    """Returns the piece, or a prism of equal volume instead of a cylinder that a target cannot collide."""
    if isinstance(piece, MeshFile) or piece.kind != "cylinder" or "cylinder" not in limits.without:
        return piece
    prism = primitives.prism(piece)
    return piece if prism is None else mesh_file.collider(prism)


def _replacement_mesh(shape: Shape, limits: ShapeLimits) -> MeshFile | None:
    """Returns the mesh that replaces a primitive of the link itself; None if the primitive stays."""
    if shape.role == "visual" or shape.primitive is None:
        return None
    piece = _for_engine(shape.primitive, limits)
    return piece if isinstance(piece, MeshFile) else None


def _collider_indices(made_colliders: Sequence[MadeCollider]) -> list[int]:
    """Returns the index of each collider among the colliders of its link."""
    counts: Counter[str] = Counter()
    indices = []
    for made in made_colliders:
        indices.append(counts[made.job.link])
        counts[made.job.link] += 1
    return indices


def _file_counts(
    uses: LinkUses,
    visuals: LinkVisuals,
    pieces: Sequence[_ColliderPiece],
    replacements: Sequence[MeshFile | None],
) -> tuple[int | list[str], int]:
    """Returns the number of a link's visual files, or a word for each if each belongs to one part; and the
    number of its collider files."""
    words = part_words([uses.parts[index].name for index in visuals.owners])
    collider_files = [
        file for file in (*(piece.piece for piece in pieces), *replacements) if isinstance(file, MeshFile)
    ]
    return words or len(visuals.files), len(collider_files)


def _mesh_shape(link: str, role: Role, name: str, file: MeshFile) -> Shape:
    """Returns the shape of a mesh file. `name`: its file name."""
    texture = textures.image_name(file.texture) if file.texture else None
    figures = file.vertices, file.faces, file.area, file.volume
    return Shape(link, role, name, file.colour, *figures, texture=texture, bounds=tuple(file.bounds))
