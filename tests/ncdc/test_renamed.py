"""Names of options: each means one thing, and those of the last release are still understood."""

import argparse
from collections import defaultdict

import pytest

from ncdc.cli import COMMANDS, parser


def options(command):
    """Option strings and their actions of a command and its actions, hidden ones left out."""
    found, waiting = [], [parser(command)]
    while waiting:
        for action in waiting.pop()._actions:
            if isinstance(action, argparse._SubParsersAction):
                waiting += action.choices.values()
            elif action.help != argparse.SUPPRESS:
                found += [(name, action) for name in action.option_strings]
    return found


def value_of(action):
    """What the help says that a value is: its name, or the choices."""
    return action.metavar or str(action.choices)


def two_meanings(found):
    """Options of (command, name, value) whose value is not the same in all commands."""
    values = defaultdict(lambda: defaultdict(set))
    for command, name, value in found:
        values[name][value].add(command)
    return {name: dict(one) for name, one in values.items() if len(one) > 1}


def test_an_option_has_the_same_value_in_every_command():
    """The output's kind may differ; the options of `bench` are its benches' own. The camera of
    `generate` is a kind of port, that of `train` has a name in its file. A number of a view may be
    a range in `plan`."""
    found = {(command, name, value_of(action)) for command in COMMANDS if command != "bench"
             for name, action in options(command) if name not in ("-o", "--output")}
    found -= {("generate", "--camera", "KIND"),
              *(("plan", name, "LOW:HIGH") for name in ("--pan", "--tilt", "--roll", "--zoom"))}
    assert len(found) > 100 and two_meanings(found) == {}


def test_two_meanings_are_found():
    assert two_meanings([("train", "--sensor", "WxH"), ("build", "--sensor", "NAME"),
                         ("plan", "--to", "X"), ("build", "--to", "X")]) == {
        "--sensor": {"WxH": {"train"}, "NAME": {"build"}}}


RENAMED = [
    ("train map.npz --neurons 4", "--sensor 640x480", "--sensor-size 640x480"),
    ("plan net.toml", "--clock 150", "--core-mhz 150"),
    ("plan net.toml", "--rate 30", "--min-fps 30"),
    ("plan net.toml", "--camera ov5640", "--sensor ov5640"),
    ("plan net.toml --follow", "--camera-line 900", "--line-clocks 900"),
    ("simulate net.toml a.png -o b.png", "--camera-line 900", "--line-clocks 900"),
    ("device serve net.toml", "--loss 0.01", "--packet-loss 0.01"),
    ("device serve net.toml", "--loss-again 0.01", "--resend-loss 0.01"),
    ("soc run --sim net.toml --photo a.png", "--loss 25", "--packet-loss 0.025")]


@pytest.mark.parametrize("command,old,new", RENAMED)
def test_an_old_name_does_the_same_and_says_the_new_one(command, old, new, capsys):
    one = parser(command.split()[0])
    before = one.parse_args([*command.split(), *old.split()])
    assert capsys.readouterr().err == (
        f"warning: {old.split()[0]} is called {new.split()[0]} now; the old name goes with the "
        f"next release\n")
    after = one.parse_args([*command.split(), *new.split()])
    assert before == after != one.parse_args(command.split())
    assert not capsys.readouterr().err


def test_a_required_old_name_may_be_given_twice(capsys):
    one = parser("evaluate")
    before = one.parse_args("evaluate net.toml --against x.tif --against y.tif".split())
    assert capsys.readouterr().err.count("--against is called --reference now") == 2
    assert before == one.parse_args(
        "evaluate net.toml --reference x.tif --reference y.tif".split())
    assert before.reference == ["x.tif", "y.tif"]
    for wrong in ("", "--against x.tif --reference y.tif"):
        with pytest.raises(SystemExit) as stopped:
            one.parse_args(["evaluate", "net.toml", *wrong.split()])
        assert stopped.value.code == 2


@pytest.mark.parametrize("command,old,new", [
    *RENAMED, ("evaluate net.toml", "--against a.json", "--reference a.json")])
def test_help_names_the_new_one_only(command, old, new, capsys):
    words = command.split()
    with pytest.raises(SystemExit):
        parser(words[0]).parse_args([*words[:2 if words[0] in ("device", "soc") else 1], "--help"])
    said = capsys.readouterr().out.split()
    assert new.split()[0] in said and old.split()[0] not in said
