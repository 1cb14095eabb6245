"""How many cases the generated tests try: few in ``make test``, many in ``make fuzz``."""

import os

import pytest


@pytest.fixture
def fuzz():
    """Return the number of cases: the one given, times EVENTREG_FUZZ of the environment."""

    def number(few):
        return int(few * float(os.environ.get('EVENTREG_FUZZ', '1')))

    return number
