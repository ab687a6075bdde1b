"""Files that nothing simulates, held against what a build would write again: fact by fact, not byte by byte.

facts         what a file says, whatever its format: places and values
xml_facts     of XML; tree_facts of YAML, TOML and JSON; python_facts of Python, which is not run;
              line_facts of CMake and of any other text
own           what of a package is for its user to set
amended       what the user's own XML changed in the files
compare       the differences between two files' facts
check         the checks of all files of a package
"""
