"""A Python package: the files of the other formats, as pip installs them."""

from stages.export.writer import Exported, WriterInput

FOLDER = "python"
"""Where the package lies in the output."""


class PythonWriter:
    """`python/`."""

    reads: tuple[str, ...] = ("urdf", "mjcf")
    modules: tuple[str, ...] = ("stages.export.python.package",)

    def paths(self, robot: str) -> tuple[str, ...]:
        return (f"{FOLDER}/*",)

    def write(self, given: WriterInput) -> Exported:
        """Its files, with copies of all that the other formats have, and of robot.json."""
        from stages.export.package_names import package_of
        from stages.export.python.keys import PythonFormatKeys, module_of
        from stages.export.python.package import module, pyproject, readme

        robot = given.robot.name
        keys = given.keys.export.python or PythonFormatKeys()
        package = keys.package or package_of(robot)
        urdf = given.keys.export.urdf
        # Who looks for package:// looks for a folder of that name.
        in_package = urdf is not None and urdf.meshes == "package"
        folder = (urdf.package if urdf is not None and in_package else None) or robot
        own = module_of(package)
        data = {f"{own}/{folder}/{path}": text for path, text in given.files.items()}
        files = {
            "pyproject.toml": pyproject(package, robot, keys),
            "README.md": readme(package, robot, given.files),
            f"{own}/__init__.py": module(package, robot, folder, keys.version, given.files),
            f"{own}/py.typed": b"",
            **data,
        }
        return Exported({f"{FOLDER}/{path}": text for path, text in files.items()})


WRITER = PythonWriter()
