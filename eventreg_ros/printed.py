# SPDX-License-Identifier: Apache-2.0
"""What notebooks show as it is printed."""

from __future__ import annotations

from html import escape


class Printed:
    """A result whose ``str`` is a table: a notebook shows that table."""

    def _repr_html_(self) -> str:
        return f'<pre>{escape(str(self))}</pre>'
