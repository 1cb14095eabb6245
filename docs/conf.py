# SPDX-License-Identifier: Apache-2.0
"""Settings of Sphinx: `make docs` builds these pages into build/docs."""

import re
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path[:0] = [str(DOCS), str(DOCS.parent)]

import reference  # noqa: E402
from docutils.nodes import SkipNode  # noqa: E402
from latex2mathml.converter import convert  # noqa: E402

import eventreg_ros  # noqa: E402

project = 'eventreg_ros'
author = 'eventreg_ros maintainers'
copyright = '2026, eventreg_ros maintainers'
version = release = eventreg_ros.__version__

extensions = ['myst_nb', 'sphinx.ext.autodoc']
exclude_patterns = ['*.py', 'reference.py', '**/jupyter_execute']
html_theme = 'furo'
html_title = 'eventreg_ros'
html_show_sourcelink = False
html_static_path = ['site']
html_css_files = ['site.css']

myst_enable_extensions = ['dollarmath', 'html_image']
myst_heading_anchors = 3
html_math_renderer = 'mathml'
suppress_warnings = ['myst.header']

# The notebooks are scripts; they are run once, and again when they change.
nb_custom_formats = {'.py': ['jupytext.reads', {'fmt': 'py:percent'}]}
nb_execution_mode = 'cache'
nb_execution_cache_path = str(DOCS.parent / 'build' / 'notebooks')
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_merge_streams = True
nb_render_image_options = {'width': '100%'}

autodoc_typehints = 'signature'
autodoc_type_aliases = {'npt.ArrayLike': 'ArrayLike', 'Given': 'Given'}
python_use_unqualified_type_names = True
autodoc_member_order = 'bysource'

linkcheck_timeout = 20


def read(app, docname, source):
    """Make of a page, as a forge shows it, a page of the site."""
    source[0] = inside(docname, source[0])
    if docname in ('index', 'teaching'):
        source[0] += contents(source[0])


def inside(docname, text):
    """Return the text without links out of the folder of pages, except the README's install."""
    up = r'(?:\.\./)' * (docname.count('/') + 1)
    home = '../' * docname.count('/')
    text = re.sub(rf'\]\({up}README\.md[^)]*\)', f']({home}reference/install.md)', text)
    return re.sub(rf'\[([^\]]+)\]\({up}[^)]*\)', r'\1', text)


def contents(text):
    """Return the lists of links below each heading as a table of contents."""
    found = ''
    for title, below in re.findall(r'^#+ (.+?)\n(.*?)(?=^#|\Z)', text, re.M | re.S):
        links = re.findall(r'^(?:-|\d\.) \[([^\]]+)\]\(([^):]+?)\.(?:md|py)\)', below, re.M)
        pages = [f'{words} <{page}>' for words, page in links]
        if title == 'Reference':
            pages = [f'reference/{name}' for name in reference.PAGES] + pages
        if pages:
            entries = '\n'.join(pages)
            found += f'\n```{{toctree}}\n:hidden:\n:caption: {title}\n\n{entries}\n```\n'
    return found


def mathml(display):
    """Return what writes a formula as MathML, which browsers show by themselves, offline too."""

    def visit(translator, node):
        translator.body.append(convert(node.astext(), display=display))
        raise SkipNode

    return visit, None


def setup(app):
    """Make the pages of the reference before the sources are read."""
    reference.write(DOCS / 'reference')
    app.add_html_math_renderer('mathml', mathml('inline'), mathml('block'))
    app.connect('source-read', read)
