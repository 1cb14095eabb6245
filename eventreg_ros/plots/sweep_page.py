# SPDX-License-Identifier: Apache-2.0
"""The page on a sweep: what was varied, what came of it, and the picture."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import Any

from . import html as page
from .inline_svg import inline_svg


def render_sweep(name: str, parameters: Sequence[str], text: str, picture: Any) -> str:
    """Return the page; ``parameters`` are NODE.PARAM:=SPEC, ``text`` the words of the result."""
    head, *lines = text.splitlines()
    rows = [tuple(parameter.partition(':=')[::2]) for parameter in parameters]
    drawn = inline_svg(picture, f'The results of the sweep of {name}')
    body = [
        f'<h1>{escape(name)}: a sweep</h1>',
        page.paragraph(head, 'muted'),
        *(page.paragraph(line) for line in lines),
        page.section('Picture', page.picture(drawn, 'Colours as in the key.')),
        page.section('Parameters', page.table(('parameter', 'values'), rows, 'wide words')),
    ]
    return page.page(f'Sweep of {name}', body)
