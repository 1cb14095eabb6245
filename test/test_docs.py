"""What the documents say can be done: commands parse, links lead somewhere, the example runs."""

import re
import shlex
from pathlib import Path

import pytest

from eventreg_ros.cli.arguments import load_scenario
from eventreg_ros.cli.main import VERBS, build_parser
from eventreg_ros.paper import FIGURES, gallery
from eventreg_ros.robustness.plan import Plan
from eventreg_ros.scenario import load, shipped

ROOT = Path(__file__).resolve().parent.parent
PAGES = [ROOT / 'README.md', *sorted((ROOT / 'docs').glob('**/*.md'))]
CALLS = (['eventreg'], ['python', '-m', 'eventreg_ros'], ['python3', '-m', 'eventreg_ros'])


def commands(text):
    """Return the command lines of ``eventreg`` in Markdown, from code blocks and from `spans`.

    Left out are spans that only name a verb, and patterns: [brackets], dots, PLACEHOLDERS.
    """
    blocks = re.findall(r'^ *```[^\n]*\n(.*?)^ *```', text, re.DOTALL | re.MULTILINE)
    rest = re.sub(r'^ *```[^\n]*\n.*?^ *```', '', text, flags=re.DOTALL | re.MULTILINE)
    lines = [line for block in blocks for line in block.replace('\\\n', ' ').splitlines()]
    spans = [call(span) for span in re.findall(r'`([^`\n]+)`', rest)]
    found = [*map(call, lines), *(words for words in spans if len(words) > 1)]
    return [words for words in found if words and not any(map(is_pattern, words))]


def call(line):
    """Return the arguments of ``eventreg`` on a line of a shell, or nothing."""
    line = re.split(r'\s(?:&&|\|\|?|[<>]|2>|;|&)(?:\s|$)', line.strip().removeprefix('$ '))[0]
    try:
        words = shlex.split(line, comments=True)
    except ValueError:
        return []
    for start in CALLS:
        if [Path(word).name for word in words[: len(start)]] == start:
            return words[len(start) :]
    return []


def is_pattern(word):
    return word.startswith(('[', '{')) or '...' in word or bool(re.fullmatch(r'[A-Z][A-Z.]*', word))


QUOTED = [
    pytest.param(words, id=f'{page.name}: {" ".join(words)}'[:100])
    for page in PAGES
    for words in commands(page.read_text(encoding='utf-8'))
]


@pytest.mark.parametrize('words', QUOTED)
def test_every_command_that_is_quoted_parses(words, capsys):
    verb = next((word for word in words if not word.startswith('-')), None)
    assert verb is None or verb in VERBS
    code, args = parsed(verb, words)
    assert code == 0, capsys.readouterr().err
    if verb == 'sweep' and args.scenario in shipped():
        Plan.of(load(args.scenario), args.overrides, sets=args.sets)
    elif getattr(args, 'scenario', None) in shipped() and hasattr(args, 'overrides'):
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
    assert {'gallery', 'single-neuron'} <= anchors(ROOT / 'docs' / 'gallery.md')


def test_the_gallery_is_what_the_code_makes():
    # Mended by `make figures`.
    text = (ROOT / 'docs' / 'gallery.md').read_text(encoding='utf-8')
    assert text == gallery(FIGURES.values(), 'figures')


def test_the_pictures_of_the_gallery_are_small():
    pictures = {p.stem: p.stat().st_size for p in (ROOT / 'docs' / 'figures').glob('*.svg')}
    assert set(FIGURES) <= set(pictures)
    assert sum(pictures.values()) < 1_500_000


def test_the_example_runs(python):
    result = python(ROOT / 'docs' / 'example.py')
    assert result.stderr == ''
    assert result.returncode == 0
    assert 'verdict: rejected' in result.stdout
    assert 'delay 0.6: not rejected' in result.stdout
    assert 'tau = 0.021: not rejected' in result.stdout
    assert 'hurwitz: pass' in result.stdout
