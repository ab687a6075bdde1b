"""Diagnostics of the mesh stage about missing, open and decimated meshes."""

from collections.abc import Mapping, Sequence

from linkwright.stages.mesh.link_mesh import PartFinding
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Link, MeshRef, Part
from linkwright.stages.robot.text.plural import count

_APART = 0.02
_SHOWN = 20

Found = Mapping[str, Sequence[tuple[Part, PartFinding]]]
"""Link → its parts, in order, and the finding of each."""


def diagnostics(links: Sequence[Link], visuals: Mapping[str, LinkVisuals], found: Found) -> list[Diagnostic]:
    """All findings, in the order of the links; `visuals` and `found` are by link name."""
    every = [pair for link in links for pair in found[link.name]]
    if every and not any(finding.found for _, finding in every):
        return [
            Diagnostic(
                "W-NO-MESH",
                f"no triangles for any of {count(len(every), 'part')}: the robot has no shapes",
                "source",
                "fetch it from Onshape, or use a bundle with triangles",
            )
        ]
    problems = [problem for link in links for problem in _missing(link, found[link.name])]
    return problems + _volumes(every) + _decimated(links, visuals)


def _missing(link: Link, found: Sequence[tuple[Part, PartFinding]]) -> list[Diagnostic]:
    names = sorted(part.name for part, finding in found if not finding.found)
    if not names:
        return []
    shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    return [
        Diagnostic(
            "W-NO-MESH",
            f"no triangles for {len(names)} of {count(len(found), 'part')}: {shown}",
            link.name,
            "check in Onshape that each is a solid without errors",
        )
    ]


def _decimated(links: Sequence[Link], visuals: Mapping[str, LinkVisuals]) -> list[Diagnostic]:
    """W-VISUAL-FACES for each link with more triangles than it may have, I-DECIMATED for all others that have
    fewer than their parts."""
    problems, fewer = [], []
    for link in links:
        decimation = visuals[link.name].decimation
        if decimation is None:
            continue
        if decimation.limited:
            faces = sum(file.faces for file in visuals[link.name].files)
            problems.append(
                Diagnostic(
                    "W-VISUAL-FACES",
                    f"the visual meshes have {faces} triangles (their parts {decimation.before}), more than "
                    "mesh.visual.max_faces: with fewer, the surface of a part would move by more than 0.2 mm "
                    "or 0.3 % of its diagonal, or its texture would shift",
                    link.name,
                    "simplify the meshes at their source, or raise mesh.visual.max_faces",
                )
            )
        else:
            moved = f"{1e3 * decimation.error:.2g} mm"
            fewer.append(f"{link.name} {decimation.before} → {decimation.after} ({moved})")
    if fewer:
        more = f" and {len(fewer) - _SHOWN} more" if len(fewer) > _SHOWN else ""
        problems.append(
            Diagnostic(
                "I-DECIMATED",
                f"the visual meshes of {count(len(fewer), 'link')} have fewer triangles than their parts; "
                f"their surfaces moved by at most the lengths here: {', '.join(fewer[:_SHOWN])}{more}",
                "mesh.visual.max_faces",
                "raise it for more detail",
            )
        )
    return problems


def _volumes(found: Sequence[tuple[Part, PartFinding]]) -> list[Diagnostic]:
    """Meshes whose volume is not CAD's: one finding for each mesh, at the first part that uses it."""
    seen: set[MeshRef] = set()
    problems = []
    for part, finding in found:
        if part.mesh is None or part.mesh in seen:
            continue
        seen.add(part.mesh)
        if not finding.volume or not part.volume:
            continue
        apart = abs(finding.volume - part.volume) / part.volume
        if apart > _APART:
            problems.append(
                Diagnostic(
                    "W-MESH-VOLUME",
                    f"the mesh encloses {finding.volume:.4g} m³, the part in CAD {part.volume:.4g} m³ "
                    f"({apart:.1%} apart)",
                    part.name,
                    "make source.tessellation.angle and .chord smaller",
                )
            )
    return problems
