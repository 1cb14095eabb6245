"""How it looks: style, figures, the page."""
