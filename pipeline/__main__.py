"""`python -m pipeline` is `linkwright`."""

import sys

from pipeline.cli import main

sys.exit(main())
