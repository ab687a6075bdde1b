"""The reader of Onshape's documents: an assembly as drawn becomes a mechanism."""
