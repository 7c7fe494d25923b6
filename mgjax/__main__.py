"""``python -m mgjax``."""

import sys

from mgjax.cli import main

sys.exit(main())
