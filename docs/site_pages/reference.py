def reference_pages(pages):
    pages.add("reference/index.md", "# Reference\n")
    pages.of["docs/reference/index.md"] = "reference/index.md"
