"""Reads the mesh files of a URDF: triangles, and the images of their colours.

- companions: Reads the files that a mesh file names: the materials of an OBJ, the buffers of a glTF, and the
  images of their materials.
- dae: Cleans a DAE: removes images, cameras, lights, and incomplete materials, which are not used here.
- gltf_materials: Reads the images of a glTF's materials, without an array library.
- images: Lists the images that a mesh file names for other purposes than colours, and all images of a DAE.
- loose_mesh: Defines the triangles of a mesh file, and converts them to a body.
- mesh_file: Reads triangles from mesh files: STL (binary and ASCII), OBJ, DAE, glTF and GLB, PLY, all but
  binary STL through trimesh.
- obj_materials: Reads the materials of an OBJ: finds the names of its MTL files, and parses these with their
  images.
- textures: Reads the images that give a mesh file its colours.
"""
