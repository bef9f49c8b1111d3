"""What MkDocs does to a page in addition: marks of Sphinx in docstrings (:class:`X`) become X."""

import re


def on_page_content(html, **_):
    """The page without the names of Sphinx's roles before code."""
    return re.sub(r":(?:class|func|meth|data|mod|attr):(?=<(?:code|autoref)\b)", "", html)
