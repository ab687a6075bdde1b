"""Checks the text of model files, before any engine runs.

- assets: Checks that every file that a model refers to exists and is complete.
- damage: Finds damaged meshes and images: empty files, and truncated copies.
- model_config: Checks model.config, by which Gazebo finds the SDF of a folder.
- names: Checks that every name is legal, and unique if the format requires it: a link and a joint may share a
  name.
- numbers: Checks that every number is finite, and that each attribute has the right count of numbers.
- paths: Checks that paths of files stay valid if the folder moves: they are relative, and stay within the
  folder.
- references: Checks that every name that an element refers to exists: links, joints, classes, materials,
  meshes, bodies.
- run: Runs the checks of files: of each model in a folder, and of the folder's other files.
- unused: Checks that every file in the folder of assets is named by a model.
- urdf_schema: Lists the elements and attributes of URDF, from ROS's reference and from later readers.
- vocabulary: Checks that elements and attributes are the format's: readers skip misspelled names, or refuse
  the file.
"""

from linkwright.stages.validate.files import assets, names, numbers, paths, references, vocabulary
from linkwright.stages.validate.rows import TextCheck

TEXT_CHECKS = (
    TextCheck(
        "C-XML-KNOWN",
        "elements",
        vocabulary.findings,
        "every element and attribute is known",
        vocabulary.level,
    ),
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
"""The checks in the order of the report."""
