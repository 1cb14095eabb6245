# SPDX-License-Identifier: Apache-2.0
"""Draw the README's picture: a real run over DDS whose controller is switched off and on again.

python docs/demo.py docs/demo.png
"""

import sys
import tempfile
from pathlib import Path

from eventreg_ros.plots.run_plot import Shade, draw_run
from eventreg_ros.plots.style import save
from eventreg_ros.scenario import load
from eventreg_ros.session.live import run

OFF, ON = 13.0, 25.0
"""Seconds of the run at which the controller is switched off and on."""


def main(path):
    """Run the scenario exact, and draw what was recorded to ``path``."""
    scenario = load('exact')
    at = [f'{OFF:g}:controller:deactivate', f'{ON:g}:controller:activate']
    with tempfile.TemporaryDirectory() as scratch:
        found = run(scenario, bag=Path(scratch) / 'bag', at=at).analysis
        scale = scenario.time_scale
        figure = draw_run(
            found.signals,
            {name: signal.events for name, signal in found.report.signals.items()},
            threshold=scenario.criteria.threshold,
            shades=[Shade(OFF * scale, ON * scale, 'controller off')],
        )
    save(figure, path)


if __name__ == '__main__':
    main(Path(sys.argv[1]))
