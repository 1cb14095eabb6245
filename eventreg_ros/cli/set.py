# SPDX-License-Identifier: Apache-2.0
"""``eventreg set NODE.PARAM VALUE``: set a parameter of the running loop."""

from __future__ import annotations

import argparse
import re

from ..errors import ParameterError, shown
from ..scenario.interventions import Intervention
from ..scenario.reader import typed
from ..session.intervene import intervene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``set``."""
    parser.add_argument('parameter', metavar='NODE.PARAM', help='controller.tau, say')
    parser.add_argument('value', metavar='VALUE', help='as in a parameter file: 0.0625')


def main(args: argparse.Namespace) -> int:
    """Set it and return 0."""
    found = re.fullmatch(r'([^:.\s]+)\.([^:\s]+)', args.parameter)
    if found is None:
        raise ParameterError(
            f'set takes NODE.PARAM VALUE (controller.tau 0.0625), got {shown(args.parameter)} for '
            'NODE.PARAM'
        )
    node, parameter = found.groups()
    value = typed(args.value, args.parameter, parameter)
    text = f'{args.parameter}:={args.value}'
    run = intervene(Intervention(text, 0.0, node.strip('/'), 'set', parameter, value))
    print(f'{args.parameter} is {value} in {run}')
    return 0
