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
# # 4. One neuron is too few
#
# The generator of $w$ has two neurons. Could the controller do with one? It sees $y$, it inhibits
# the plant, and it has the right $\tau$.

# %%
from pathlib import Path
from tempfile import mkdtemp

from eventreg_ros import certificates, load, simulate

run = simulate('single_neuron')
print(run)
run.plot()

# %% [markdown]
# It fails, and not for a lack of strength:

# %%
for k in (0.5, 1.0, 2.0, 8.0, 32.0):
    run = simulate('single_neuron', {'controller.k': k})
    y = abs(run['y'][run.t > 200.0]).max()
    print(f'k = {k:4g}: {run.verdict:12}  |y| up to {y:.2f}')

# %% [markdown]
# ## Why
#
# Suppose the controller had done its job: $y = 0$. Then its neuron gets no input. With $k > 1$ a
# neuron without input goes to rest, whatever it did before (it *contracts*), and $u$ goes to 0.
# But then $w$ reaches the plant again. A controller that works must be able to produce $w$ **while
# $y = 0$**: it must be an internal model of $w$. Two neurons that inhibit each other can; one
# cannot.

# %%
ALONE = 'controller:\n  ros__parameters: {{model: {model}, k: 2.0, x0: {x0}}}\n'


def left_alone(model, x0):
    """Return how large a controller's output is, late, when its input is zero."""
    file = Path(mkdtemp()) / 'alone.yaml'
    file.write_text(ALONE.format(model=model, x0=x0))
    run = simulate(load(str(file)), 300.0)
    return abs(run['u'][run.t > 200.0]).max()


print(f'one neuron:  |u| {left_alone("neuron", [1.0, 0.0]):.1e}')
print(f'two neurons: |u| {left_alone("oscillator", [1.0, 0.0, -1.0, 0.0]):.1e}')

# %% [markdown]
# ## What theory says
#
# `certificates` says the same from the equations, and measures what they leave open. A conditional
# Lyapunov exponent below zero means: solutions under the same input come together.

# %%
for name in ('exact', 'single_neuron'):
    print(name)
    for c in certificates(name):
        value = '' if c.value is None else f'{c.value:.3g}'
        print(f'  {c.status:8} {c.subject}: {c.claim} {value}')

# %% [markdown]
# Both loops contract when $w$ drives them. What contraction gives is one steady state; what the
# internal model gives is that $y = 0$ there. Both are needed.
#
# In `exact` the loop does *not* contract without $w$ (the exponent is 0): an oscillator keeps the
# phase that it started with. It is the input that makes it forget. The paper calls that
# *input-induced contraction*.
#
# ## Try
#
# - Start the loop `exact` with other states of plant and controller, and look at the difference of
#   two runs over time.
# - The same with `quiescent`, where $w = 0$. What is left of the difference?
# - Can two neurons that do *not* inhibit each other do it? (`k: 0.0` in the controller.)
