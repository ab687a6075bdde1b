"""Files that nothing simulates, held against what a build would write again: fact by fact, not byte by byte.

facts         what a file says, whatever its format: places and values
xml_facts     of XML; tree_facts of YAML, TOML and JSON; python_facts of Python, which is not run;
              line_facts of CMake and of any other text
own           what of a package is for its user to set
amended       what the user's own XML changed in the files
compare       the differences between two files' facts
check         the checks of all files of a package

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
