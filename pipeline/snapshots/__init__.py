"""Makes and compares snapshots of a repository's robots: texts about their results that are kept in git.

- subjects: Finds the robots and experiments of a repository.
- snapshot: Makes the snapshot of a subject: composes it, and builds its graph if no network is needed.
- figures: Takes the figures of a robot from a build that ends after the graph.
- text: Writes and reads the text of a snapshot.
- compare: Lists the differences of two snapshots, key by key.
- snapshot_folder: Checks and renews the snapshots in their folder; finds missing and left-over snapshots.
- command: Runs the command `linkwright snapshot`.
- offline: Makes any use of the network an error.
- pytest_items: Adds the tests that `pytest --linkwright` runs.
"""
