"""``python -m adaptive_fairing``: the same as the command ``adaptive-fairing``."""

import sys

from .cli import main

sys.exit(main())
