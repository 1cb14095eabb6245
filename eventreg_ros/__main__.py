"""``python -m eventreg_ros`` is ``eventreg``."""

import sys

from .cli.main import main

if __name__ == '__main__':
    sys.exit(main())
