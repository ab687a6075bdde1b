"""Examines for `linkwright doctor` whether builds can work on this computer, and how to repair them.

- access: Examines the API key, the network's settings, and Onshape itself.
- examination: Defines the result of examining one thing that builds need, and formats results as text or as a
  JSON document.
- installation: Examines Python, the packages, the extras, and whether MuJoCo runs.
- places: Examines the cache, the working folder, the free space, and the display.
"""
