# SPDX-License-Identifier: Apache-2.0
"""A matplotlib figure as an svg element of a page, whose policy allows no style in attributes."""

from __future__ import annotations

import io
import re
from html import escape
from typing import Any

from .style import METADATA, style


def inline_svg(figure: Any, label: str) -> str:
    """Return ``figure`` as an svg element that fits its container; ``label`` says what it shows."""
    text = io.StringIO()
    with style():
        figure.savefig(text, format='svg', metadata=METADATA['svg'])
    svg = text.getvalue()
    svg = svg[svg.index('<svg') :].strip()
    svg = re.sub(r'<metadata>.*?</metadata>|<style.*?</style>', '', svg, flags=re.DOTALL)
    svg = re.sub(r'<g id="[^"]*"', '<g', svg)
    svg = re.sub(r' style="([^"]*)"', lambda found: _attributes(found[1]), svg)
    box = re.findall(r'viewBox="[^"]*"', svg)[0]
    return (
        f'<svg {box} role="img" aria-label="{escape(label)}" stroke-linejoin="round" '
        f'stroke-linecap="butt">{svg[svg.index(">") + 1 :]}'
    )


def _attributes(declarations: str) -> str:
    """Return style declarations as presentation attributes."""
    pairs = (each.partition(':') for each in declarations.split(';') if ':' in each)
    return ''.join(f' {name.strip()}="{value.strip()}"' for name, _, value in pairs)
