"""Each marker of pyproject.toml is on a test; the names of tests hold no message."""

import tomllib

import pytest

from cases import cases


def test_each_marker_is_on_a_test(request):
    """Looks at all tests, before any is deselected: a marker without a test says nothing."""
    config = request.config
    if config.args != config.getini("testpaths"):
        pytest.skip("only some of the tests were asked for")
    settings = tomllib.loads(config.inipath.read_text())["tool"]["pytest"]["ini_options"]
    known = {line.partition(":")[0] for line in settings["markers"]}
    assert known and not known - config.stash["markers"]


TESTS = """
import pytest

@pytest.mark.parametrize("value,message", [("a-1", "1 is needed"), (2, "2 is needed")])
def test_it(value, message):
    pass

@pytest.mark.parametrize("text", ["short", "two\\nlines"])
def test_text(text):
    pass
"""


def test_a_message_is_no_part_of_a_name(pytester, request):
    pytester.makeconftest((request.config.rootpath / "tests" / "conftest.py").read_text())
    pytester.makepyfile(test_it=TESTS)
    names = pytester.inline_run("--collect-only").getcalls("pytest_itemcollected")
    assert [call.item.name for call in names] == [
        "test_it[a-1-message]", "test_it[2-message]", "test_text[short]", "test_text[text]"]


def test_an_unknown_marker_is_an_error(pytester, request):
    pytester.makepyfile("import pytest\n@pytest.mark.slower\ndef test_it():\n    pass\n")
    result = pytester.runpytest("-c", str(request.config.inipath), "--rootdir", ".")
    result.stdout.fnmatch_lines(["*'slower' not found in `markers`*"])
    assert result.ret


def test_cases_are_marked_by_name():
    short, long = cases({"short": (1, 2), "long": (3, 4)}, longer=["long"])
    assert short.values == (1, 2) and short.id == "short" and not short.marks
    assert long.id == "long" and [mark.name for mark in long.marks] == ["longer"]
    with pytest.raises(ValueError, match="no such case: shorter"):
        cases(["short"], longer=["shorter"])
