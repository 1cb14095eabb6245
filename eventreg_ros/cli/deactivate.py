# SPDX-License-Identifier: Apache-2.0
"""``eventreg deactivate NODE``: switch a node of the running loop off; its output goes to 0."""

from __future__ import annotations

import argparse

from .switch import add_node, switch


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``deactivate``."""
    add_node(parser)


def main(args: argparse.Namespace) -> int:
    """Do it and return 0."""
    return switch(args.node, 'deactivate')
