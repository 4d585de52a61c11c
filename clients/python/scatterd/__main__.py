"""python3 -m scatterd: the same as scatterd-client."""

import sys

from .command import main

sys.exit(main())
