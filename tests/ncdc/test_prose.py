"""The pages that people read first have short sentences and plain words."""

from pathlib import Path

import pytest

from prose import grade, sentences, syllables

ROOT = Path(__file__).resolve().parents[2]
FIRST = [ROOT / "README.md", ROOT / "docs/index.md", *sorted(ROOT.glob("docs/start/*.md")),
         *sorted(ROOT.glob("docs/howto/*.md"))]
LONGEST = 25            # words of a sentence
HIGHEST = 10            # Flesch-Kincaid grade


def long_ones(page):
    return [" ".join(words) for words in sentences(page) if len(words) > LONGEST]


def by_name(path):
    return str(path.relative_to(ROOT))


@pytest.mark.parametrize("path", FIRST, ids=by_name)
def test_sentences_are_short(path):
    assert long_ones(path.read_text()) == []


@pytest.mark.parametrize("path", FIRST, ids=by_name)
def test_words_are_plain(path):
    assert grade(path.read_text()) <= HIGHEST


@pytest.mark.parametrize("where", ["{}\n", "- {}\n", "1. {}\n   more.\n", "| cell | {} |\n",
                                   "It is short. {}\n"])
def test_a_planted_long_sentence_is_found(where):
    text = " ".join(["word"] * 26)
    assert long_ones(f"# Title\n\n{where.format(text + '.')}") != []
    assert long_ones(f"# Title\n\n{where.format(text[5:] + '.')}") == []


def test_code_is_no_prose():
    code = " ".join(["word"] * 30)
    assert long_ones(f"Some `{code}`:\n\n    {code}\n    {code}\n\n```\n{code}\n```\n") == []


def test_addresses_of_links_are_no_prose():
    links = "".join(f"[{n}]: https://example.org/a-b.html\n" for n in range(30))
    assert long_ones(f"A [link][0].\n\n{links}") == []


def test_hard_words_are_found():
    easy = "The cat sat on the mat. It was a good mat.\n"
    hard = "Characterisation necessitates comprehensive mathematical parameterisation.\n"
    assert grade(easy) < 2 and grade(hard) > HIGHEST


@pytest.mark.parametrize("word,count", [
    ("lens", 1), ("picture", 2), ("camera", 3), ("made", 1), ("table", 2), ("needed", 2),
    ("called", 1), ("pages", 2), ("memory", 3), ("2464", 1)])
def test_syllables(word, count):
    assert syllables(word) == count
