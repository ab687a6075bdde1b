"""HTTP to an Onshape server: authenticated, counted, patient within bounds."""
