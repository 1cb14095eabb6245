# SPDX-License-Identifier: Apache-2.0
"""How pages look: on a screen of any width, light or dark, and on paper."""

from __future__ import annotations

LIGHT = """
  --paper: #ffffff; --ink: #1b1f24; --muted: #5b6470; --grid: #dfe3e8; --grey: #7d8793;
  --shade: #eef0f3; --w: #d55e00; --v: #b0568c; --y_r: #00835f; --u: #0072b2; --other: #9a6400;
  --good: #00704f; --bad: #b03a00; --open: #5b6470;"""

DARK = """
  --paper: #14171b; --ink: #e8eaed; --muted: #a3acb8; --grid: #2c323a; --grey: #8a94a1;
  --shade: #20252b; --w: #ff8a4c; --v: #e29ac5; --y_r: #37d0a4; --u: #5eb3f0; --other: #f0b840;
  --good: #37d0a4; --bad: #ff8a4c; --open: #a3acb8;"""

STYLE = f"""
:root {{ color-scheme: light dark;{LIGHT} }}
@media (prefers-color-scheme: dark) {{ :root {{{DARK} }} }}
* {{ box-sizing: border-box; }}
body {{ margin: 0 auto; padding: 1.5rem 1.25rem 3rem; max-width: 66rem; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif;
  overflow-wrap: anywhere; }}
h1 {{ font-size: 1.5rem; line-height: 1.25; margin: 0 0 .2rem; }}
h2 {{ font-size: 1.15rem; margin: 2.2rem 0 .4rem; }}
h3 {{ font-size: 1rem; margin: 1.2rem 0 .3rem; }}
p, dl, ul {{ max-width: 46rem; margin: .4rem 0; }} ul {{ padding-left: 1.2rem; }}
.muted, figcaption {{ color: var(--muted); }}
.verdict {{ display: flex; gap: 1rem; align-items: center; margin: 1.2rem 0; padding: .9rem 1.1rem;
  border: 2px solid currentColor; border-radius: .5rem; }}
.verdict b {{ font-size: 1.35rem; line-height: 1.2; }}
.verdict p {{ margin: 0; color: var(--ink); }}
.symbol {{ font-size: 2.4rem; line-height: 1; width: 2.6rem; text-align: center; flex: none; }}
.rejected {{ color: var(--good); }} .not-rejected {{ color: var(--bad); }}
.undecided {{ color: var(--open); }}
.wide {{ overflow-x: auto; margin: .3rem 0; }} .long {{ max-height: 22rem; overflow: auto; }}
.wide, .long {{ background: linear-gradient(to right, var(--paper) 30%, transparent) left / 2rem
  100% no-repeat local, linear-gradient(to left, var(--paper) 30%, transparent) right / 2rem 100%
  no-repeat local, linear-gradient(to right, var(--grey), transparent) left / .5rem 100% no-repeat
  scroll, linear-gradient(to left, var(--grey), transparent) right / .5rem 100% no-repeat scroll; }}
table {{ border-collapse: collapse; font-variant-numeric: tabular-nums; overflow-wrap: normal; }}
th, td {{ padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid var(--grid);
  vertical-align: top; white-space: nowrap; }}
th:first-child, td:first-child {{ text-align: left; white-space: normal; max-width: 24rem; }}
td:first-child {{ overflow-wrap: break-word; }}
.words td, .words th {{ text-align: left; }} .words td {{ max-width: 34rem; white-space: normal; }}
thead th {{ font-weight: 600; color: var(--muted); }}
.long thead th {{ position: sticky; top: 0; background: var(--paper); }}
.tiles {{ display: grid; grid-template-columns: repeat(auto-fill, minmax(9.5rem, 1fr)); gap: .6rem;
  margin: .5rem 0; }}
.tiles div {{ border: 1px solid var(--grid); border-radius: .4rem; padding: .45rem .7rem; }}
.tiles b {{ display: block; font-size: 1.25rem; line-height: 1.3;
  font-variant-numeric: tabular-nums; }}
.tiles span {{ color: var(--muted); font-size: .85rem; }}
dt {{ font-weight: 600; margin-top: .5rem; }} dd {{ margin: 0 0 0 1.2rem; }}
pre {{ overflow: auto; padding: .8rem; border: 1px solid var(--grid); border-radius: .4rem;
  font-size: .85rem; overflow-wrap: normal; }}
summary {{ cursor: pointer; color: var(--muted); }}
:focus-visible {{ outline: 2px solid var(--u); outline-offset: 2px; }}

figure {{ margin: .6rem 0 1.2rem; }} figure svg {{ fill: var(--ink); }}
.picture svg {{ width: 100%; min-width: 30rem; height: auto; display: block; }}
.tools {{ display: flex; flex-wrap: wrap; gap: .35rem; align-items: center; margin: .3rem 0; }}
.tools[hidden] {{ display: none; }} .tools output {{ color: var(--muted); margin-left: .4rem; }}
button {{ font: inherit; font-size: .85rem; padding: .15rem .6rem; color: var(--ink);
  background: var(--shade); border: 1px solid var(--grid); border-radius: .3rem; cursor: pointer; }}
.plot {{ display: grid; grid-template-columns: 52px minmax(0, 1fr); padding-right: 16px; }}
.plot svg {{ display: block; }} .scale, .area, .time {{ width: 100%; font-size: 12px; }}
.area {{ overflow: hidden; border-left: 1px solid var(--grey); touch-action: pan-y; }}
.time, .glyph, .scale {{ overflow: visible; }} .panel + .panel {{ margin-top: .5rem; }}
.time .ticks {{ fill: var(--muted); }} .scale {{ fill: var(--muted); }}
.keys {{ display: flex; flex-wrap: wrap; gap: 0 1.1rem; margin: .5rem 0 .4rem 52px;
  font-size: .85rem; }}
.key {{ display: inline-flex; gap: .4rem; align-items: center; }} .key svg {{ flex: none; }}
.line, .tick, .points, .ring, .hole, .rung, .level, .change, .instant {{ fill: none;
  stroke: var(--other); stroke-width: 1.5; vector-effect: non-scaling-stroke; }}
.grid line, .rung {{ stroke: var(--grid); stroke-width: 1; }}
.level {{ stroke: var(--grey); stroke-width: 1.2; stroke-dasharray: 2 3; }}
.line {{ stroke-linejoin: round; }} .tick {{ stroke-width: 1.7; }}
.points, .ring, .hole {{ stroke-linecap: round; }} .points {{ stroke-width: 4; display: none; }}
.points.sparse {{ display: inline; }}
.ring {{ stroke-width: 9; }} .hole {{ stroke-width: 5.5; stroke: var(--paper); }}
.change {{ stroke: var(--ink); stroke-dasharray: 7 3 1.5 3; }}
.instant {{ stroke: var(--bad); stroke-width: 2; stroke-dasharray: 4 3; }}
.number {{ font-size: 11px; }}
.uncounted {{ fill: var(--shade); }} .hatch {{ stroke: var(--bad); stroke-width: 1.2;
  stroke-opacity: .4; fill: none; }}
.unseen {{ stroke: var(--bad); stroke-width: 1; stroke-dasharray: 3 2; }}
.spurious {{ stroke: var(--bad); stroke-width: 2.4; fill: none; }}
.missed {{ stroke: var(--bad); stroke-width: 1.6; fill: var(--paper); }}
.w {{ stroke: var(--w); }} .v {{ stroke: var(--v); }} .y {{ stroke: var(--ink); }}
.y_r {{ stroke: var(--y_r); }} .u {{ stroke: var(--u); }}
.above, .below {{ stroke: none; fill: var(--bad); }}
.line.y_r {{ stroke-dasharray: 7 3; }} .line.v {{ stroke-dasharray: 7 3 1.5 3; }}
.line.band {{ stroke-width: 5; stroke-opacity: .45; }}
.run0 {{ stroke: var(--ink); }} .run1 {{ stroke: var(--w); }} .run2 {{ stroke: var(--u); }}
.run3 {{ stroke: var(--y_r); }} .line.run1 {{ stroke-dasharray: 7 3; }}
.line.run2 {{ stroke-dasharray: 7 3 1.5 3; }} .line.run3 {{ stroke-dasharray: 2 2.5;
  stroke-width: 2; }}

@media (max-width: 40rem) {{ body {{ padding: 1rem .75rem 2rem; }} .plot {{
  grid-template-columns: 46px minmax(0, 1fr); padding-right: 12px; margin-left: -.5rem; }}
  .keys {{ margin-left: 0; }} .verdict {{ gap: .6rem; padding: .7rem .8rem; }}
  .symbol {{ width: 2rem; font-size: 2rem; }} .tools output {{ flex-basis: 100%; margin: 0; }} }}
@media print {{ :root {{ color-scheme: light;{LIGHT} }} body {{ max-width: none; padding: 0;
  font-size: 10pt; }} .tools {{ display: none; }} .long {{ max-height: none; }}
  .wide, .long {{ overflow: visible; background: none; }} .hint {{ display: none; }}
  .long thead th {{ position: static; }}
  h1, h2, h3, summary {{ break-after: avoid; }} figure, tr, dt, .verdict, .tiles div {{
  break-inside: avoid; }} dt {{ break-after: avoid; }} p {{ orphans: 3; widows: 3; }}
  thead {{ display: table-header-group; }} pre {{ white-space: pre-wrap; }} }}
"""
"""Signals that share a panel differ in colour and in line, marks in shape."""
