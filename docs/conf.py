"""The site, for Sphinx. ``python docs/build.py`` gathers its sources and builds it."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT), str(ROOT / "formulations"), str(ROOT / "docs")]

import jtik  # noqa: E402

project, author, version = "jtik", "The jtik developers", jtik.__version__
project_copyright = "the jtik developers, Apache-2.0"
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "sphinx-mathjax-offline",
    "site_pages.docstrings",
]
exclude_patterns = ["jupyter_execute", "**/.ipynb_checkpoints"]
suppress_warnings = ["toc.empty_glob"]  # pages that are not there yet

html_theme = "furo"
html_title = f"jtik {version}"
html_static_path = [str(ROOT / "docs" / "static")]
html_css_files = ["site.css"]
html_show_sourcelink = False
pygments_style = "friendly"
pygments_dark_style = "monokai"

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
nb_execution_mode = "off"  # the gallery executes them

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
SHOWN = (
    "Array",
    "ArrayLike",
    "Criteria",
    "Expression",
    "NonNegative",
    "Positive",
    "Share",
    "Speeds",
    "StepLimit",
    "Weights",
)
autodoc_type_aliases = dict(zip(SHOWN, SHOWN, strict=True))  # as they are written, not what they stand for
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False

default_role = "py:obj"
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
