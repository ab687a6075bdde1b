"""The output folder: what is ours in it, what is the user's, and how one build replaces another."""
