def theory_pages(pages):
    pages.add("theory/index.md", "# Theory\n\n```{toctree}\n:glob:\n\n*\n```\n")
