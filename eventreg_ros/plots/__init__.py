# SPDX-License-Identifier: Apache-2.0
"""How it looks: style, figures, the page."""
