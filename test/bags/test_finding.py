# SPDX-License-Identifier: Apache-2.0
"""The codes of findings, and the page that explains them."""

from pathlib import Path

from eventreg_ros.bags.finding import CODES, IMPAIRING

PAGE = Path(__file__).resolve().parents[2] / 'docs' / 'bags.md'


def test_every_code_is_explained_and_those_that_impair_have_a_star():
    rows = [line for line in PAGE.read_text(encoding='utf-8').splitlines() if line[:3] == '| `']
    for code in CODES:
        (row,) = (row for row in rows if f'`{code}`' in row.split('|')[1])
        assert (code in IMPAIRING) == ('*' in row.split('|')[1])
    assert set(CODES) >= IMPAIRING
