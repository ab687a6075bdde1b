"""The robots of the gallery: `python -m tests.fake_onshape.gallery` writes the bundles that are shipped."""

from pathlib import Path

from tests.fake_onshape.bundle import bundle_bytes
from tests.fake_onshape.delta import delta_document
from tests.fake_onshape.hand import hand_document
from tests.fake_onshape.quadruped import quadruped_document
from tests.fake_onshape.rover import rover_document
from tests.fake_onshape.sample import sample_document

FOLDER = Path(__file__).resolve().parents[2] / "stages" / "fetch" / "bundle" / "sample"

DOCUMENTS = {
    "sample": sample_document,
    "quadruped": quadruped_document,
    "delta": delta_document,
    "rover": rover_document,
    "hand": hand_document,
}
"""Name → the function that makes its document."""


def main():
    """Writes each robot's bundle and prints its size."""
    for name, document in DOCUMENTS.items():
        path = FOLDER / f"{name}.zip"
        path.write_bytes(bundle_bytes(document()))
        print(f"{path.name}: {path.stat().st_size} bytes")


if __name__ == "__main__":
    main()
