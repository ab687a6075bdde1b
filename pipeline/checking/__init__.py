"""Checks existing files, and shows the results.

- as_document: Makes the document of a verdict of checks, and reads such a document as a baseline.
- ask: Asks the guest process to check files, within limits of time and memory.
- guest: Checks files of any origin in a process of its own: some crash their reader, or exhaust time and
  memory.
- junit: Writes the verdict of checks as JUnit XML, in the form of pytest.
- lines: Finds the lines of elements in the files of a folder.
- packages: Checks a build's packages: `stages.export` writes them again from the files beside them.
- run: Checks a folder or a file against its robot.json or, without robot.json, against itself.
- sarif: Writes the verdict of checks as SARIF 2.1.0, which code hosts show in a pull request.
- show: Shows the verdict of checks as text.
- verdict: Judges the results of the checks of a folder or file: which of them fail.
- wire: Converts a verdict to JSON and back: the reply of the guest process.
"""
