"""The robot's geometry: each link's meshes and colliders, made once, then named."""

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from linkwright.stages.mesh.assets import written
from linkwright.stages.mesh.by_contact.build import by_contact, false_contacts
from linkwright.stages.mesh.by_contact.meeting import wanted
from linkwright.stages.mesh.by_contact.request import ContactRequest, FalsePair
from linkwright.stages.mesh.collide import primitives
from linkwright.stages.mesh.collide.choices import default_choice
from linkwright.stages.mesh.collide.collision import Collider, colliders
from linkwright.stages.mesh.collide.make import Collided, ColliderJob, collide
from linkwright.stages.mesh.collide.report import colliders_reported, figures_of
from linkwright.stages.mesh.com_check import unbalanced
from linkwright.stages.mesh.contact_parts import reported as too_small_reported
from linkwright.stages.mesh.contact_parts import with_basis
from linkwright.stages.mesh.contacts.analysis import self_contacts
from linkwright.stages.mesh.contacts.excluded_pairs import apart, chosen_pairs
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
from linkwright.stages.robot.bundle import Bundle
from linkwright.stages.robot.diagnostics import Diagnostics
from linkwright.stages.robot.errors import MeshError
from linkwright.stages.robot.model.geom_form import PLAIN
from linkwright.stages.robot.model.geometry import ColliderFigures, Geometry, Role, Shape
from linkwright.stages.robot.model.robot import Link, Part, Primitive, Robot
from linkwright.stages.robot.motion.adjacency import Pair

if TYPE_CHECKING:
    from linkwright.stages.mesh import Memo, Shown
    from linkwright.stages.mesh.section import MeshSection, MeshSections


_Piece = tuple[int, Collider, list[Part]]
"""Which of its link's colliders it is of, the piece, and the parts of that collider."""


def geometry(
    robot: Robot, bundle: Bundle, keys: "MeshSections", memo: "Memo", shown: "Shown | None" = None
) -> Geometry:
    """The shapes of all links. ProtocolError where triangles cannot be read, MeshError with each glob that
    matches nothing."""
    log = Diagnostics(optional=keys.optional)
    as_is = robot.mjcf is not None
    links = [with_basis(link, bundle.kind, keys.mesh.basis, as_is) for link in robot.links]
    chosen = part_choices(links, keys, as_is, log)
    links = [with_shown_shapes(link, keys.ignore) for link in links]
    excluded = chosen_pairs([link.name for link in links], keys.contact.exclude, log)
    fine = wanted(keys.mesh.fine, links, log)
    if log.problems:
        raise MeshError("the configuration names links or parts that are not there", problems=log.problems)
    library = MeshLibrary(links, bundle)
    used = used_meshes(links, library, chosen, memo, keys.mesh.min_size, as_is)
    jobs = [job for link in links for job in used[link.name].jobs(link.name)]
    pairs_of = partial(apart, robot, keys=keys.contact, chosen=excluded)
    with ThreadPoolExecutor(1, thread_name_prefix="visuals") as beside:
        making = beside.submit(link_visuals, used, library, keys.mesh, memo)
        collided, still_false = _collided(robot, links, jobs, pairs_of, fine, library, memo, shown)
        visuals = making.result()
    named, files = _named(links, used, visuals, collided, keys.mesh)
    files |= textures.images(visuals.values(), bundle)
    shapes = [shape for link in links for shape in named[link.name]]
    problems = diagnostics(links, visuals, {link.name: _found(link, used[link.name]) for link in links})
    problems += log.found
    makers = [default_choice(keys.mesh), *(one.maker for one in chosen.values())]
    problems += idle_keys(keys, {maker.how for maker in makers}, bundle.kind)
    problems += colliders_reported(collided)
    problems += false_contacts(still_false)
    problems += too_small_reported({name: one for name in used if (one := _small_names(used[name]))})
    problems += unbalanced(links, library.of_parts, shapes, files)
    figures, asked = list[ColliderFigures](), dict[tuple[str, int], PartChoice]()
    for made, number in zip(collided, _numbers(collided), strict=True):
        its = used[made.job.link]
        asked[made.job.link, number] = its.chosen[made.job.parts[0]]
        figures.append(figures_of(made, [its.parts[part].name for part in made.job.parts]))
    # Of those that are written: an exclude counts them.
    solid = [shape for shape in shapes if shape.file is None or keys.mesh.assets == "files"]
    contacts = self_contacts(
        robot, solid, files, keys.contact, memo, excluded, figures, keys.mesh.basis == "declared"
    )
    problems += contacts.diagnostics
    (written_shapes, assets), left_out = written(
        with_properties(shapes, asked, keys.geoms, contacts.by_source), files, keys.mesh
    )
    told = (*problems, *left_out)
    found = contacts.on, contacts.excludes, contacts.touching, tuple(figures), contacts.by_source
    return Geometry(written_shapes, assets, told, *found)


