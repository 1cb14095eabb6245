# SPDX-License-Identifier: Apache-2.0
"""One intervention in the loop that runs: what ``eventreg set`` does, for Python."""

from __future__ import annotations

import time

from ..errors import EventregError, ros_is_missing
from ..scenario.hint import hint
from ..scenario.interventions import Intervention
from .running import of_domain, reaching_environment, the_run

PATIENCE = 5.0
"""Seconds within which the node must be found and answer."""


def intervene(action: Intervention) -> str:
    """Do ``action`` now, in the run of this machine, or in the domain that ROS_DOMAIN_ID names.

    Returns in words which run that was: its scenario and its domain.
    Raises EventregError when there is no ROS, no such node, or the node refuses.
    """
    run = the_run()
    if run is not None and action.node not in run.nodes:
        nearest = hint(action.node, run.nodes)
        raise EventregError(f'the run of {run.scenario} has no node {action.node!r}{nearest}')
    whom = reaching_environment(run)
    try:
        from .client import Client
    except ImportError as error:
        raise EventregError(ros_is_missing('this command', error)) from None
    domain = whom.get('ROS_DOMAIN_ID', '0')
    end = time.monotonic() + PATIENCE

    def patience() -> None:
        if time.monotonic() > end:
            raise EventregError(
                f'no node {action.node!r} answers on ROS_DOMAIN_ID={domain}; start one with '
                'eventreg run, or export the ROS_DOMAIN_ID of yours'
            )

    with Client(patience, environment=whom) as client:
        client.act(action)
    return of_domain(domain)
