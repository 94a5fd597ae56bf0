"""The sources of the site: pages of the whole repository, gathered in one folder with their links rewritten."""

from __future__ import annotations

from pathlib import Path

from site_pages.gallery import gallery_pages
from site_pages.pages import Pages
from site_pages.reference import reference_pages
from site_pages.theory import theory_pages


def stage(root: Path, target: Path, *, run: bool = True) -> Pages:
    """Write the source of every page of the site below ``target``; what is no longer a page is deleted.

    Without ``run`` no notebook and no example is executed.
    Files that have not changed keep their time, so that Sphinx builds only what has.
    """
    pages = Pages(root, target)
    pages.add_documents()
    theory_pages(pages)
    gallery_pages(pages, run=run)
    reference_pages(pages)
    pages.write()
    return pages
