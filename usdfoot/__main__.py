"""python -m usdfoot: the usdfoot command where its script is not on the path."""

import sys

from usdfoot.cli.main import main

sys.exit(main())
