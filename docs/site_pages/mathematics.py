"""Mathematics as GitHub renders it, for Sphinx: fences named ``math`` keep their equation and its tag as they stand."""

from __future__ import annotations

import re

FENCE = re.compile(r"^( *)```math\n(.*?)^\1```$", flags=re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"\$`([^`]+)`\$")


def displayed(text: str) -> str:
    r"""The text with its fences as directives that leave the equation alone, so that ``\tag`` works.

    GitHub's $`...`$ becomes $...$.
    """

    def directive(match: re.Match[str]) -> str:
        indent, equation = match[1], match[2].rstrip()
        return f"{indent}```{{math}}\n{indent}:nowrap:\n\n{indent}\\[\n{equation}\n{indent}\\]\n{indent}```"

    return INLINE.sub(r"$\1$", FENCE.sub(directive, text))
