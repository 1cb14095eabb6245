# SPDX-License-Identifier: Apache-2.0
"""Whether plants play u at the time for which their controllers predict it."""

from __future__ import annotations

from .scenario import Scenario


def unequal_leads(scenario: Scenario) -> list[str]:
    """Return a line for each plant whose ``lead`` is not that of a predicting controller beside it.

    Beside it are those of the same namespace. A plant of one's own has no ``lead`` to compare.
    """
    return [
        f'{controller}.lead is {own:g} and {plant}.lead is {other:g} of model time: u is predicted '
        'for another time than it is played at; set both with -p /**.lead:=VALUE'
        for controller, values in scenario.nodes.items()
        if values.get('predict')
        for plant in scenario.of_kind('plant')
        if scenario.name_of(plant).namespace == scenario.name_of(controller).namespace
        if (own := values['lead']) != (other := scenario.nodes[plant].get('lead', own))
    ]
