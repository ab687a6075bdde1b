"""`python -m tests.docs.show PAGE`: runs the blocks of a page, and prints each command and its output."""

import sys
import tempfile
from pathlib import Path

from tests.docs.blocks import blocks
from tests.docs.session import Session
from tests.support import kept_colliders


def main(page):
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder) / "cache"
        kept_colliders.seed(cache)
        with Session(Path(folder), cache) as session:
            for block in blocks(page):
                if (output := session.run(block)) is not None:
                    print(f"--- {block.place}\n{block.text}--- prints\n{output}")


if __name__ == "__main__":
    main(sys.argv[1])
