"""Run the command line: ``python -m squama.cli``."""

import sys

from squama.cli import main

sys.exit(main())
