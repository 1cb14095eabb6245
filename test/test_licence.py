# SPDX-License-Identifier: Apache-2.0
"""Every source says its licence in its first lines, as tools read it (SPDX)."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LINE = 'SPDX-License-Identifier: Apache-2.0'


def test_every_source_says_its_licence():
    if not (ROOT / '.git').exists():
        pytest.skip('needs git: what is tracked is what is checked')
    command = ['git', 'ls-files', '*.py', '*.c', 'resource/executables/*', '.ci/run']
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    paths = [ROOT / name for name in listed.splitlines() if (ROOT / name).exists()]
    assert len(paths) > 100
    silent = [path.name for path in paths if LINE not in path.read_text()[:200]]
    assert silent == [], f'begin them with: # {LINE}'
