# SPDX-License-Identifier: Apache-2.0
"""The pages of docs/reference/, made from the tables of the code when the site is built."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

import eventreg_ros
from eventreg_ros.models.catalogue import LINEAR, model_names, model_of
from eventreg_ros.models.model import Model
from eventreg_ros.models.roles import ROLES, SIGNALS
from eventreg_ros.nodes.executables import shown
from eventreg_ros.scenario import files
from eventreg_ros.scenario.names import KINDS, OUTPUTS
from eventreg_ros.scenario.parameter import Parameter
from eventreg_ros.scenario.parameters import parameters_of

GENERATED = '<!-- Made by docs/reference.py; a change here is lost. -->\n\n'

MEANINGS = {
    'w': 'the disturbance',
    'v': 'the measured open input of plant and reference',
    'y': "the plant's output",
    'y_r': 'the output of the unperturbed plant',
    'u': 'the control action',
}


def write(folder: Path) -> None:
    """Write all pages into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, page in PAGES.items():
        (folder / f'{name}.md').write_text(GENERATED + page(), encoding='utf-8')


def install() -> str:
    """Return the README's sections on installing."""
    readme = (Path(__file__).resolve().parent.parent / 'README.md').read_text(encoding='utf-8')
    start, stop = (readme.index(f'## {heading}') for heading in INSTALLING)
    text = readme[start:stop].replace('(#watching-and-steering-a-run)', '(../watch.md)')
    return f'# Installing\n\n{text}'


INSTALLING = ('On a bare machine', 'Watching and steering a run')
"""The README's heading where installing begins, and the one before which it ends."""


def parameters() -> str:
    """Return the page of parameters: a table for each kind of node."""
    parts = [
        '# Parameters\n\n'
        'Every parameter of every node. Times are in the unit that the meaning gives; model time '
        "is the paper's time, and `time_scale` units of it pass in a second. *Set while* says "
        'until which state of the node a parameter can be set: `active` ones at any time, '
        '`started` ones, which name files, only as the node is started. '
        'Another `model` brings parameters of its own: [Models](models.md). '
        '`eventreg node NAME --help` prints the same as this page.'
    ]
    for kind in KINDS:
        rows = parameters_of(kind).values()
        parts.append(f'## {kind}\n\n{table(PARAMETER, map(parameter_row, rows))}')
    return '\n\n'.join(parts) + '\n'


PARAMETER = ('parameter', 'meaning', 'type', 'default', 'rule', 'set while')


def parameter_row(row: Parameter) -> Sequence[str]:
    """Return a row of the table of parameters."""
    default = shown(row.default)
    return (f'`{row.name}`', row.doc, row.type, f'`{default}`', row.rule, row.settable)


def models() -> str:
    """Return the page of models: what each one is, and its parameters."""
    parts = [
        '# Models\n\n'
        'What `model` may be. A package of yours adds one by the entry point '
        '`eventreg_ros.models`: see [Your own plant](../own_plant.md).'
    ]
    for name in model_names():
        found = {role: model_of(role, name) for role in LINEAR if name == 'linear'}
        for role, model in (found or {'': model_of('plant', name)}).items():
            title = f'{name}, as {role}' if role else name
            parts.append(f'## {title}\n\n{model_text(model)}')
    return '\n\n'.join(parts) + '\n'


def model_text(model: Model) -> str:
    """Return what one model is: its equations in words, its states, its parameters."""
    what = (model.rhs.__doc__ or '').partition('\n\n')[0]
    lines = [f'{" ".join(what.split())} States: {model.dimension}.'.replace('``', '`')]
    rows = [
        (
            f'`{p.name}`',
            'by role' if p.default is None else f'{p.default:g}',
            p.unit,
            'yes' if p.live else 'no',
            p.doc,
        )
        for p in model.parameters
    ]
    if rows:
        lines.append(table(('parameter', 'default', 'unit', 'set while active', 'meaning'), rows))
    return '\n\n'.join(lines)


