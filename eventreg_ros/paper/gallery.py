# SPDX-License-Identifier: Apache-2.0
"""The page that shows the figures: each with what to see, its parameters and its commands."""

from __future__ import annotations

import re
from collections.abc import Iterable
from textwrap import fill

from .figure import Case, PaperFigure, parameters, scenarios_of
from .identified import IdentifiedFigure
from .swept import SweptFigure

Figure = PaperFigure | SweptFigure | IdentifiedFigure

HEAD = """\
# Gallery

The four figures of the paper, what it argues in words as figures, and what goes beyond it. This
page and its pictures are made by `make figures`; `eventreg figures --out DIR` makes them as PDF,
SVG and PNG at the width of a paper's column, `--data` adds the numbers of each as a csv file, and
`-p NODE.PARAM:=VALUE` draws them for other parameters.

Time is the paper's (model time). The grey area is the settling time, in which events are not
counted. Colours are distinct with any kind of colour vision, and lines without colour.
What the paper does not give (initial states, durations, the pulses v) is ours; see the commands.
"""


PIXELS = 560


def gallery(figures: Iterable[Figure], pictures: str) -> str:
    """Return the page as Markdown; ``pictures`` is the folder of the svg files, seen from it."""
    return '\n'.join([HEAD, *(_section(figure, pictures) for figure in figures)])


def _section(figure: Figure, pictures: str) -> str:
    sentence = figure.caption.partition('. ')[0].rstrip('.')
    return f"""\
## {figure.name.replace('_', ' ').capitalize()}

<img src="{pictures}/{figure.name}.svg" width="{PIXELS}" alt="{sentence}">

{_filled(figure.caption)}

{_about(figure)}

{_commands(figure)}"""


def _about(figure: Figure) -> str:
    beyond = figure.source.startswith('Beyond')
    source = _filled(f'- {figure.source}' if beyond else f'- In the paper: {figure.source}')
    if not isinstance(figure, PaperFigure):
        return source
    symbols = parameters(scenarios_of(figure).values(), figure.symbols)
    return f'{source}\n- Parameters: {", ".join(symbols)}.'


def _filled(text: str) -> str:
    return fill(text, 100, subsequent_indent='  ' * text.startswith('- '))


def _commands(figure: Figure) -> str:
    made = f'eventreg figures {figure.name}\n'
    if not isinstance(figure, PaperFigure):
        return (
            f'```console\n{made}'
            + ''.join(f'{c.command}\n' for c in figure.cases.values())
            + '```\n'
        )
    runs = ''.join(f'{command(case, figure.duration)}\n' for case in figure.cases.values())
    if len(figure.cases) == 1:
        return f'```console\n{made}{runs}```\n'
    summary = f'<details><summary>Its {len(figure.cases)} runs</summary>'
    return f'```console\n{made}```\n\n{summary}\n\n```console\n{runs}```\n\n</details>\n'


def command(case: Case, duration: float) -> str:
    """Return the command line that simulates ``case`` by itself."""
    words = ['eventreg simulate', case.scenario, *(['--sampled'] if case.sampled else [])]
    words.append(f'--duration {duration:g}')
    words += [f'-p {_quoted(override)}' for override in case.overrides]
    return ' '.join([*words, *(f'--at {_quoted(action)}' for action in case.at)])


def _quoted(word: str) -> str:
    return word if re.fullmatch(r'[\w.:=/*-]+', word) else f'"{word}"'
