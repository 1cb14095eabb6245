# SPDX-License-Identifier: Apache-2.0
"""The controller: a copy of the exosystem driven by y - y_r; publishes u (eq. s.I)."""

from __future__ import annotations

import sys

from .block import BlockNode
from .ros import run_node


def main() -> int:
    """Run the node until SIGINT or SIGTERM."""
    return run_node(lambda: BlockNode('controller'))


if __name__ == '__main__':
    sys.exit(main())
