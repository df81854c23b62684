"""Settings of the documentation site: sphinx -b html docs docs/_build/html."""

from __future__ import annotations

import logging
import os
import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "src"))

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.util.docutils import SphinxDirective

import squama
from squama.beam.beamfile import MODULUS, SIZE, TABLES
from squama.joints import law
from squama.model.joint import LAWS
from squama.plot import style

project = "squama"
author = "The squama developers"
copyright = "The squama developers"
version = release = squama.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx-mathjax-offline"]
exclude_patterns = ["_build", "api", "images/*.py"]
# `make test` builds pages without the output of their cells, which its tests execute
nb_execution_mode = "off" if tags.has("quick") else "force"  # noqa: F821 - Sphinx gives the name to this file
suppress_warnings = ["myst-nb.lexer"]  # cells without a kernel
nb_execution_excludepatterns = ["tutorial*.ipynb"]  # with outputs of their own; tests/unit/test_tutorial.py runs them
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_output_stderr = "remove"
myst_enable_extensions = ["amsmath", "dollarmath", "deflist"]
myst_heading_anchors = 3
smartquotes_action = "qe"  # quotes and ellipses: two hyphens begin a flag

autodoc_typehints = "none"
autodoc_member_order = "bysource"
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_param = False

html_theme = "furo"
html_title = f"squama {version}"
html_show_sphinx = False
html_show_copyright = False
html_static_path = ["static"]
html_css_files = ["pages.css"]


def symbols() -> list[str]:
    """Rows of the table of symbols."""
    rows = ["| name | symbol | unit | meaning | source |", "|---|---|---|---|---|"]
    for s in squama.SYMBOLS.values():
        tex = f"${s.tex}$" if s.tex else ""
        rows.append(f"| `{s.name}` | {tex} | {s.unit or 'text'} | {s.long_name} | {s.equation} |")
    return rows


def keys() -> list[str]:
    """Rows of the table of keys of a beam; the page itself has the limits of lengths and moduli."""
    rows = ["| key | meaning | example |", "|---|---|---|"]
    for table, content in TABLES.items():
        for name, key in content.items():
            common = key.bounds is None or key.bounds.allowed in (SIZE.allowed, MODULUS.allowed)
            allowed = "" if common else f"; {key.bounds.allowed.removeprefix('more than 0; ')}"
            rows.append(f"| `{table}.{name}` | {key.meaning}{allowed} | `{key.example}` |")
    return rows


def joint_laws() -> list[str]:
    """Rows of the table of scaling laws and their ranges."""
    rows = ["| law | formula | source | ranges |", "|---|---|---|---|"]
    for each in LAWS.values():
        limits = "; ".join(f"`{x.ratio}` {x.low:g} to {x.high:g} ({x.reason})" for x in each.limits)
        rows.append(f"| {each.name} | `{each.formula}` | {each.source} | {limits or 'none'} |")
    return rows


def law_ranges() -> list[str]:
    """Rows of the table of ranges of the law of the joint."""
    rows = ["| key | core, from | to | whole range, from | to | |", "|---|---|---|---|---|---|"]
    for core, r in zip(law.CORE, law.WHOLE, strict=True):
        ends = f"{core.low:g} | {core.high:g}{core.unit} | {r.low:g} | {r.high:g}{r.unit}"
        rows.append(f"| `{r.key}` | {ends} | {r.part} |")
    return rows


def law_errors() -> list[str]:
    """Rows of the table of errors of the law of the joint."""
    (core, *errors), (beyond, *others) = law.errors(), law.errors(law.WHOLE)
    head = f"core ({core} designs): rms | worst | outside it ({beyond} designs): rms | worst"
    rows = [f"| on designs that were not fitted | {head} |", "|---|---|---|---|---|"]
    names = (
        "$K_\\theta$", "torque per twist of the pitch, no contact", "torque at twice the engagement",
        "strain near an edge of the embedded scale, at twice the engagement",
    )  # fmt: skip
    return rows + [
        f"| {n} | {e.rms:.1%} | {e.worst:.1%} | {o.rms:.1%} | {o.worst:.1%} |"
        for n, e, o in zip(names, errors, others, strict=True)
    ]


TABLES_OF = {
    "symbols": symbols,
    "keys": keys,
    "joint-laws": joint_laws,
    "law-ranges": law_ranges,
    "law-errors": law_errors,
}
"""What a table is asked for by."""


class Table(SphinxDirective):
    """A table that is made from the code's own data."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        rows = TABLES_OF[self.arguments[0]]()
        return self.parse_text_to_nodes("\n".join(rows))


class Gallery(SphinxDirective):
    """Thumbnails of the gallery's pages, or of those that are named: the last picture of each, made by this build."""

    optional_arguments = 100

    def run(self) -> list[nodes.Node]:
        return [nodes.container(classes=["gallery"], pages=[f"gallery/{name}" for name in self.arguments])]


def thumbnails(app: Sphinx, doctree: nodes.document, docname: str) -> None:
    """Put the pages' last pictures, with links, where thumbnails are asked for."""
    env = app.env
    for place in [node for node in doctree.findall(nodes.container) if "gallery" in node["classes"]]:
        for page in place["pages"] or env.toctree_includes["gallery/index"]:
            link = nodes.reference(refuri=app.builder.get_relative_uri(docname, page), internal=True)
            # a build that does not execute the pages has no pictures
            for picture in [image["uri"] for image in env.get_doctree(page).findall(nodes.image)][-1:]:
                link += nodes.image(uri=picture, candidates={"*": picture}, alt="")
            link += nodes.inline(text=env.titles[page].astext())
            place.append(nodes.paragraph("", "", link))


def stale(_app: Sphinx, env: BuildEnvironment) -> Sequence[str]:
    """Pages with thumbnails are written by every build."""
    return [page for page in env.found_docs if page in {"index", "gallery/index"} or page.startswith("interface/")]


def looks(app: Sphinx) -> None:
    """Give the gallery's kernels the look of the package's figures, no settings of the user's, and no small talk."""
    logging.getLogger("traitlets").setLevel(logging.WARNING)
    profile = Path(app.doctreedir) / "ipython" / "profile_default"
    profile.mkdir(parents=True, exist_ok=True)
    (profile / "ipython_kernel_config.py").write_text("c.IPKernelApp.log_level = 40\n", encoding="utf-8")
    os.environ["IPYTHONDIR"] = str(profile.parent)
    rc = profile / "matplotlibrc"
    sheet = Path(style.__file__).with_name("figure.mplstyle")
    rc.write_text(f"{sheet.read_text()}figure.dpi: {style.DPI}\n", encoding="utf-8")
    os.environ["MATPLOTLIBRC"] = str(rc)
    os.environ["MPLBACKEND"] = "module://matplotlib_inline.backend_inline"


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("squama-table", Table)
    app.add_directive("squama-gallery", Gallery)
    app.connect("builder-inited", looks)
    app.connect("env-updated", stale)
    app.connect("doctree-resolved", thumbnails)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
