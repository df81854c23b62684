"""Run the command line: ``python -m squama``."""

import sys

from squama.cli import main

sys.exit(main())
