"""The bare page: everything that comes from outside is escaped here, the look is written here."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

STYLE = """
:root { color-scheme: light dark;
  --paper: #ffffff; --ink: #1b1f24; --muted: #5b6470; --grid: #dfe3e8; --grey: #7d8793;
  --w: #d55e00; --v: #b0568c; --y_r: #009e73; --u: #0072b2; --other: #b87700;
  --good: #00704f; --bad: #b03a00; --open: #5b6470; }
@media (prefers-color-scheme: dark) { :root {
  --paper: #14171b; --ink: #e8eaed; --muted: #a3acb8; --grid: #2c323a; --grey: #8a94a1;
  --w: #ff8a4c; --v: #e29ac5; --y_r: #37d0a4; --u: #5eb3f0; --other: #f0b840;
  --good: #37d0a4; --bad: #ff8a4c; --open: #a3acb8; } }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1.25rem 3rem; max-width: 66rem; background: var(--paper);
  color: var(--ink); font: 15px/1.5 system-ui, 'Segoe UI', 'DejaVu Sans', sans-serif; }
h1 { font-size: 1.5rem; margin: 0 0 .2rem; } h2 { font-size: 1.15rem; margin: 2.2rem 0 .4rem; }
p, dl { max-width: 46rem; margin: .4rem 0; } .muted, figcaption, caption { color: var(--muted); }
.verdict { display: flex; gap: 1rem; align-items: center; margin: 1.2rem 0;
  padding: .9rem 1.1rem; border: 2px solid currentColor; border-radius: .5rem; }
.verdict b { font-size: 1.35rem; line-height: 1.2; } .verdict p { margin: 0; color: var(--ink); }
.symbol { font-size: 2.4rem; line-height: 1; width: 2.6rem; text-align: center; flex: none; }
.rejected { color: var(--good); } .not-rejected { color: var(--bad); }
.undecided { color: var(--open); }
.wide { overflow-x: auto; } .long { max-height: 22rem; overflow: auto; }
table { border-collapse: collapse; font-variant-numeric: tabular-nums; margin: .3rem 0; }
th, td { padding: .2rem .8rem .2rem 0; text-align: right; border-bottom: 1px solid var(--grid);
  vertical-align: top; }
th:first-child, td:first-child { text-align: left; } .words td, .words th { text-align: left; }
thead th { font-weight: 600; color: var(--muted); position: sticky; top: 0;
  background: var(--paper); }
.tiles { display: grid; grid-template-columns: repeat(auto-fill, minmax(9.5rem, 1fr)); gap: .6rem;
  margin: .5rem 0; } .tiles div { border: 1px solid var(--grid); border-radius: .4rem;
  padding: .45rem .7rem; } .tiles b { display: block; font-size: 1.25rem; line-height: 1.3;
  font-variant-numeric: tabular-nums; } .tiles span { color: var(--muted); font-size: .85rem; }
figure { margin: .4rem 0 1rem; } figure svg { width: 100%; min-width: 38rem; height: auto;
  display: block; fill: var(--ink); } svg text { font-family: inherit !important; }
dt { font-weight: 600; margin-top: .5rem; } dd { margin: 0 0 0 1.2rem; }
pre { overflow: auto; padding: .8rem; border: 1px solid var(--grid); border-radius: .4rem;
  font-size: .85rem; } summary { cursor: pointer; color: var(--muted); }
@media print { body { max-width: none; padding: 0; } .long { max-height: none; }
  figure, table { break-inside: avoid; } }
"""


def page(title: str, body: Iterable[str]) -> str:
    """Return a whole HTML document that needs nothing from the network."""
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n'
        + '\n'.join(body)
        + '\n</body>\n</html>\n'
    )


def table(head: Sequence[str], rows: Iterable[Sequence[object]], kind: str = 'wide') -> str:
    """Return a table of plain text; ``kind`` is its container's class: wide, long or words."""
    lines = [f'<tr>{"".join(f"<td>{escape(str(cell))}</td>" for cell in row)}</tr>' for row in rows]
    header = ''.join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    return (
        f'<div class="{kind}"><table>\n<thead><tr>{header}</tr></thead>\n<tbody>\n'
        + '\n'.join(lines)
        + '\n</tbody></table></div>'
    )


def figure(svg: str, caption: str) -> str:
    """Return a figure with its caption, plain text."""
    return (
        f'<figure><div class="wide">{svg}</div>\n'
        f'<figcaption>{escape(caption)}</figcaption></figure>'
    )


def section(title: str, *parts: str) -> str:
    """Return a section of ``parts``, each HTML, under a heading, plain text."""
    return '\n'.join([f'<section>\n<h2>{escape(title)}</h2>', *parts, '</section>'])


def paragraph(text: str, kind: str = '') -> str:
    """Return a paragraph of plain text; ``kind`` is its class."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f'<p>{escape(text)}</p>'


def tiles(entries: Iterable[tuple[str, object]]) -> str:
    """Return numbers to be seen at a glance, each with what it is below it; plain text."""
    parts = [f'<div><b>{escape(str(value))}</b><span>{escape(name)}</span></div>'
             for name, value in entries]  # fmt: skip
    return f'<div class="tiles">{"".join(parts)}</div>'


def definitions(entries: Iterable[tuple[str, str]]) -> str:
    """Return a list of terms and what they mean, both plain text."""
    lines = [f'<dt>{escape(term)}</dt><dd>{escape(meaning)}</dd>' for term, meaning in entries]
    return '<dl>\n' + '\n'.join(lines) + '\n</dl>'


def folded(title: str, text: str) -> str:
    """Return preformatted plain text, folded away under its title."""
    return f'<details><summary>{escape(title)}</summary><pre>{escape(text)}</pre></details>'
