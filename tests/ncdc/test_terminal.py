"""Progress on a terminal and in a log: one line, which nothing else is written into."""

import io
import sys

import pytest

from ncdc import terminal
from ncdc.terminal import Progress, Steps, end_line, say


class Stream(io.StringIO):
    def __init__(self, terminal):
        super().__init__()
        self.isatty = lambda: terminal


@pytest.fixture
def log(monkeypatch):
    """Function that replaces stderr with a log: pytest has its own there until a test runs."""
    def begin():
        monkeypatch.setattr(sys, "stderr", Stream(False))
        return sys.stderr
    return begin


def steps(progress, *percents):
    for percent in percents:
        progress(percent / 100, f", note {percent}")


def test_a_log_has_one_line(log):
    text = log()
    steps(Progress("training"), *range(101))
    assert text.getvalue() == "training: 0 % 25 % 50 % 75 % 100 %, note 100\n"


def test_a_log_grows_as_the_work_goes_on(log):
    text = log()
    progress = Progress("training")
    steps(progress, 0, 10, 30)
    assert text.getvalue() == "training: 0 % 25 %"


def test_what_is_said_in_between_has_a_line_of_its_own(log):
    text = log()
    progress = Progress("calibrate")
    steps(progress, 0, 30)
    say("warning: one")
    say("warning: two")
    steps(progress, 60, 80, 100)
    assert text.getvalue() == ("calibrate: 0 % 25 %\nwarning: one\nwarning: two\n"
                              "calibrate: 50 % 75 % 100 %, note 100\n")


def test_an_error_after_a_step_has_a_line_of_its_own(monkeypatch):
    monkeypatch.setattr(sys, "stderr", text := Stream(True))
    Steps("build")("synthesis")
    say("ncdc build: one")
    say("ncdc build: two")
    assert text.getvalue() == "\rbuild: synthesis\x1b[K\nncdc build: one\nncdc build: two\n"


def test_two_steps_follow_each_other(log):
    text = log()
    steps(Progress("one"), 0, 100)
    steps(Progress("two"), 0, 100)
    end_line()
    assert text.getvalue() == "one: 0 % 100 %, note 100\ntwo: 0 % 100 %, note 100\n"


def test_a_line_that_another_stream_has_left_open_is_not_ended_here(log):
    log()
    steps(Progress("one"), 0)
    text = log()
    say("here")
    assert text.getvalue() == "here\n" and terminal._open is None


def test_a_terminal_s_line_is_updated(monkeypatch):
    monkeypatch.setattr(sys, "stderr", Stream(True))
    progress = Progress("training")
    steps(progress, 0, 1, 1.5)
    assert sys.stderr.getvalue() == "\rtraining:   0 %, note 0   \rtraining:   1 %, note 1   "
    say("ncdc train: no")
    assert sys.stderr.getvalue().endswith(", note 1   \nncdc train: no\n")
    steps(progress, 100)
    assert sys.stderr.getvalue().endswith("\n\rtraining: 100 %, note 100   \n")
