"""The reader of Onshape's documents: turns an assembly into a mechanism."""
