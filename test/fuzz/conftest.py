# SPDX-License-Identifier: Apache-2.0
"""How many cases the generated tests try: few in ``make test``, many in ``make fuzz``."""

import os

import pytest

os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'


@pytest.fixture
def fuzz():
    """Return the number of cases: the one given, times EVENTREG_FUZZ of the environment."""

    def number(few):
        return int(few * float(os.environ.get('EVENTREG_FUZZ', '1')))

    return number


@pytest.fixture
def domain():
    """A ROS domain that nobody else has, on the loopback."""
    from eventreg_ros.session.domain import loopback_domain

    with loopback_domain({}) as found:
        yield int(found['ROS_DOMAIN_ID'])
