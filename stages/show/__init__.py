"""Makes the views of a robot: its live view, its picture, its tree. Imports no stage; a stage may import it.

- clusters: Merges the points in each cell of a grid.
- decimate: Simplifies a surface, and keeps the borders between its colours closed.
- graph_view: Draws the views of the value `Robot` for people: an outline, tables, and a picture.
- live: Makes the pack of a page's live view of a robot from the files of a build.
- preview: Draws the robot's picture on the processor, without a graphics card.
- raster: Rasterizes triangles: each pixel shows the triangle nearest to the viewer.
"""
