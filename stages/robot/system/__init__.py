"""The operating system and Python: processes, memory, files and installed packages.

- garbage: Sets how often Python collects garbage in a process that builds.
- guest: Runs code that reads untrusted input in guest processes, within limits.
- guestmain: Starts a guest process (see `guest`).
- install: Finds the versions of installed packages, and the command that installs an optional package.
- process_usage: Measures the memory and processor time that a process uses.
- programs: Finds programs of the system, ignoring the working folder.
- regular_files: Files that an untrusted file names.
"""
