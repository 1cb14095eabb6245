# SPDX-License-Identifier: Apache-2.0
"""What the documents say can be done: commands parse, links lead somewhere, the example runs."""

import importlib.util
import json
import re
import shlex
from pathlib import Path
from xml.etree import ElementTree

import pytest

import eventreg_ros
from eventreg_ros import scenario
from eventreg_ros.analysis.verdict import EXIT_CODES
from eventreg_ros.cli.arguments import load_scenario
from eventreg_ros.cli.epilogs import EPILOGS
from eventreg_ros.cli.live_report import BROKEN
from eventreg_ros.cli.main import VERBS, build_parser, main
from eventreg_ros.cli.process import PIPE_CLOSED
from eventreg_ros.errors import BAD_INPUT, CRASHED
from eventreg_ros.interrupts import INTERRUPTED
from eventreg_ros.models.catalogue import model_names
from eventreg_ros.models.roles import SIGNALS
from eventreg_ros.paper import FIGURES, gallery
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.scenario import load, shipped
from eventreg_ros.scenario.names import KINDS
from eventreg_ros.scenario.parameters import parameters_of

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / 'docs'
REFERENCE = DOCS / 'reference'  # made when the site is built
NOTEBOOKS = sorted((DOCS / 'notebooks').glob('*.py'))
PAGES = [
    ROOT / 'README.md',
    *(page for page in sorted(DOCS.glob('**/*.md')) if REFERENCE not in page.parents),
]
CALLS = (['eventreg'], ['python', '-m', 'eventreg_ros'], ['python3', '-m', 'eventreg_ros'])


def commands(text):
    """Return the command lines of ``eventreg`` in Markdown, from code blocks and from `spans`.

    Left out are spans that only name a verb, and patterns: [brackets], dots, PLACEHOLDERS.
    """
    blocks = re.findall(r'^ *```[^\n]*\n(.*?)^ *```', text, re.DOTALL | re.MULTILINE)
    rest = re.sub(r'^ *```[^\n]*\n.*?^ *```', '', text, flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in re.sub(r' *\\\n *', ' ', block).splitlines()]
    spans = [call(span) for span in re.findall(r'`([^`\n]+)`', rest)]
    found = [*map(call, lines), *(words for words in spans if len(words) > 1)]
    return [words for words in found if words and not any(map(is_pattern, words))]


def call(line):
    """Return the arguments of ``eventreg`` on a line of a shell, or nothing.

    What stands behind two spaces is an explanation.
    """
    line = re.split(r'\s(?:&&|\|\|?|[<>]|2>|;|&|\s)(?:\s|$)?', line.strip().removeprefix('$ '))[0]
    try:
        words = shlex.split(line, comments=True)
    except ValueError:
        return []
    for start in CALLS:
        if [Path(word).name for word in words[: len(start)]] == start:
            return words[len(start) :]
    return []


def blocks(text, language):
    """Return the code blocks of a language, without what indents them."""
    found = re.findall(rf'^( *)```{language}\n(.*?)^ *```', text, re.DOTALL | re.MULTILINE)
    return [re.sub(rf'^{indent}', '', block, flags=re.MULTILINE) for indent, block in found]


def scenarios_in(text):
    """Return the scenarios that a page writes out, by file: blocks that begin with # NAME.yaml."""
    found = [(re.match(r'# (\w+\.yaml)\b', block), block) for block in blocks(text, 'yaml')]
    return {name[1]: block for name, block in found if name}


def is_pattern(word):
    return word.startswith(('[', '{')) or '...' in word or bool(re.fullmatch(r'[A-Z][A-Z.]*', word))


TEXTS = {page.name: page.read_text(encoding='utf-8') for page in PAGES} | {
    f'eventreg {verb} --help': f'```\n{epilog}\n```' for verb, epilog in EPILOGS.items()
}
QUOTED = [
    pytest.param(text, words, id=f'{name}: {" ".join(words)}'[:100])
    for name, text in TEXTS.items()
    for words in commands(text)
]


