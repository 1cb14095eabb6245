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
# # 5. Delay and margins
#
# The paper's loop is one continuous system. A real one is sampled, and its signals travel.
# `simulate` with `sampled=True` does what the ROS nodes do, sample by sample, with a delay on
# every link.

# %%
import numpy as np

from eventreg_ros import load, simulate

for delay in (0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6):
    run = simulate('exact', sampled=True, delay=delay)
    y = abs(run['y'][run.t > 100.0]).max()
    print(f'delay {delay:.1f}: {run.verdict:12}  |y| up to {y:.2f}')

# %% [markdown]
# The delay is in model time. At `time_scale` 10, the default, 0.4 is 40 ms.
#
# The loop has to subtract $u$ from $w$ at the same moment. A spike rises within about one unit of
# time, so a $u$ that is late by a fraction of that leaves a piece of the spike behind. The nodes
# predict a little: they extend the line through the last two samples (`hold: linear`). Without
# that (`hold: zero`) the margin is smaller.

# %%
for scenario in ('exact', 'mismatch'):
    for hold in ('zero', 'linear'):
        worst = 0.0
        for delay in np.arange(0.0, 1.0, 0.05):
            run = simulate(scenario, {'/**.hold': hold}, sampled=True, delay=delay)
            if run.verdict != 'rejected':
                break
            worst = delay
        print(f'{scenario:8} {hold:6}: rejected up to a delay of {worst:.2f}')

# %% [markdown]
# `eventreg margin exact` does this with care: finer steps, both holds, loss and jitter too.
#
# ## Gain against delay
#
# In notebook 3 a larger $k$ tolerated a more wrong $\tau$. Here is the price: the tolerated delay
# falls about as $0.8 / k$.

# %%
for k in (0.7, 1.0, 2.0, 4.0):
    setup = load('exact', {'/**.hold': 'zero', 'controller.k': k})
    delays = np.arange(0.05, 1.2, 0.05)
    fails = next(d for d in delays if simulate(setup, sampled=True, delay=d).verdict != 'rejected')
    print(f'k = {k:3g}: fails at a delay of {fails:.2f}; 0.8 / k = {0.8 / k:.2f}')

# %% [markdown]
# ## The way around the loop
#
# Which delay matters? Delay one signal at a time.

# %%
for signal in ('w', 'y', 'u'):
    run = simulate('exact', sampled=True, delay=0.6, on=[signal])
    print(f'only {signal} late by 0.6: {run.verdict}')

# %% [markdown]
# A late $w$ is just a later disturbance. $y$ and $u$ lie on the loop, and what counts is their
# sum: each alone may be twice as late as both together.
#
# ## Loss
#
# A lost sample makes the one before it older, for a step. So a loop with many samples per unit of
# time tolerates the loss of most of them.

# %%
for rate in (50.0, 200.0, 1000.0):
    results = []
    for loss in (0.2, 0.5, 0.8, 0.9):
        run = simulate('exact', {'/**.rate': rate}, sampled=True, loss=loss, seed=1)
        results.append(f'{loss:g} {run.verdict}')
    print(f'{rate:5g} samples per second: loss {", ".join(results)}')

# %%
simulate('exact', sampled=True, delay=0.5).plot()

# %% [markdown]
# ## Try
#
# - At which `time_scale` does the loop tolerate 100 ms on every link?
# - Jitter (`jitter=2.0`) is an extra random delay of each sample. Why does the loop tolerate a
#   jitter far above its delay margin?
# - `linear` has a delay margin that you can compute: from $(s + 1)(s^2 + 1) + s\,e^{-2 s \tau} =
#   0$.
