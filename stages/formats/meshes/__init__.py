"""Reads and writes mesh files as points and triangles: glTF, DAE, and the files that are written.

- body_arrays: Encodes and decodes the triangles of a part studio in their compact form: fetch stores it, and
  mesh reads it.
- components: Finds the connected components of a graph.
- corner_normals: Computes normals of a surface that is smooth where its faces meet at a small angle, and has
  an edge elsewhere.
- dae_points: Reads the points of the shapes that a COLLADA file (DAE) shows.
- faces: Reads the surfaces of the mesh files that are written, by index: binary STL and Wavefront OBJ.
- glb: Writes GLB files (binary glTF 2) that show a link: a mesh, with a part for each colour or image.
- gltf: Reads triangles from glTF 2 files, binary or as JSON with their buffers in them.
- gltf_claims: Checks the sizes that a glTF file claims against its content, before a library reads it.
- gltf_conventions: Converts between glTF's conventions and ours: colours in linear light, and the mark of a
  file of ours.
- points: Writes binary STL, and reads the points of the mesh files that are written: binary STL and Wavefront
  OBJ.
- surface: Defines triangle surfaces as arrays: welding, figures, canonical order.
"""
