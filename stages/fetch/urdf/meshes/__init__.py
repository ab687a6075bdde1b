"""The mesh files of a URDF: triangles, and the images of their colours.

- companions: The files that a mesh file names: an OBJ's materials, a glTF's buffers, the images of their
  colours.
- dae: Cleans a DAE: removes images, cameras, lights, and incomplete materials, which are not used here.
- gltf_materials: The images of a glTF's materials.
- images: The images that a mesh file names for other things than colours (reliefs, shine), and all of a DAE.
- loose_mesh: The triangles of a mesh file, and the body that they become.
- mesh_file: Reads triangles from mesh files: STL (binary and ASCII), OBJ, DAE, glTF and GLB, PLY, all but
  binary STL through trimesh.
- obj_materials: The materials of an OBJ: the libraries (MTL) that it names, and the images that these name.
- textures: The images that give a mesh file its colours.
"""
