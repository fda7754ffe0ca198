"""``python -m glasshelm``."""

import sys

from glasshelm.cli import main

sys.exit(main())
