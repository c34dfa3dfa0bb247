"""`python -m tolman.scripts.cli` is the command `tolman`."""

import sys

from .program import main

sys.exit(main())
