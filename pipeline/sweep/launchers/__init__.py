"""Does what launchers of Hydra leave undone: shares processors among jobs, and handles killed jobs."""
