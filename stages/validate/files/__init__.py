"""Checks of the text of model files: what a reader of XML sees before any engine runs.

- assets: Every file that the model names is there, and whole.
- known: Every element and attribute is one of the format's: readers skip a misspelled one, or refuse the
  file.
- model_config: The file by which Gazebo finds the SDF of a folder.
- names: Every name is legal, and unique where the format asks: a link and a joint may share one.
- numbers: Every number is one, finite, and there are as many as the attribute has.
- paths: Every file is named by a path that holds wherever the folder is: relative, and within it.
- references: Every name that an element refers to is there: links, joints, classes, materials, meshes, sites,
  bodies.
- run: The run of the checks of files: of each model in a folder, and of what lies beside them.
- unused: Every file in the folder of assets is one that a model names.
- urdf_schema: The elements and attributes of URDF: those of ROS's reference, and what later readers add.
- whole: Whether a mesh or an image is whole: an empty file, or a copy that was cut short.
"""

from linkwright.stages.validate.files import assets, known, names, numbers, paths, references
from linkwright.stages.validate.rows import TextCheck

TEXT_CHECKS = (
    TextCheck("C-XML-KNOWN", "elements", known.findings, "every element and attribute is known", known.level),
    TextCheck("C-NAME", "names", names.findings, "every name is legal, and unique among its kind"),
    TextCheck("C-NUMBER", "numbers", numbers.findings, "every number is finite, and where it belongs"),
    TextCheck(
        "C-REFERENCE",
        "references",
        references.findings,
        "every name that is referred to is there",
        references.level,
    ),
    TextCheck("C-ASSET", "assets", assets.findings, "every file that is named is there, and whole"),
    TextCheck(
        "C-PATH",
        "paths",
        paths.findings,
        "every path is relative, and leads to a file of this folder or of a package that is here",
        paths.level,
    ),
)
"""In the order of the report."""
