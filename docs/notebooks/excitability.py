# ---
# # SPDX-License-Identifier: Apache-2.0
# jupyter:
#   jupytext:
#     formats: py:percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # 1. Excitability and events
#
# A neuron is a system that rests, and answers a strong enough push with a spike. This notebook
# looks at one neuron, at what counts as an *event*, and at two neurons that make a spike train
# together.
#
# Everything runs offline, in seconds, without ROS. Times are in model time, the paper's $t$.

# %%
from pathlib import Path
from tempfile import mkdtemp

import numpy as np

from eventreg_ros import events, load, simulate

FOLDER = Path(mkdtemp())


def scenario(text):
    """Write a scenario to a file and load it."""
    file = FOLDER / 'mine.yaml'
    file.write_text(text)
    return load(str(file))


# %% [markdown]
# ## One neuron
#
# The plant is one FitzHugh-Nagumo neuron with conductance $k$ and time constant $\tau$:
#
# $$\dot x_1 = x_1 - \tfrac{1}{3} x_1^3 - x_2 + k\,(d - x_1), \qquad \dot x_2 = \tau\,(x_1 - x_2),
# \qquad y = x_1,$$
#
# where $d$ is the sum of what reaches it. With $k = 0$ nothing reaches it, and it fires by itself.
# With $k = 1$ it rests until it is pushed.

# %%
ALONE = 'plant:\n  ros__parameters: {{k: {k}, tau: 0.09, x0: [0.5, 0.0]}}\n'

for k in (0.0, 0.5, 1.0, 2.0):
    run = simulate(scenario(ALONE.format(k=k)), 300.0)
    late = run['y'][run.t > 200.0]
    print(f'k = {k:g}: {len(run.events["y"]):2d} events, |y| at the end {abs(late).max():.3f}')

# %% [markdown]
# ## A push
#
# Now the neuron with $k = 1$ gets one pulse $v$, 10 units long. The response grows with the pulse,
# but not in proportion: the cubic saturates it.

# %%
PUSHED = """
stimulus:
  ros__parameters: {{waveform: pulses, onsets: [50.0], width: 10.0, amplitude: {amplitude}}}
plant:
  ros__parameters: {{k: 1.0, tau: 0.09}}
"""


def pushed(amplitude):
    """Simulate a neuron that gets one pulse."""
    return simulate(scenario(PUSHED.format(amplitude=amplitude)), 150.0)


for amplitude in (0.25, 0.5, 1.0, 2.0, 4.0):
    run = pushed(amplitude)
    print(f'pulse {amplitude:4g}: largest y {run["y"].max():.2f}, events {len(run.events["y"])}')

# %%
pushed(1.0).plot()

# %% [markdown]
# ## What an event is
#
# A signal has an event when it rises through `threshold` (1.0) after it was at or below `reset`
# (0.0). The threshold is the *fold* of the cubic $x - x^3/3$: its slope is zero at 1, and beyond
# it the neuron is on its way into a spike. Two levels are needed, since a real signal is noisy:
# with one level a single rise is counted many times.

# %%
run = pushed(1.0)
noisy = run['y'] + np.random.default_rng(1).normal(0.0, 0.1, len(run.t))
print('two levels:', events(run.t, noisy))
print('one level: ', len(events(run.t, noisy, threshold=1.0, reset=0.99)), 'events')

# %% [markdown]
# ## Two neurons that inhibit each other
#
# The exosystem of the paper is two such neurons, each inhibited by the other. They fire in turn,
# and never stop. Its output $w$ is the first of them.

# %%
run = simulate('uncontrolled')
print('events of w:', np.round(run.events['w'], 1))
print('intervals:  ', np.round(np.diff(run.events['w']), 3))

# %% [markdown]
# How fast they fire depends on $\tau$, and, surprisingly, not on $k$: in antiphase the two inputs
# cancel, so each neuron behaves as if it were alone.

# %%
for parameter, values in (('tau', (1 / 6, 1 / 12, 1 / 24)), ('k', (1.0, 2.0, 4.0))):
    for value in values:
        run = simulate('uncontrolled', {f'exosystem.{parameter}': value}, 500.0)
        period = np.diff(run.events['w'])[-1]
        print(f'{parameter} = {value:.3f}: period {period:.2f}')

# %% [markdown]
# ## The problem
#
# Let $w$ into the plant, and every spike of $w$ makes the plant spike. This is the disturbance
# that a controller has to remove. It need not remove it entirely: $y$ must not *spike*.

# %%
run = simulate('uncontrolled')
print(run)
run.plot()

# %% [markdown]
# ## Try
#
# - Make the pulse shorter (`width: 2.0`). How strong must it be now?
# - Find the smallest amplitude with an event, to three digits, by bisection.
# - Give the plant a sine instead: `waveform: sine, amplitude: 0.4, period: 40.0`. For which
#   periods does it spike?
