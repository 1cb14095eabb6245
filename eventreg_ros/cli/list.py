# SPDX-License-Identifier: Apache-2.0
"""``eventreg list``: the shipped scenarios, a line each."""

from __future__ import annotations

import argparse

from ..scenario.files import config_directory, shipped, summary


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add nothing: ``list`` has no arguments."""


def main(args: argparse.Namespace) -> int:
    """Print the scenarios and return 0."""
    names = shipped()
    width = max(map(len, names))
    for name in names:
        print(f'{name:<{width}}  {summary(name)}')
    print(f'\nThe files are in {config_directory()}; start with: eventreg new mine.yaml')
    return 0
