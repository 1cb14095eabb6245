# SPDX-License-Identifier: Apache-2.0
"""The bare page: everything that comes from outside is escaped here; nothing is ever fetched."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Iterable, Sequence
from hashlib import sha256
from html import escape

from .page_script import SCRIPT
from .page_style import STYLE

HATCH = (
    '<svg width="0" height="0" aria-hidden="true"><defs><pattern id="hatch" width="6" height="6" '
    'patternUnits="userSpaceOnUse"><path class="hatch" d="M-1 1L1-1M0 6L6 0M5 7L7 5"/></pattern>'
    '</defs></svg>'
)
"""What fills the unseen stretches of charts."""

HINT = (
    'Charts: + and - zoom, the arrow keys move, 0 shows all, once a chart has the focus; or drag, '
    'double-click, and Ctrl with the wheel. Those of one span move together.'
)


def page(title: str, body: Iterable[str]) -> str:
    """Return a whole HTML document that needs nothing from the network.

    Its policy forbids every request, and every script and style but ours, by their hashes.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'<meta http-equiv="Content-Security-Policy" content="{policy()}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n{HATCH}\n'
        + '\n'.join(body)
        + f'\n<script>{SCRIPT}</script>\n</body>\n</html>\n'
    )


def policy() -> str:
    """Return the content security policy of a page; maps hold images of their own (data:)."""
    script, style = (b64encode(sha256(s.encode()).digest()).decode() for s in (SCRIPT, STYLE))
    return (
        f"default-src 'none'; script-src 'sha256-{script}'; style-src 'sha256-{style}'; "
        'img-src data:; '
        "base-uri 'none'; form-action 'none'"
    )


def table(
    head: Sequence[str], rows: Iterable[Sequence[object]], kind: str = 'wide', name: str = ''
) -> str:
    """Return a table of plain text; ``kind`` is its container's class: wide, long or words.

    The container scrolls by itself, and by keyboard; ``name`` is what it is called there.
    """
    lines = [f'<tr>{"".join(f"<td>{escape(str(cell))}</td>" for cell in row)}</tr>' for row in rows]
    header = ''.join(f'<th scope="col">{escape(cell)}</th>' for cell in head)
    return (
        f'<div class="{kind}" tabindex="0" role="region" '
        f'aria-label="{escape(name or ", ".join(head))}"><table>\n'
        f'<thead><tr>{header}</tr></thead>\n<tbody>\n'
        + '\n'.join(lines)
        + '\n</tbody></table></div>'
    )


def picture(svg: str, caption: str) -> str:
    """Return a picture, an svg element of ours, with its caption, plain text."""
    return (
        f'<figure class="picture"><div class="wide">{svg}</div>\n'
        f'<figcaption>{escape(caption)}</figcaption></figure>'
    )


def section(title: str, *parts: str) -> str:
    """Return a section of ``parts``, each HTML, under a heading, plain text."""
    return '\n'.join([f'<section>\n<h2>{escape(title)}</h2>', *parts, '</section>'])


def heading(title: str) -> str:
    """Return a heading within a section, plain text."""
    return f'<h3>{escape(title)}</h3>'


def paragraph(text: str, kind: str = '') -> str:
    """Return a paragraph of plain text; ``kind`` is its class."""
    return f'<p class="{kind}">{escape(text)}</p>' if kind else f'<p>{escape(text)}</p>'


def hint() -> str:
    """Return how charts are looked at closely; it shows where the script runs."""
    return f'<p class="hint muted" hidden>{escape(HINT)}</p>'


def items(texts: Iterable[str]) -> str:
    """Return a list of plain texts."""
    return '<ul>\n' + '\n'.join(f'<li>{escape(text)}</li>' for text in texts) + '\n</ul>'


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
