"""Draw the README's picture: a real run over DDS whose controller is switched off and on again.

python docs/demo.py docs/demo.png
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from eventreg_ros.analysis.events import detect
from eventreg_ros.bags.reader import read_bag
from eventreg_ros.plots.decimate import broken
from eventreg_ros.plots.style import (
    GREY,
    LABELS,
    TIME,
    look,
    mark_events,
    mark_threshold,
    save,
    style,
)
from eventreg_ros.session.domain import loopback_domain

OFF, ON, END = 13.0, 25.0, 40.0
"""Seconds of the run at which the controller is switched off and on, and at which it ends."""


def record(bag):
    """Run the scenario exact into ``bag``; switch the controller by its lifecycle."""
    with loopback_domain(os.environ) as environment:
        os.environ.update(environment)
        from eventreg_ros.session.client import ACTIVATE, DEACTIVATE, Client

        command = [sys.executable, '-m', 'eventreg_ros', 'run', 'exact']
        run = subprocess.Popen([*command, '--duration', str(END), '--bag', str(bag)])
        with Client(lambda: None) as client:
            client.watch(['w'])
            client.until(lambda: client.counts.get('w') == 1, 60.0, lambda: 'no spike of w')
            client.wait(OFF - 3.4)  # w spikes first at model time 34.2, 3.4 s into the run
            client.transition(['controller'], DEACTIVATE)
            client.wait(ON - OFF)
            client.transition(['controller'], ACTIVATE)
            run.wait()


def draw(signals, path):
    """Draw w and u, y, and the events of all three over model time."""
    from matplotlib.figure import Figure

    with style():
        figure = Figure(figsize=(6.8, 3.6), layout='constrained')
        axes = figure.subplots(3, 1, sharex=True, height_ratios=(3, 3, 1.3))
        for ax, names in zip(axes, (('w', 'u'), ('y',)), strict=False):
            for name in names:
                shown = look(name)
                ax.plot(
                    *broken(*signals[name]), color=shown.colour, linestyle=shown.line,
                    linewidth=shown.width, label=LABELS[name],
                )  # fmt: skip
            mark_threshold(ax, 1.0)
            ax.set_ylim(-2.4, 2.4)
            ax.legend(loc='upper left', ncols=3)
        rows = [(LABELS[name], look(name), detect(*signals[name])) for name in ('w', 'u', 'y')]
        mark_events(axes[2], rows)
        t, _ = broken(*signals['u'])
        gap = t[1:][(t[1:] - t[:-1]) > 10.0]
        for ax in axes:
            ax.axvspan(gap[0] - (ON - OFF) * 10.0, gap[0], color=GREY, alpha=0.25, linewidth=0)
        axes[0].text(gap[0] - (ON - OFF) * 5.0, 2.5, 'controller off', ha='center', va='bottom')
        axes[2].set_xlabel(TIME)
        axes[2].set_xlim(0.0, END * 10.0)
        save(figure, path)


if __name__ == '__main__':
    with tempfile.TemporaryDirectory() as scratch:
        record(Path(scratch) / 'bag')
        draw(read_bag(Path(scratch) / 'bag').in_model_time(10.0), Path(sys.argv[1]))