def topics() -> str:
    """Return the page of topics."""
    from eventreg_ros.nodes import topics as module

    found = [each for each in vars(module).values() if isinstance(each, module.Topic)]
    rows = [
        (
            f'`{topic.name}`',
            f'`{topic.type_name}`',
            str(topic.depth),
            'transient local' if topic.latched else 'volatile',
            topic.meaning,
        )
        for topic in found
        if topic.meaning
    ]
    signals = [
        (f'`{signal}`', ', '.join(k for k, o in OUTPUTS.items() if o == signal), MEANINGS[signal])
        for signal in SIGNALS
    ]
    wires = [
        (
            f'`{role.name}`',
            ' '.join([f'+`{s}`' for s in role.excitatory] + [f'-`{s}`' for s in role.inhibitory]),
            f'`{role.output}`',
        )
        for role in ROLES.values()
    ]
    return (
        '# Topics\n\nAll names without a leading slash are relative: they follow the namespace '
        'and remapping. Every topic is reliable; `qos_overrides` change that '
        '([In a ROS workspace](../ros.md)).\n\n'
        f'## Signals\n\n{table(("signal", "from", "meaning"), signals)}\n\n'
        'A block with a suffix adds it to its output: `exosystem_2` publishes `w_2`. A controller '
        'that learns publishes what it has learned beside its output: `u/tau`.\n\n'
        f'{table(("block", "listens to", "publishes"), wires)}\n\n'
        f'## All topics\n\n{table(("topic", "type", "depth", "durability", "who, what"), rows)}\n'
    )


def scenarios() -> str:
    """Return the page of shipped scenarios, with their files."""
    parts = [
        '# Scenarios\n\n'
        'The shipped ones, as `eventreg list` names them. `eventreg new mine.yaml --from NAME` '
        'copies one; [Your own scenario](../your_scenario.md) says how to write one.'
    ]
    for name in files.shipped():
        text = (files.config_directory() / f'{name}.yaml').read_text(encoding='utf-8')
        parts.append(f'## {name}\n\n{files.summary(name)}\n\n```yaml\n{text}```')
    return '\n\n'.join(parts) + '\n'


def commands() -> str:
    """Return the page of commands: the help of each, as it is printed."""
    verbs = re.findall(r'^    (\w+)\b', help_of(), re.MULTILINE)
    parts = ['# Commands\n\n' + console(help_of())]
    parts += [f'## eventreg {verb}\n\n{console(help_of(verb))}' for verb in verbs]
    return '\n\n'.join(parts) + '\n'


def help_of(*verb: str) -> str:
    """Return what ``eventreg VERB --help`` prints."""
    root = Path(eventreg_ros.__file__).resolve().parent.parent
    environment = {**os.environ, 'PYTHONPATH': str(root), 'COLUMNS': '96'}
    return subprocess.run(
        [sys.executable, '-m', 'eventreg_ros', *verb, '--help'],
        env=environment, capture_output=True, text=True, check=True,
    ).stdout  # fmt: skip


def console(text: str) -> str:
    """Return a block of text as a terminal shows it."""
    return f'```text\n{text.rstrip()}\n```'


def library() -> str:
    """Return the page of the library, whose entries Sphinx takes from the docstrings."""
    names = sorted(eventreg_ros.__all__)
    results = [name for name in names if isinstance(getattr(eventreg_ros, name), type)]
    parts = [LIBRARY]
    for title, group in (('Functions', set(names) - set(results)), ('Results', set(results))):
        parts.append(f'## {title}')
        parts += [entry(name) for name in sorted(group)]
    return '\n\n'.join(parts) + '\n'


LIBRARY = """\
# The library

```python
from eventreg_ros import simulate

run = simulate('exact', {'controller.k': 3})
print(run)                      # the table of the command, with the verdict
run['y'], run.t, run.events['w']
run.plot()                      # in a notebook: a picture
```

`from eventreg_ros import ...`; nothing of it prints. Times are in model time unless a docstring
says seconds. What is wrong raises `eventreg_ros.errors.EventregError`, one line with the remedy.
*Given* is a scenario: the name of a shipped one, the path of a file, or what `load` returns.
Overrides are parameters, `{'controller.k': 3}` or `'controller.k:=3'`. Examples without `SKIP` are
run by the tests."""


def entry(name: str) -> str:
    """Return what Sphinx makes of one public name."""
    if not isinstance(getattr(eventreg_ros, name), type):
        return f'### {name}\n\n```{{eval-rst}}\n.. autofunction:: eventreg_ros.{name}\n```'
    options = '   :members:\n   :inherited-members: object\n'
    return f'### {name}\n\n```{{eval-rst}}\n.. autoclass:: eventreg_ros.{name}\n{options}```'


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ['---'] * len(head), *rows]
    cells = [[cell.replace('|', '\\|') for cell in row] for row in lines]
    return '\n'.join(f'| {" | ".join(row)} |' for row in cells)


PAGES = {
    'install': install,
    'parameters': parameters,
    'models': models,
    'topics': topics,
    'scenarios': scenarios,
    'commands': commands,
    'library': library,
}
"""The pages by name, in their order in the table of contents."""


if __name__ == '__main__':
    write(Path(__file__).parent / 'reference')
