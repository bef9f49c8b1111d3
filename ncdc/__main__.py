"""``python -m ncdc``: the command without its script, as where that is not on the PATH."""

import sys

from ncdc.cli import main

sys.exit(main())
