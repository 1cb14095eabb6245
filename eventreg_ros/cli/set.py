"""``eventreg set NODE.PARAM VALUE``: set a parameter of the running loop."""

from __future__ import annotations

import argparse

from ..scenario.interventions import Intervention
from ..session.intervene import intervene


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``set``."""
    parser.add_argument('parameter', metavar='NODE.PARAM', help='controller.tau, say')
    parser.add_argument('value', metavar='VALUE', help='as in a parameter file: 0.0625')


def main(args: argparse.Namespace) -> int:
    """Set it and return 0."""
    action = Intervention.read(f'0:{args.parameter}:={args.value}')
    intervene(action)
    print(f'{args.parameter} is {action.value}')
    return 0
