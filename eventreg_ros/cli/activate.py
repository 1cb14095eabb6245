# SPDX-License-Identifier: Apache-2.0
"""``eventreg activate NODE``: switch a node of the running loop on; it starts from x0."""

from __future__ import annotations

import argparse

from .switch import add_node, switch


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``activate``."""
    add_node(parser)


def main(args: argparse.Namespace) -> int:
    """Do it and return 0."""
    return switch(args.node, 'activate')
