# SPDX-License-Identifier: Apache-2.0
"""The library in a few cells: run it as a script, or cell by cell in an editor or in Jupyter.

Everything here is offline; no ROS is needed. Times are in the paper's model time.
"""

# %% A scenario is simulated and judged
from eventreg_ros import certificates, events, judge, load, simulate

run = simulate(load('exact', 'controller.k:=3'))
print(run)  # the table that `eventreg simulate exact -p controller.k:=3` prints
print(run.verdict, run.events['y'])

# %% The signals are numpy arrays on a common grid
print(run.t.shape, run['w'].max(), abs(run['w'] - run['u'])[-1])

# %% How large may the controller's time constant be before events pass? Between these two
for tau in (1 / 12, 1 / 24, 1 / 48):
    other = simulate(load('exact', f'controller.tau:={tau}'))
    print(f'tau = {tau:.3f}: {other.verdict}, residual {other.report.residual.max_abs:.2g}')

# %% Sample by sample, as the nodes do it: the verdict depends on the delay of the links
for delay in (0.0, 0.2, 0.6):
    print(f'delay {delay}: {simulate("exact", sampled=True, delay=delay).verdict}')

# %% Other events (any threshold), and another time to settle
print(events(run.t, run['y'], threshold=0.1, reset=0.0))
print(judge(run, settle=200.0).rejection)

# %% What theory says, and what is measured where it is silent
for certificate in certificates('linear'):
    print(f'{certificate.subject}, {certificate.claim}: {certificate.status}. {certificate.text}')
