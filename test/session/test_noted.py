# SPDX-License-Identifier: Apache-2.0
"""What nodes warned of becomes findings in the run's model time."""

from types import SimpleNamespace

from eventreg_ros.analysis.recorded import analyze
from eventreg_ros.session.live import NODE_WARNING, _noted
from eventreg_ros.session.noted import Noted


def test_warnings_have_the_model_time_at_which_they_came(make_bag):
    analysis = analyze(make_bag(w=[110], y=[], u=[]))
    start = analysis.recording.start
    session = SimpleNamespace(noted=[Noted(start + 12_500_000_000, 'plant', 'a tick was late')])
    (found,) = _noted(session, analysis)
    assert found == (NODE_WARNING, 'plant', 125.0, 'plant: a tick was late')
