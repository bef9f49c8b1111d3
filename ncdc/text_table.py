"""Rows of a report as aligned text."""

__all__ = ["text_table"]


def text_table(columns, rows, left=0):
    """Lines of text: the titles, then a line for each row.

    Parameters
    ----------
    columns : sequence of (title, function)
        The function gives the cell of a row; None is printed as "-".
    rows : sequence
    left : int
        The first columns, so many, are aligned to the left.
    """
    cells = [[title for title, _ in columns],
             *(["-" if (cell := of(row)) is None else str(cell) for _, of in columns]
               for row in rows)]
    widths = [max(map(len, column)) for column in zip(*cells)]
    return "\n".join("  ".join(f"{cell:<{width}}" if k < left else f"{cell:>{width}}"
                               for k, (cell, width) in enumerate(zip(line, widths)))
                     for line in cells)