def _collided(
    robot: Robot,
    links: Sequence[Link],
    jobs: Sequence[ColliderJob],
    pairs_of: Callable[[Collection[str]], set[Pair] | None],
    fine: Collection[str] | None,
    library: MeshLibrary,
    memo: "Memo",
    shown: "Shown | None",
) -> tuple[list[Collided], Sequence[FalsePair]]:
    """The collider of each job, of a link in the order of its jobs, those by contact last; and the pairs of
    links whose colliders by contact touch where the links do not. `pairs_of`: see `apart`."""
    other = collide([job for job in jobs if not job.choice.by_contact], library, memo, shown)
    asking = [job for job in jobs if job.choice.by_contact]
    fixed: dict[str, list[Piece]] = {}
    for one in other:
        pieces = [placed(piece, one.job.link_from_subject) for piece in one.collision.pieces]
        fixed.setdefault(one.job.link, []).extend(pieces)
    for link in links:
        fixed.setdefault(link.name, []).extend(shape for shape in link.shapes if shape.collision)
    fixed = {link: pieces for link, pieces in fixed.items() if pieces}
    solid = {*fixed, *(job.link for job in asking)}
    found, false = by_contact(ContactRequest(robot, asking, fixed, pairs_of(solid), fine), library, memo)
    every = [*other, *(Collided(job, made) for job, made in zip(asking, found, strict=True))]
    place = {link.name: number for number, link in enumerate(links)}
    return sorted(every, key=lambda one: place[one.job.link]), false


def _with_form(shape: Shape, parts: Sequence[Part], section: "MeshSection") -> Shape:
    """A collider of these parts, as an MJCF source has the one of them. MJX collides no ellipsoid with a
    mesh."""
    form = parts[0].form if len(parts) == 1 else PLAIN
    if not form.ellipsoid or section.target == "mjx":
        return replace(shape, form=form)
    ellipsoid = Primitive("ellipsoid", form.ellipsoid, parts[0].link_from_part)
    return replace(shape, form=form, ellipsoid=ellipsoid)


def _found(link: Link, used: LinkUses) -> list[tuple[Part, PartFinding]]:
    lacking = [(part, PartFinding(False, None)) for part in link.parts if part.mesh is None]
    return [*zip(used.parts, used.known.findings, strict=True), *lacking]


def _small_names(used: LinkUses) -> list[str]:
    return [used.parts[index].name for index in used.small]


def _named(
    links: Sequence[Link],
    used: Mapping[str, LinkUses],
    visuals: Mapping[str, LinkVisuals],
    collided: Sequence[Collided],
    section: "MeshSection",
) -> tuple[dict[str, list[Shape]], dict[str, bytes]]:
    """The shapes of each link, and the files of its meshes and colliders by name."""
    solid: dict[str, list[_Piece]] = {link.name: [] for link in links}
    for one, number in zip(collided, _numbers(collided), strict=True):
        pieces = colliders(one.collision, one.job.link_from_subject)
        parts = [used[one.job.link].parts[index] for index in one.job.parts]
        solid[one.job.link] += ((number, _for_engine(piece, section), parts) for piece in pieces)
    own = {link.name: list(primitives.shapes(link)) for link in links}
    meshed = {name: [_meshed(shape, section) for shape in shapes] for name, shapes in own.items()}
    names = file_names(
        {name: _counts(used[name], visuals[name], solid[name], meshed[name]) for name in solid}
    )
    shapes: dict[str, list[Shape]] = {}
    files: dict[str, bytes] = {}
    for link, every in solid.items():
        visual_names, collider_names = names[link]
        shapes[link] = []
        free = iter(collider_names)
        for number, collider, parts in every:
            if isinstance(collider, MeshFile):
                name = next(free)
                shape = _shape(link, "collision", name, collider)
                files[name] = collider.data
            else:
                shape = primitives.collider(link, collider)
            shapes[link].append(_with_form(replace(shape, collider=number), parts, section))
        for name, file in zip(visual_names, visuals[link].files, strict=True):
            shapes[link].append(_shape(link, "visual", name, file))
            files[name] = file.data
        for shape, mesh in zip(own[link], meshed[link], strict=True):
            if mesh is None:
                shapes[link].append(shape)
            else:
                name = next(free)
                shapes[link].append(replace(_shape(link, "collision", name, mesh), form=shape.form))
                files[name] = mesh.data
    return shapes, dict(sorted(files.items()))


def _for_engine(collider: Collider, section: "MeshSection") -> Collider:
    """The collider as `mesh.target` can collide it: for MJX a cylinder is a prism."""
    if section.target != "mjx" or isinstance(collider, MeshFile) or collider.kind != "cylinder":
        return collider
    prism = primitives.prism(collider, section.max_vertices // 2)
    return collider if prism is None else mesh_file.collider(prism)


def _meshed(shape: Shape, section: "MeshSection") -> MeshFile | None:
    """The mesh in the place of a primitive that its link has itself; None where the primitive stays."""
    if shape.role == "visual" or shape.primitive is None:
        return None
    made = _for_engine(shape.primitive, section)
    return made if isinstance(made, MeshFile) else None


def _numbers(collided: Sequence[Collided]) -> list[int]:
    """Of each collider, which of its link's it is."""
    taken: Counter[str] = Counter()
    numbers = []
    for one in collided:
        numbers.append(taken[one.job.link])
        taken[one.job.link] += 1
    return numbers


def _counts(
    used: LinkUses, visuals: LinkVisuals, solid: Sequence[_Piece], meshed: Sequence[MeshFile | None]
) -> tuple[int | list[str], int]:
    """How many visual files a link has, or a word for each where each is of one part, and how many files
    of colliders."""
    words = part_words([used.parts[index].name for index in visuals.owners])
    files = [one for one in (*(piece for _, piece, _ in solid), *meshed) if isinstance(one, MeshFile)]
    return words or len(visuals.files), len(files)


def _shape(link: str, role: Role, name: str, file: MeshFile) -> Shape:
    texture = textures.name(file.texture) if file.texture else None
    own = file.vertices, file.faces, file.area, file.volume
    return Shape(link, role, name, file.colour, *own, texture=texture, bounds=tuple(file.bounds))
