"""Compares files that nothing simulates with the files that a build would write, by facts instead of bytes.

- amended: Recognizes differences that come from the keys `elements` and `attributes`.
- check: Checks the files that are written from others, by comparing each with what a build would write.
- compare: Finds the differences between a file and what a build writes in its place.
- facts: Defines facts, which are the content of a file: a value at each place.
- line_facts: Reads the facts of CMake, command by command, and of any other text, line by line.
- python_facts: Reads the facts of a Python module, which is parsed and never run: constants, and statements
  of functions.
- tree_facts: Reads YAML, TOML and JSON files as facts: pairs of a place (the path of keys) and a value.
- user_settings: Lists the facts of a package that its user may set, since a build writes only first values.
- xml_facts: Reads the facts of XML. The name of a material is not a fact, but its place in the order of
  materials is.
"""
