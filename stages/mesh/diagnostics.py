"""Reports meshes that are missing, were decimated, or enclose another volume than their CAD part."""

from collections.abc import Mapping, Sequence

from linkwright.stages.mesh.link_mesh import PartFinding
from linkwright.stages.mesh.visuals.make import LinkVisuals
from linkwright.stages.robot.errors import Diagnostic
from linkwright.stages.robot.model.robot import Link, MeshRef, Part
from linkwright.stages.robot.text.plural import count

_MAX_VOLUME_DIFFERENCE = 0.02
"""Largest difference between the volumes of a mesh and its CAD part that is not reported, as a share."""

_MAX_LISTED = 20
"""Largest number of links that a diagnostic lists."""

Findings = Mapping[str, Sequence[tuple[Part, PartFinding]]]
"""Link → its parts, in order, each with its finding."""


def diagnostics(
    links: Sequence[Link], visuals: Mapping[str, LinkVisuals], findings: Findings
) -> list[Diagnostic]:
    """Returns all diagnostics, in the order of the links; `visuals` and `findings` are by link name."""
    pairs = [pair for link in links for pair in findings[link.name]]
    if pairs and not any(finding.found for _, finding in pairs):
        return [
            Diagnostic(
                "W-NO-MESH",
                f"no triangles for any of {count(len(pairs), 'part')}: the robot has no shapes",
                "source",
                "fetch it from Onshape, or use a bundle with triangles",
            )
        ]
    problems = [problem for link in links for problem in _missing_mesh_reports(link, findings[link.name])]
    return problems + _volume_reports(pairs) + _decimation_reports(links, visuals)


def _missing_mesh_reports(link: Link, findings: Sequence[tuple[Part, PartFinding]]) -> list[Diagnostic]:
    names = sorted(part.name for part, finding in findings if not finding.found)
    if not names:
        return []
    name_text = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
    return [
        Diagnostic(
            "W-NO-MESH",
            f"no triangles for {len(names)} of {count(len(findings), 'part')}: {name_text}",
            link.name,
            "check in Onshape that each is a solid without errors",
        )
    ]


def _decimation_reports(links: Sequence[Link], visuals: Mapping[str, LinkVisuals]) -> list[Diagnostic]:
    """Reports W-VISUAL-FACES for each link with more triangles than it may have, and I-DECIMATED once for all
    other links with fewer triangles than their parts."""
    problems, entries = [], []
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
            error_in_mm = f"{1e3 * decimation.error:.2g} mm"
            entries.append(f"{link.name} {decimation.before} → {decimation.after} ({error_in_mm})")
    if entries:
        more = f" and {len(entries) - _MAX_LISTED} more" if len(entries) > _MAX_LISTED else ""
        problems.append(
            Diagnostic(
                "I-DECIMATED",
                f"the visual meshes of {count(len(entries), 'link')} have fewer triangles than their parts; "
                f"their surfaces moved by at most the lengths here: {', '.join(entries[:_MAX_LISTED])}{more}",
                "mesh.visual.max_faces",
                "raise it for more detail",
            )
        )
    return problems


def _volume_reports(findings: Sequence[tuple[Part, PartFinding]]) -> list[Diagnostic]:
    """Reports W-MESH-VOLUME once for each mesh of another volume than CAD's, at the first part that uses
    it."""
    reported_meshes: set[MeshRef] = set()
    problems = []
    for part, finding in findings:
        if part.mesh is None or part.mesh in reported_meshes:
            continue
        reported_meshes.add(part.mesh)
        if not finding.volume or not part.volume:
            continue
        difference = abs(finding.volume - part.volume) / part.volume
        if difference > _MAX_VOLUME_DIFFERENCE:
            problems.append(
                Diagnostic(
                    "W-MESH-VOLUME",
                    f"the mesh encloses {finding.volume:.4g} m³, the part in CAD {part.volume:.4g} m³ "
                    f"({difference:.1%} apart)",
                    part.name,
                    "make source.tessellation.angle and .chord smaller",
                )
            )
    return problems
