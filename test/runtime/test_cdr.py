# SPDX-License-Identifier: Apache-2.0
"""Messages as bytes: their value, and how old their sample is."""

import pytest

from eventreg_ros.runtime.cdr import age_of, packed, unpacked, with_age


@pytest.mark.parametrize(
    ('age', 'precision'),
    [(0, 0), (49_000, 50_000), (200_000_000, 50_000), (3_276_700_000, 50_000),
     (3_276_800_000, 1_000_000), (60_000_000_000, 1_000_000)],
)  # fmt: skip
def test_an_age_goes_with_the_message_and_changes_nothing_else(age, precision):
    plain = packed(-2.5e-17)
    aged = with_age(plain, age)
    assert len(aged) == len(plain)
    assert unpacked(aged) == -2.5e-17
    assert abs(age_of(aged) - age) <= precision
    assert age_of(plain) == 0


def test_an_age_beyond_all_measure_is_the_oldest_there_is():
    assert age_of(with_age(packed(0.0), 10**12)) == 65_534_000_000
    assert age_of(with_age(packed(0.0), -5)) == 0
