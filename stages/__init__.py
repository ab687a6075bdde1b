"""What a build does: fetch, graph, mesh, export, validate. Knows no Hydra."""
