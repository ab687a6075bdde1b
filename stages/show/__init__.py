"""What is shown of a robot: its live view, its picture, its tree. Imports no stage; a stage may import it.

- clusters: Points of one cell of a grid as one point.
- decimate: A surface with fewer triangles, its colours and the borders between them kept together.
- graph_view: The views of the value `Robot`: a tree of text, a picture, tables.
- live: What the page shows of a robot that lives in it: the pack, made from the files of a build.
- preview: The robot's picture, drawn by the processor alone.
- raster: Triangles as pixels: each point of the picture shows what is nearest to the viewer.
"""
