"""How easy a page of Markdown is to read: length of its sentences, Flesch-Kincaid grade."""

import re

__all__ = ["grade", "sentences", "syllables"]

_WORD = re.compile(r"[^\W_][\w'’.,+-]*")


def _plain(line):
    """A line of prose without marks; code, whatever its length, counts as one word."""
    line = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", line)
    line = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line)
    return re.sub(r"`[^`]*`", "code", line).replace("*", "").replace("<", "").replace(">", "")


def _blocks(page):
    """(kind, text) of each paragraph and list item, "prose", and of each cell of a table, "cell".

    Headings, blocks of code and the addresses of links are left out.
    """
    page = re.sub(r"<!--.*?-->", "", page)
    page = re.sub(r"^\[[^\]]+\]: \S+$", "", page, flags=re.MULTILINE)
    page = re.sub(r"^```.*?^```$", "", page, flags=re.MULTILINE | re.DOTALL)
    part, blank = [], True
    for line in [*page.splitlines(), ""]:
        code = line.startswith("    ") and blank
        starts = re.match(r"\s*([-*]|\d+\.) ", line)
        if part and (not line.strip() or starts or line.startswith(("#", "|"))):
            yield "prose", _plain(" ".join(part))
            part = []
        if line.startswith("|"):
            yield from (("cell", _plain(cell)) for cell in line.strip("|").split("|"))
        elif line.strip() and not code and not line.startswith("#"):
            part.append(line[starts.end():] if starts else line.strip())
        blank = code or not line.strip()


def sentences(page, kinds=("prose", "cell")):
    """List of the sentences of a page, each a list of words."""
    found = [_WORD.findall(text) for kind, block in _blocks(page) if kind in kinds
             for text in re.split(r"(?<=[.!?])[)\"]*\s+", block)]
    return [words for words in found if words]


def syllables(word):
    """Number of groups of vowels without a silent e at the end; at least 1."""
    word = re.sub(r"[^a-z]", "", word.lower())
    silent = re.search(r"[^td]ed$|([^sxzcgh]|th)es$|[^l]e$|[aeiouy]le$", word)
    return max(1, len(re.findall(r"[aeiouy]+", word)) - bool(silent))


def grade(page):
    """Flesch-Kincaid grade of a page's paragraphs and lists, tables apart."""
    found = sentences(page, ("prose",))
    words = [word for sentence in found for word in sentence]
    return (.39 * len(words) / len(found)
            + 11.8 * sum(map(syllables, words)) / len(words) - 15.59)
