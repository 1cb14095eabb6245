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
# # 3. Exact and mismatched internal models
#
# Now the disturbance is a spike train, the plant a neuron, and the controller a copy of the two
# neurons that made the spikes. Its first neuron is driven by $y$, and inhibits the plant.
#
# ## An exact copy

# %%
from eventreg_ros import simulate

exact = simulate('exact')
print(exact)
exact.plot()

# %% [markdown]
# The controller starts from another state than the generator. Within one spike it synchronises:
# $u$ equals $w$, spikes and all, and $y$ vanishes.

# %%
for start in (0, 50, 100, 150, 200):
    part = (exact.t >= start) & (exact.t < start + 50)
    print(f't from {start:3d}: |y| up to {abs(exact["y"][part]).max():.1e}')

# %% [markdown]
# ## A wrong copy
#
# The scenario `mismatch` has a controller with $k = 3$ and $\tau = 1/16$; the generator has $k =
# 1$ and $\tau = 1/12$. Now $y$ cannot vanish. It is the *events* that vanish.

# %%
mismatch = simulate('mismatch')
print(mismatch)
mismatch.plot()

# %% [markdown]
# ## How wrong may it be?
#
# Let the time constant of the controller be wrong by a factor, with two gains.

# %%
for k in (1.0, 2.0):
    for factor in (0.5, 0.8, 1.0, 1.25, 2.0):
        run = simulate('exact', {'controller.k': k, 'controller.tau': factor / 12})
        spurious = run.report.rejection.spurious
        print(f'k = {k:g}, tau wrong by {factor:4g}: {run.verdict:12}  {spurious} spurious events')

# %% [markdown]
# A larger $k$ couples the controller more strongly to $y$: it follows $w$ even where its own
# rhythm is wrong. (What that costs is in notebook 5.)
#
# ## Only $\tau$ must agree
#
# The paper asks for equal $k$ and equal $\tau$. In antiphase $k$ cancels, so a controller with the
# right $\tau$ and any other $k$ still makes $y$ vanish. One with the right $k$ and a wrong $\tau$
# does not.

# %%
for parameter, value in (('k', 3.0), ('k', 1.0), ('tau', 1 / 16), ('tau', 1 / 11)):
    run = simulate('exact', {f'controller.{parameter}': value}, 600.0)
    rest = abs(run['y'][run.t > 400.0]).max()
    print(f'{parameter} = {value:.4f}: |y| after 400 up to {rest:.1e}')

# %% [markdown]
# ## Spikes that must stay
#
# In `open` the plant is meant to spike: $v$ asks for it, and a reference says what the plant would
# do without $w$. The controller gets the difference $y - y_r$, and removes only what $w$ does.

# %%
run = simulate('open')
print(run)
run.plot()

# %% [markdown]
# ## Try
#
# - Where exactly is the border in `tau` for `k = 1`? Bisect.
# - Switch the controller off in the middle: `simulate('exact', at=['130:controller:deactivate',
#   '250:controller:activate'])`.
# - Change the generator while it runs: `at=['200:exosystem.tau:=0.0625']`.
