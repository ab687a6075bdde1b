"""An assembly of an Onshape server, or the replies recorded of one, as a bundle."""
