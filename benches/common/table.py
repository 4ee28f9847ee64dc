"""Tables for a terminal and for the documentation."""

from __future__ import annotations


def table(lines: list[list[str]]) -> str:
    """Align the columns of a table; the first line is its head."""
    widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
    padded = [
        [c.rjust(w) if i else c.ljust(w) for i, (c, w) in enumerate(zip(line, widths, strict=True))]
        for line in lines
    ]
    return "\n".join("  ".join(line) for line in padded)


def rows(lines: list[list[str]]) -> str:
    """Write a Markdown table without padding, so that one figure changes one line."""
    # A bar would end the cell.
    cells = [[cell.replace("|", r"\|") for cell in line] for line in lines]
    cells.insert(1, ["---"] * len(lines[0]))
    return "\n".join(f"| {' | '.join(line)} |" for line in cells) + "\n"
