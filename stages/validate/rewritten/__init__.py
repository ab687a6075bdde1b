"""Files that nothing simulates, held against what a build would write again: fact by fact, not byte by byte.

- amended: What the configuration's own XML changed in a file that a build would write again without it.
- check: The checks of files that are written from others: each says what a build would write again.
- compare: The differences between a file and what a build writes in its place.
- facts: What a file says, as facts: a value at each place.
- line_facts: The facts of CMake, command by command, and of any other text, line by line.
- own: What of a package is for its user to set: what a build writes there is a start.
- python_facts: The facts of a Python module, which is read and never run: its constants, value by value, and
  the statements of its functions.
- tree_facts: The facts of YAML, TOML and JSON: values by their keys.
- xml_facts: The facts of XML.
"""
