"""``python -m latolato`` is the command ``latolato``."""

import sys

from latolato_command import main

if __name__ == "__main__":
    sys.exit(main())
