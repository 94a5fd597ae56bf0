"""``python -m jtik``: the command line."""

import sys

from jtik.cli import main

if __name__ == "__main__":
    sys.exit(main())
