"""Builds the documentation as a site that opens from disk: `python -m docs.site`.

- pages: Says which files of the repository are pages, and rewrites their links.
- reference: Makes pages of what programs know: the command line and the Python API.
- robots: Builds the robots of the gallery, and makes the page of the gallery.
- pictures: Makes the pictures and the film in `docs/pictures`.
"""
