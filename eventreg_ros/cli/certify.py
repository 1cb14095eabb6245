# SPDX-License-Identifier: Apache-2.0
"""``eventreg certify``: what theory says of a scenario, and what is measured where it is silent.

``--json F`` writes ``{"scenario", "time", "certificates": [...]}``, ``time`` being the model time
over which each exponent was averaged. Each certificate is ``{"subject", "claim", "status", "value",
"meaning", "text", "numbers"}``: ``claim`` is one of ``lemma_1``, ``lemma_2``, ``error_system``,
``reference_copy``, ``internal_model``, ``single_neuron``, ``learning``, ``gain_and_delay``,
``hurwitz``, ``francis``, ``wiring``, ``exponent_driven``, ``exponent_driven_by_v``,
``exponent_quiet``, ``input_induced_contraction``, ``floquet``;
``status`` is ``pass``, ``marginal``, ``none`` or ``fail``; ``value`` is the number behind it or
null, and ``meaning`` says what it is; ``numbers`` holds the further figures of that claim.
"""

from __future__ import annotations

import argparse
import textwrap
from dataclasses import asdict
from typing import TYPE_CHECKING

from ..files import need_writable
from .arguments import add_json, add_scenario, load_scenario, positive, write_json

if TYPE_CHECKING:
    from ..theory.certificates import Certificate

WIDTH = 100
INDENT = 10
EXPONENT = 'largest conditional Lyapunov exponent'
TITLES = {
    'lemma_1': ('Lemma 1 (contraction)', 'rate'),
    'lemma_2': ('Lemma 2 (antiphase)', 'rate'),
    'error_system': ('Lemma 1 for the error system', 'rate'),
    'reference_copy': ('copy of the plant', 'largest relative difference'),
    'internal_model': ('internal model', 'largest relative difference from a copy'),
    'single_neuron': ('one neuron as internal model', ''),
    'hurwitz': ('Hurwitz', 'largest real part'),
    'francis': ('steady state (Francis)', 'amplitude of y per amplitude of w'),
    'wiring': ('wiring', ''),
    'learning': ('learning', 'predicted rate'),
    'gain_and_delay': ('gain and delay', 'predicted delay margin'),
    'exponent_driven': (EXPONENT, ''),
    'exponent_driven_by_v': (EXPONENT, ''),
    'exponent_quiet': (EXPONENT, ''),
    'input_induced_contraction': ('input-induced contraction', ''),
    'floquet': ('Floquet multipliers', 'largest exponent'),
}
"""For each claim its title and what its number is called; empty where the words give it."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``eventreg certify``."""
    add_scenario(parser)
    parser.add_argument(
        '--time', type=positive, metavar='T',
        help='model time over which each Lyapunov exponent is averaged (600); much shorter, '
        'the interval given with it is too narrow',
    )  # fmt: skip
    add_json(parser)


def main(args: argparse.Namespace) -> int:
    """Print the certificates of the scenario, each as soon as it is known; return 0."""
    from ..theory.certify import one_by_one
    from ..theory.lyapunov import TIME

    need_writable(args.json)
    scenario = load_scenario(args)
    time = TIME if args.time is None else args.time
    certificates: list[Certificate] = []
    for certificate in one_by_one(scenario.loop, time):
        if not certificates:
            print(f'scenario {scenario.name}')
        certificates.append(certificate)
        print(f'\n{lines(certificate)}', flush=True)
    write_json(
        args.json,
        {
            'scenario': scenario.name,
            'time': time,
            'certificates': [asdict(c) for c in certificates],
        },
    )
    return 0


def lines(certificate: Certificate) -> str:
    """Return a certificate as text: status, subject, claim and number; the words below."""
    claim, number = TITLES[certificate.claim]
    head = f'{certificate.status:<{INDENT}}{certificate.subject}: {claim}'
    if number and certificate.value is not None:
        head += f', {number} {certificate.value:.4g}'
    margin = ' ' * INDENT
    body = textwrap.fill(certificate.text, WIDTH, initial_indent=margin, subsequent_indent=margin)
    return f'{head}\n{body}'
