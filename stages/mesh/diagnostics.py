"""Diagnostics of the mesh stage about missing, flat and open meshes."""

from collections.abc import Mapping, Sequence

from stages.mesh.link_mesh import Finding, LinkMesh
from stages.robot.errors import Diagnostic
from stages.robot.model import Link, MeshRef, Part
from stages.robot.plural import count

_APART = 0.02

Found = Mapping[str, Sequence[tuple[Part, Finding]]]
"""Link → its parts, in order, and the finding of each."""


def diagnostics(
    links: Sequence[Link], meshes: Mapping[str, LinkMesh], found: Found, collider: str
) -> list[Diagnostic]:
    """All findings, in the order of the links; `meshes` and `found` are by link name. `collider`: what makes
    the colliders."""
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
    problems = []
    for link in links:
        problems += _missing(link, found[link.name])
        collides = any(part.collides and finding.found for part, finding in found[link.name])
        if collides and collider != "visual" and not meshes[link.name].colliders:
            problems.append(
                Diagnostic(
                    "W-FLAT",
                    "the link is flat, so it has no convex hull and no collider",
                    link.name,
                    "give it thickness in CAD",
                )
            )
    return problems + _volumes(every) + _raw(meshes, collider)


def _missing(link: Link, found: Sequence[tuple[Part, Finding]]) -> list[Diagnostic]:
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


def _raw(meshes: Mapping[str, LinkMesh], collider: str) -> list[Diagnostic]:
    """I-RAW where links collide by the meshes of their parts."""
    files = sum(len(mesh.colliders) for mesh in meshes.values())
    if collider != "raw" or not files:
        return []
    return [
        Diagnostic(
            "I-RAW",
            f"{count(files, 'mesh', 'meshes')} of parts serve as colliders as they are; MuJoCo takes the "
            "convex hull of each, which fills its hollows",
            "mesh.collider",
            "choose another mesh option where hollows matter",
        )
    ]


def _volumes(found: Sequence[tuple[Part, Finding]]) -> list[Diagnostic]:
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
