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
# # 2. The linear motif
#
# Before neurons, the classical problem: a sinusoid $w$ disturbs a linear plant $\dot y = -y + w -
# u$, and a controller that only sees $y$ must make $y \to 0$.
#
# The internal model principle says how: the controller contains a copy of the generator of $w$.
# Here it is an oscillator with the same frequency, driven by $y$:
#
# $$\dot x = \begin{pmatrix} 0 & 1 \\ -1 & 0 \end{pmatrix} x
# + \begin{pmatrix} 1 \\ 0 \end{pmatrix} y,
# \qquad u = K_1 x_1 + K_2 x_2.$$

# %%
import numpy as np

from eventreg_ros import certificates, simulate

run = simulate('linear', 60.0)
run.plot()

# %% [markdown]
# $u$ becomes $w$, and $y$ vanishes. The controller knows neither the amplitude nor the phase of
# $w$. It finds both, because it resonates at the frequency of $w$ until nothing of it is left in
# $y$.
#
# ## How fast
#
# The closed loop is linear, so $y$ falls like $e^{\lambda t}$ with the largest real part $\lambda$
# of its eigenvalues. `certificates` computes it; the simulation agrees.

# %%
hurwitz = next(c for c in certificates('linear') if c.claim == 'hurwitz')
print(f'{hurwitz.status}: largest real part {hurwitz.value:.4f}')

run = simulate('linear', 100.0)
early, late = (abs(run['y'][(run.t > a) & (run.t < a + 20.0)]).max() for a in (10.0, 70.0))
print(f'measured: {np.log(late / early) / 60.0:.4f}')

# %% [markdown]
# ## Which gains
#
# The paper gives the condition $K_1 > -K_2$, $K_2 < 1$. Across it the closed loop loses its
# stability.

# %%
for k_1, k_2 in ((1.0, 0.0), (0.2, 0.0), (4.0, -3.0), (1.0, 0.9), (1.0, 1.1), (-0.5, 0.4)):
    loop = np.array([[-1.0, -k_1, -k_2], [1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    rate = np.linalg.eigvals(loop).real.max()
    y = simulate('linear', {'controller.gain': [k_1, k_2]}, 200.0)['y']
    holds = 'holds' if k_1 > -k_2 and k_2 < 1.0 else 'fails'
    print(f'K = ({k_1}, {k_2}): {holds}  rate {rate:+.3f}  |y| at 200: {abs(y[-1]):.1e}')

# %% [markdown]
# ## What is special about a copy
#
# Without the oscillator the controller is blind to the frequency: proportional feedback $u = k_y
# y$ makes $y$ smaller, and never zero. $k_y$ adds that path; with $K = (0, 0)$ it is all that is
# left.

# %%
for k_y in (0.0, 1.0, 10.0, 100.0):
    run = simulate('linear', {'controller.gain': [0.0, 0.0], 'controller.k_y': k_y}, 100.0)
    print(f'k_y = {k_y:5g}: amplitude of y {abs(run["y"][run.t > 80.0]).max():.3f}')

# %% [markdown]
# A hundred times the feedback leaves a hundredth of the disturbance. The copy leaves nothing.
#
# ## Try
#
# - With `k_y` beside the copy: how does the rate of decay change?
# - Which gain makes the decay fastest?
# - Which of the three things that make this work (linearity, contraction, an internal model) is
#   missing when the plant is a neuron?
