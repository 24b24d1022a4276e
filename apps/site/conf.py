# SPDX-License-Identifier: Apache-2.0
"""Sphinx, for the pages that apps/site/build gathers."""

import re
from importlib.resources import files

from pygments.lexers import TextLexer
from sphinx.highlighting import lexers

project = "mtfkit"
extensions = ["myst_parser"]
myst_heading_anchors = 4
highlight_language = "text"
nitpicky = True
html_theme = "furo"
# Debian's build of the theme leaves out its dark colours.
colors = (files("furo") / "assets/styles/variables/_colors.scss").read_text(encoding="utf-8")
html_theme_options = {"dark_css_variables": dict(re.findall(r"--([\w-]+): *([^;]*);", colors.partition("@mixin colors-dark")[2]))}
pygments_dark_style = "monokai"
html_title = "mtfkit"
# Debian's theme looks for normalize.css on a web server; from files it has to come along, before the theme's own style.
html_static_path = ["site.css", "/usr/share/javascript/normalize.css/normalize.min.css"]
html_css_files = [("normalize.min.css", {"priority": 100}), "site.css"]
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False
lexers["csv"] = TextLexer()
