"""Numbers with a unit in the pages for which neither a quote nor history accounts.

A measured number is quoted by its name (:mod:`ncdc_bench.figures.quote`), or it is history: it was
measured once, and no command stores it. The page says so::

    Measured with version 0.1, 2026-11-22:

This sentence accounts for its own paragraph, list item or row of a table, and for a table or a list
right after it. "This section was measured with version ..." accounts for the text up to the next
heading. Code is not looked at: it shows what a command printed.
"""

import re
from dataclasses import dataclass

__all__ = ["HISTORY", "Block", "blocks", "unnamed"]

HISTORY = re.compile(r"measured with version (\d+\.\d+), (\d{4}-\d\d-\d\d)", re.IGNORECASE)
_SECTION = re.compile(r"this section was " + HISTORY.pattern, re.IGNORECASE)
_COMMON = ("dB", "px²", "px", "MHz", "Mbit/s", "MB/s", "MB", "kB", "%", "ms", "CPU s",
           "CPU seconds?", "frames per second", "clocks per pixel", "bytes per pixel", "ALMs?",
           "ALUTs?", "LUTs?", "LEs?", "DSPs?", "M10Ks?", "M9Ks?", "flip-flops", "block RAMs?",
           "multipliers", "seconds")
_PROSE = (*_COMMON, "GB", "s", "second", "CPU-seconds?", "minutes?", "hours?", "logic elements",
          "frames a second", "times a second", "a second", "per second",
          "pixels per clock", "bytes per clock", "DSP blocks?")
_HEADS = (*_COMMON, "MSE", "clocks/pixel", "bytes/pixel", "FF", "DSP", "RAM", "slack")
_NUMBER = r"(?<![\w.,§^])(?<!\w\*\*)(?<!\w\*\*-)(?<!\^-)[-+±]?\d(?:[\d,]*\d)?(?:\.\d+)?(?:e-\d+)?"
_QUOTED = re.compile(r"[-+]?\d[\d,]*(?:\.\d+)?<!--=[\w.]+-->")


def _units(names):
    return "|".join(sorted(names, key=len, reverse=True)).replace(" ", r"\s+")


# Numbers that share a unit, as "1.2, 3 and 4.5 MHz"; "§" stands for a quoted one.
_CHAIN = re.compile(rf"((?:{_NUMBER}|§)(?:\s?(?:,|/|-|to|and|or|of)?\s?(?:{_NUMBER}|§))*)[\s-]?"
                    rf"({_units(_PROSE)})(?![\w/])")
_HEAD = re.compile(rf"(?<![\w/])(?<!\d )({_units(_HEADS)})(?![\w/])")


@dataclass
class Block:
    """Lines of a page that belong together.

    Parameters
    ----------
    kind : str
        ``heading``, ``text``, ``item`` of a list, ``table``, ``code`` or ``comment``.
    line : int
        The first one, from 1.
    lines : list of str
        Without the blank ones between blocks.
    """
    kind: str
    line: int
    lines: list


def blocks(text):
    """The :class:`Block` list of a page's ``text``, in order."""
    found, fenced, blank = [], False, True
    for k, line in enumerate(text.splitlines(), 1):
        if fenced:
            found[-1].lines.append(line)
            fenced, blank = not line.startswith("```"), True
        elif not line.strip():
            blank = True
        else:
            kind = _kind(line)
            fenced = line.startswith("```")
            if blank or kind in ("item", "heading", "comment") or fenced:
                found.append(Block(kind, k, [line]))
            else:
                found[-1].lines.append(line)
            blank = kind in ("heading", "comment")
    return found


def _kind(line):
    forms = {"code": r" {4}|```", "comment": r"<!--", "table": r"\|", "item": r"([-*]|\d+\.) ",
             "heading": r"#+ "}
    return next((kind for kind, form in forms.items() if re.match(form, line)), "text")


def unnamed(text):
    """Numbers with a unit that are neither quoted nor history.

    Parameters
    ----------
    text : str
        A page. Tables written by a ``<!--rows=...-->`` form are quoted, but for their own cells.

    Returns
    -------
    list of (int, str)
        Line, from 1, and number with unit: ``(12, "62.5 MHz")``. Numbers of a table have the unit
        of its corner, their column or their row.
    """
    found, section, carried, form = [], False, False, ""
    for block in blocks(text):
        joined = " ".join(" ".join(block.lines).split())
        own = block.kind != "table" and bool(HISTORY.search(joined))
        section = bool(_SECTION.search(joined)) or section and block.kind != "heading"
        if not (section or own or carried and block.kind in ("table", "item")):
            found += _of_table(block, form) if block.kind == "table" else _of_prose(block)
        if block.kind != "comment":
            carried = own and block.kind == "text" or carried and block.kind == "item"
        form = joined if block.kind == "comment" else ""
    return found


def _of_prose(block):
    """Numbers of a paragraph or list item, each with the unit that follows."""
    if block.kind not in ("text", "item"):
        return []
    return _with_units("\n".join(block.lines), block.line)


def _with_units(text, line):
    """(line, number with unit) of each number in ``text``, which begins in ``line``."""
    text, found = _QUOTED.sub("§", text), []
    for chain in _CHAIN.finditer(text):
        unit = " ".join(chain[2].split())
        for number in re.finditer(_NUMBER, chain[1]):
            below = text.count("\n", 0, chain.start(1) + number.start())
            found.append((line + below, f"{number[0]} {unit}"))
    return found


def _of_table(block, form):
    """Numbers of a table, each with its own unit, or that of its column, its row or the corner."""
    heads, _, *rows = map(_cells, block.lines)
    own = _cells(form[form.find("|"):]) if form.startswith("<!--rows=") else None
    found = []
    for line, row in enumerate(rows, block.line + 2):
        past = HISTORY.search(" ".join(row))
        for column, cell in enumerate(row):
            if past or own and own[column:column + 1] != ["*"]:
                continue
            above = [*heads[column:column + 1], *[row[0], heads[0]] * bool(column)]
            found += _of_cell(cell, line, above)
    return found


def _cells(line):
    """Cells of a row of a table, or of the form of one."""
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip())[1:-1]]


def _of_cell(cell, line, heads):
    """Numbers of a cell: those with a unit of their own, else all, by the first head with a unit.

    A head's first unit stands for all of its units: "MSE / max, px".
    """
    units = [unit[0] for head in heads if (unit := _HEAD.search(head))]
    if not units or _CHAIN.search(_QUOTED.sub("§", cell)):
        return _with_units(cell, line)
    return [(line, f"{number} {units[0]}")
            for number in re.findall(_NUMBER, re.sub(r"`[^`]*`", "", _QUOTED.sub("§", cell)))]
