def gallery_pages(pages):
    pages.add("gallery/index.md", "# Gallery\n")
    pages.of |= {
        "examples/README.md": "gallery/index.md",
        "notebooks/README.md": "gallery/index.md",
        "examples": "gallery/index.md",
        "notebooks": "gallery/index.md",
    }
