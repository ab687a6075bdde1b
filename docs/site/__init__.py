"""Builds the documentation as a site that opens from disk: `python -m docs.site`.

- pages: Says which files of the repository are pages, and rewrites their links.
- reference: Makes pages of what programs know: the command line and the Python API.
- robots: Builds the robots of the gallery.
- pictures: Makes the pictures of the gallery's robots.
- views: Makes the pictures of the guide.
- summaries: Makes the pictures of the pages on sweeps.
- film: Makes the film of the live page.
"""
