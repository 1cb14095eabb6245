# SPDX-License-Identifier: Apache-2.0
"""What stands below the help of each command: examples, and what its exit codes mean."""

from __future__ import annotations

VERDICTS = (
    'exit codes: 0 rejected, 1 not rejected, 3 undecided, 2 bad input (one line says how to fix it)'
)

EPILOGS = {
    'run': f"""\
examples:
  eventreg run exact                                  40 s in real time, then the verdict
  eventreg run exact -p controller.k:=3 --bag mine    another gain; the bag is kept in mine
  eventreg run exact --lockstep --duration 40         as fast as it goes, the same every time
  eventreg run exact --at 15:controller:deactivate --at 25:controller:activate
  eventreg run exact --report page.html               a page with plots

{VERDICTS};
4: a node died or stopped during the run""",
    'simulate': f"""\
examples:
  eventreg simulate mismatch                          one continuous system, 400 of model time
  eventreg simulate exact --sampled --delay 0.2       sample by sample, as nodes do it, delayed
  eventreg simulate exact --at 150:controller:deactivate --out run.csv

--out holds a column t (model time, every h from 0) and one per signal, by its name.
{VERDICTS}""",
    'analyze': f"""\
examples:
  eventreg analyze BAG                                events, rejection, timing, the verdict
  eventreg analyze BAG --report page.html             a page with plots
  eventreg analyze --last                             the bag of the last run here
  eventreg analyze BAG --scenario exact --settle 200 --json result.json
  eventreg analyze BAG --topic y:=/arm/joint_states:velocity[2] --time header
  eventreg analyze BAG --json - | jq .verdict         - is standard output

{VERDICTS}""",
    'compare': """\
examples:
  eventreg compare exact mismatch                     two scenarios, simulated
  eventreg compare BAG_1 BAG_2 BAG_3 --report page.html""",
    'identify': """\
examples:
  eventreg identify BAG --out mine.yaml               from w, else from y and u
  eventreg run mine.yaml                              the controller has the tau
  eventreg identify BAG --from-signal y --generators 2
  eventreg identify BAG --topic w:=/arm/current:data --affine

exit codes: 0 identified, 2 not, or bad input (one line says why)""",
    'certify': """\
examples:
  eventreg certify exact
  eventreg certify open -p controller.k:=2 --json certificates.json""",
    'margin': """\
examples:
  eventreg margin exact                               delay, loss and jitter, with each hold
  eventreg margin exact --plot margin.svg             and the verdict over delay and loss""",
    'sweep': """\
examples:
  eventreg sweep exact -p controller.k:=0.5..4/60 -p controller.tau:=1/25..1/5/60log --plot map.svg
  eventreg sweep exact -p links.delay:=0..0.8/17 -p links.loss:=0..0.95/20 --out net
  eventreg sweep exact -p controller.k:=1~10% --sets 2000 --out chip    a normal law
  eventreg sweep exact -p controller.k:=0.9..3 -p links.delay:=0..0.3 --worst 500

A..B/N is N values, A..B a range to draw from, '{A,B}' these values. Ctrl-C keeps what is done in
DIR; the same command continues.
exit codes: 0 done, whatever the verdicts; 2 bad input (one line says how to fix it)""",
    'figures': """\
examples:
  eventreg figures --out figures                      all of them, as PDF, SVG and PNG
  eventreg figures exact mismatch --format svg""",
    'list': """\
examples:
  eventreg list
  eventreg simulate open                              each is a name for other commands""",
    'node': """\
examples:
  eventreg node plant --help                          what it is, and all its parameters
  eventreg node plant --ros-args -p k:=2.0 -r y:=other_y

exit codes: 0 ended by SIGINT or SIGTERM, 2 bad input""",
    'new': """\
examples:
  eventreg new mine.yaml
  eventreg new mine.yaml --from open""",
    'set': """\
examples:
  eventreg set controller.tau 0.0625                  on the run of this machine
  ROS_DOMAIN_ID=5 eventreg set controller.k 3         on the nodes of a domain""",
    'live': """\
examples:
  eventreg live                                       while eventreg run goes on beside it
  eventreg live --port 9000

It listens on the loopback alone, needs the extra live, and ends with the run or Ctrl-C (0).""",
    'activate': """\
examples:
  eventreg activate controller                        it starts again from x0""",
    'deactivate': """\
examples:
  eventreg deactivate controller                      u goes to 0, the rest runs on
  eventreg activate controller                        it starts again from x0""",
}