@pytest.mark.parametrize(('text', 'words'), QUOTED)
def test_every_command_that_is_quoted_parses(text, words, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    written = scenarios_in(text)
    for name, lines in written.items():
        (tmp_path / name).write_text(lines, encoding='utf-8')
    verb = next((word for word in words if not word.startswith('-')), None)
    assert verb is None or verb in VERBS
    code, args = parsed(verb, words)
    assert code == 0, capsys.readouterr().err
    if verb == 'sweep' and args.scenario in shipped():
        Plan.of(load(args.scenario), args.overrides, sets=args.sets or (1 if args.worst else None))
    elif getattr(args, 'scenario', None) in {*shipped(), *written} and hasattr(args, 'overrides'):
        implicit = ('spike_monitor', 'recorder', 'clock') if verb == 'run' else ()
        load_scenario(args, implicit).with_links(getattr(args, 'links', ()))
    assert set(getattr(args, 'names', ())) <= set(FIGURES)


def parsed(verb, words):
    try:
        return 0, build_parser(verb).parse_args(words)
    except SystemExit as stop:
        return stop.code, None


def test_a_command_that_does_not_parse_is_seen():
    assert parsed('simulate', ['simulate', 'exact', '--help'])[0] == 0
    assert parsed('simulate', ['simulate', 'exact', '--nonsense'])[0] == 2


def test_commands_are_found_in_blocks_and_in_spans():
    text = (
        'Type `eventreg simulate exact`, not `eventreg simulate`\n'
        'nor `eventreg simulate SCENARIO [--sampled]`.\n'
        '```console\n$ eventreg figures linear \\\n  --data && ls  # all\n$ ls\n```\n'
        '1. So:\n   ```\n   .venv/bin/eventreg run exact > log\n   ```\n'
        '`python -m eventreg_ros simulate open -p "plant.x0:=[0.5, 0]"`\n'
    )
    assert commands(text) == [
        ['figures', 'linear', '--data'],
        ['run', 'exact'],
        ['simulate', 'exact'],
        ['simulate', 'open', '-p', 'plant.x0:=[0.5, 0]'],
    ]
    assert len(QUOTED) > len(FIGURES)


def targets(text):
    """Return the targets of links and pictures in Markdown."""
    text = re.sub(r'^ *```.*?^ *```', '', text, flags=re.DOTALL | re.MULTILINE)
    return [
        *re.findall(r'\]\(([^)\s]+)(?:\s+"[^"]*")?\)', text),
        *re.findall(r'^\[[^\]]+\]:\s+(\S+)', text, re.MULTILINE),
        *re.findall(r'(?:src|href)="([^"]+)"', text),
    ]


def anchors(page):
    """Return the anchors that GitHub gives the headings of a page."""
    headings = re.findall(r'^#+ +(.+?) *$', page.read_text(encoding='utf-8'), re.MULTILINE)
    return {re.sub(r'[^\w\- ]', '', h.lower()).replace(' ', '-') for h in headings}


@pytest.mark.parametrize('page', PAGES, ids=lambda page: page.name)
def test_relative_links_and_pictures_exist(page):
    for target in targets(page.read_text(encoding='utf-8')):
        if re.match(r'[a-z]+:', target):
            continue
        name, _, anchor = target.partition('#')
        path = page.parent / name if name else page
        assert path.exists(), f'{page.name} points to {target}'
        if anchor and path.suffix == '.md':
            assert anchor in anchors(path), f'{page.name} points to {target}'


def test_targets_and_anchors_are_found():
    text = '[a](b.md#c) ![p](q.svg "t") <img src="d.png">\n[e]: f.md\n```\n[x](y)\n```\n'
    assert targets(text) == ['b.md#c', 'q.svg', 'f.md', 'd.png']
    assert {'gallery', 'single-neuron'} <= anchors(DOCS / 'gallery.md')


def test_the_gallery_is_what_the_code_makes():
    # `make figures` makes it anew.
    text = (DOCS / 'gallery.md').read_text(encoding='utf-8')
    assert text == gallery(FIGURES.values(), 'figures')


def test_the_pictures_of_the_gallery_are_small():
    pictures = {p.stem: p.stat().st_size for p in (DOCS / 'figures').glob('*.svg')}
    assert set(FIGURES) <= set(pictures)
    assert sum(pictures.values()) < 1_600_000


@pytest.mark.slow
def test_the_example_runs(python):
    result = python(DOCS / 'example.py')
    assert result.stderr == ''
    assert result.returncode == 0
    assert 'verdict: rejected' in result.stdout
    assert 'delay 0.6: not rejected' in result.stdout
    assert 'tau = 0.021: not rejected' in result.stdout
    assert 'hurwitz: pass' in result.stdout


# Scenarios, Python and notebooks


@pytest.mark.parametrize(
    'text',
    [
        pytest.param(lines, id=f'{name}: {file}')
        for name, text in TEXTS.items()
        for file, lines in scenarios_in(text).items()
    ],
)
def test_every_scenario_that_is_written_out_is_one(text):
    assert scenario.parse(text, 'page').nodes


PYTHON = [name for name, text in TEXTS.items() if blocks(text, 'python')]


@pytest.mark.slow
@pytest.mark.parametrize('page', PYTHON)
def test_the_python_of_a_page_runs(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    python = blocks(TEXTS[page], 'python')
    for words in commands(TEXTS[page]):
        if '--out' in words and f"'{words[words.index('--out') + 1]}/" in '\n'.join(python):
            assert main(words) == 0
    names, missing = {}, []
    for block in python:
        if re.search("'[A-Z]+'", block):
            continue  # it names what only the reader has: 'BAG'
        try:
            exec(block, names)
        except ModuleNotFoundError as error:
            missing.append(error.name)
    assert not [name for name in missing if name.startswith('eventreg_ros')]
    if missing:
        pytest.skip(f'not installed: {", ".join(missing)}')


@pytest.mark.slow
@pytest.mark.parametrize(
    ('notebook', 'found'),
    [
        ('excitability', 'k = 0.5: 12 events'),
        ('linear_motif', 'measured: -0.215'),
        ('internal_models', 'tau wrong by    2: not rejected'),
        ('one_neuron', 'one neuron:  |u| 4.'),
        ('delay', 'only w late by 0.6: rejected'),
    ],
)
def test_the_notebooks_run_and_show_what_they_say(notebook, found, python):
    result = python(DOCS / 'notebooks' / f'{notebook}.py')
    assert result.stderr == ''
    assert result.returncode == 0
    assert found in result.stdout


def test_every_notebook_is_run_and_on_the_page_for_teachers():
    names = {path.name for path in NOTEBOOKS}
    on_page = {Path(target).name for target in targets(TEXTS['teaching.md'])}
    assert names == {name for name in on_page if name.endswith('.py')}
    assert len(names) == 5


# The site


@pytest.fixture(scope='module')
def reference():
    """The module that makes the pages of the reference."""
    spec = importlib.util.spec_from_file_location('reference', DOCS / 'reference.py')
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_every_page_is_on_the_start_page_and_in_the_readme():
    linked = {(DOCS / target).resolve() for target in targets(TEXTS['index.md'])}
    pages = {page for page in PAGES if page.parent != ROOT}
    assert linked == pages - {DOCS / 'index.md'}
    named = {(ROOT / target).resolve() for target in targets(TEXTS['README.md'])}
    assert pages - named == set()


def test_the_reference_names_every_parameter_with_its_rule(reference):
    text = reference.parameters()
    sections = dict(re.findall(r'^## (\w+)\n(.*?)(?=^## |\Z)', text, re.DOTALL | re.MULTILINE))
    assert list(sections) == list(KINDS)
    for kind, section in sections.items():
        cells = [line.strip('| ').split(' | ') for line in section.strip().splitlines()[2:]]
        rows = parameters_of(kind)
        assert [cell[0] for cell in cells] == [f'`{name}`' for name in rows]
        assert all(len(cell) == 6 and all(cell) for cell in cells)


@pytest.mark.slow
def test_the_reference_shows_every_command_model_and_scenario(reference):
    commands, models, scenarios = reference.commands(), reference.models(), reference.scenarios()
    assert all(f'## eventreg {verb}\n' in commands for verb in VERBS)
    assert 'usage: eventreg simulate' in commands
    assert all(f'## {name}' in models for name in model_names())
    assert all(f'## {name}\n' in scenarios for name in shipped())
    assert 'make demo' in reference.install()


def test_the_reference_shows_every_topic(reference):
    topics = pytest.importorskip('eventreg_ros.nodes.topics', reason='needs ROS 2')
    text = reference.topics()
    for topic in (topics.COUNT, topics.EVENT, topics.DIAGNOSTICS, topics.CLOCK, topics.VERDICT):
        assert f'| `{topic.name}` | `{topic.type_name}` |' in text


def test_the_reference_shows_the_whole_library(reference):
    text = reference.library()
    assert all(f'eventreg_ros.{name}\n' in text for name in eventreg_ros.__all__)


# What is written by hand, and could be forgotten


def keys(data):
    """Yield the keys of JSON, except the names of signals and figures."""
    for key, value in data.items():
        if not re.fullmatch(r'(w|v|y|y_r|u)(_2)?(/tau)?|\w+\.\w+', key):
            yield key
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, dict) and key not in ('numbers', 'seen'):
                yield from keys(each)


JSON_OF = {
    'simulate': ['unknown', '--at', '300:controller.k:=3', '--duration', '700'],
    'analyze': [],
    'compare': ['exact', 'mismatch'],
    'certify': ['linear', '--time', '60'],
    'sweep': ['exact', '-p', 'controller.k:=2', '--duration', '150'],
}


@pytest.mark.slow
@pytest.mark.parametrize('verb', JSON_OF)
def test_the_page_on_json_names_every_key(verb, tmp_path, make_bag):
    what = JSON_OF[verb] or [str(make_bag(w=[110, 140, 170, 200], y=[], u=[]))]
    main([verb, *what, '--json', str(tmp_path / 'x.json')])
    data = json.loads((tmp_path / 'x.json').read_text())
    assert {key for key in keys(data) if f'`{key}`' not in TEXTS['json.md']} == set()


def test_the_page_on_exit_codes_has_them():
    text = TEXTS['exit_codes.md']
    for verdict, code in EXIT_CODES.items():
        assert re.search(rf'^\| {code} \|.*`{verdict}`', text, re.MULTILINE)
    for code in (BAD_INPUT, BROKEN, CRASHED, INTERRUPTED, PIPE_CLOSED):
        assert f'\n| {code} |' in text


def test_every_picture_names_the_command_that_drew_it():
    drawn = re.compile(r'eventreg figures ([\w ]+)|--plot (\S+\.svg)|make (picture)')
    missing = []
    for page in PAGES:
        text = page.read_text(encoding='utf-8')
        commands = ' '.join(' '.join(filter(None, found)) for found in drawn.findall(text))
        for stem in re.findall(r'figures/(\w+)\.svg"|\]\(\S*?figures/(\w+)\.svg\)', text):
            name = stem[0] or stem[1]
            if not any(word in commands for word in (name, name.removeprefix('sweep_'))):
                missing.append(f'{page.name}: {name}')
        if 'demo.png' in text and 'picture' not in commands:
            missing.append(f'{page.name}: demo')
    assert missing == []


def test_the_layouts_show_topics_that_there_are():
    juggler = ElementTree.parse(ROOT / 'layouts' / 'plotjuggler.xml')
    curves = {curve.get('name') for curve in juggler.iter('curve')}
    panels = json.loads((ROOT / 'layouts' / 'lichtblick.json').read_text())['configById']
    paths = {path['value'] for panel in panels.values() for path in panel.get('paths', ())}
    topics = {*SIGNALS, *(f'spikes/{signal}/count' for signal in ('w', 'u', 'y'))}
    assert curves == {f'/{topic}/data' for topic in topics}
    assert paths == {f'/{topic}.data' for topic in topics} | {'1.0'}
    for name, panel in panels.items():  # what Lichtblick and Foxglove call a panel's title
        titles = {panel.get('lichtblickPanelTitle'), panel.get('foxglovePanelTitle')}
        assert len(titles) == 1
        assert titles != {None} or name.startswith('DiagnosticSummary')


def test_every_file_that_a_page_names_is_there():
    missing = []
    for page in [*PAGES, ROOT / 'CONTRIBUTING.md']:
        text = re.sub(r'^ *```.*?^ *```', '', page.read_text(encoding='utf-8'), flags=re.S | re.M)
        for path in re.findall(r'`((?:\w+/)+\w+\.(?:py|c|json|xml))\b', text):
            if not any((home / path).exists() for home in (ROOT, ROOT / 'eventreg_ros')):
                missing.append(f'{page.name}: {path}')
    assert missing == []
