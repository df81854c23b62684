"""Settings of the documentation site: sphinx -b html docs docs/_build/html."""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent.parent / "src"))

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

import squama
from squama.beam.beamfile import TABLES
from squama.joints import law
from squama.model.joint import LAWS

project = "squama"
author = "The squama developers"
copyright = "The squama developers"
version = release = squama.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax", "sphinx-mathjax-offline"]
exclude_patterns = ["_build", "api", "images/*.py"]
nb_execution_mode = "off"
myst_enable_extensions = ["amsmath", "dollarmath", "deflist"]
myst_heading_anchors = 3

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
html_css_files = ["formulas.css"]


def symbols() -> list[str]:
    """Rows of the table of symbols."""
    rows = ["| name | symbol | unit | meaning | source |", "|---|---|---|---|---|"]
    for s in squama.SYMBOLS.values():
        tex = f"${s.tex}$" if s.tex else ""
        rows.append(f"| `{s.name}` | {tex} | {s.unit or 'text'} | {s.long_name} | {s.equation} |")
    return rows


def keys() -> list[str]:
    """Rows of the table of keys of a beam file."""
    rows = ["| table | key | meaning | measures | example |", "|---|---|---|---|---|"]
    for table, content in TABLES.items():
        for name, key in content.items():
            measures = key.dimension or ("file" if key.example.startswith('"') else "whole number")
            rows.append(f"| `[{table}]` | `{name}` | {key.meaning} | {measures} | `{key.example}` |")
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
    rows = ["| key | from | to | |", "|---|---|---|---|"]
    return rows + [f"| `{r.key}` | {r.low:g} | {r.high:g}{r.unit} | {r.part} |" for r in law.RANGES]


def law_errors() -> list[str]:
    """Rows of the table of errors of the law of the joint."""
    designs, *errors = law.errors()
    rows = [f"| on {designs} designs that were not fitted | rms | worst |", "|---|---|---|"]
    names = (
        "$K_\\theta$", "torque per twist of the pitch, no contact", "torque at twice the engagement",
        "strain near an edge of the embedded scale, at twice the engagement",
    )  # fmt: skip
    return rows + [f"| {n} | {e.rms:.1%} | {e.worst:.1%} |" for n, e in zip(names, errors, strict=True)]


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


def setup(app: Sphinx) -> dict[str, bool]:
    app.add_directive("squama-table", Table)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
