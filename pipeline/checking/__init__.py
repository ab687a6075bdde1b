"""Checks of files that are there already: which are made, and how their results are told.

- as_json: The verdict of checks as JSON for programs, and such JSON as a baseline.
- ask: Asks the guest that checks files, within limits of time and memory.
- guest: Guest process that checks files of any origin: some crash what reads them, or exhaust time and
  memory.
- junit: The verdict of checks as JUnit XML, in the form that pytest writes.
- lines: The lines of elements in the files of a folder.
- packages: The checks of a build's packages, which `stages.export` writes again from what lies beside them.
- run: Makes the checks of a folder or a file, against its robot.json or, without one, by themselves.
- sarif: The verdict of checks as SARIF 2.1.0, which code hosts show beside the lines of a pull request.
- show: The verdict of checks as text.
- verdict: The results of the checks of a folder or file, and which of them fail.
- wire: A verdict as JSON, and back: what the guest that checks replies with.
"""
