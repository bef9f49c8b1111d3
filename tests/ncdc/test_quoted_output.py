"""What the pages say that a command prints, on the example camera, is what it prints."""

import re
import shlex
from pathlib import Path

import pytest

from ncdc.cli import main
from ncdc_model.example import example_camera, scene_photo, target_photo
from ncdc_model.images import write_image

ROOT = Path(__file__).resolve().parents[2]
PROGRESS = re.compile(r"[\w ]+: +\d+ %")
QUICK = "calibrate", "train", "evaluate", "correct", "export", "plan"


def quoted(page):
    """(arguments, lines of output) of every quoted command that is quick and prints something."""
    found = []
    for line in (ROOT / page).read_text().splitlines():
        if line.startswith("    $ ncdc "):
            found.append((shlex.split(line.removeprefix("    $ ncdc ")), []))
        elif line.startswith("    ") and found:
            found[-1][1].append(line[4:])
        elif found:
            found.append(([""], []))
    return [(command, lines) for command, lines in found if lines and command[0] in QUICK]


def missing(quoted_lines, printed):
    """Quoted lines that do not follow one another in ``printed``; "..." stands for any lines."""
    place, jump = 0, True
    for line in quoted_lines:
        if line.strip() == "...":
            jump = True
            continue
        rest = printed[place:] if jump else printed[place:place + 1]
        if line not in rest:
            return [line]
        place, jump = place + rest.index(line) + 1, False
    return []


def test_a_line_that_is_not_printed_is_found():
    printed = ["a", "b", "c"]
    assert missing(["a", "b"], printed) == missing(["a", "...", "c"], printed) == []
    assert missing(["a", "c"], printed) == ["c"]
    assert missing(["b", "a"], printed) == ["a"]


@pytest.mark.many_clocks
@pytest.mark.regress
def test_quoted_outputs_are_those_of_the_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    camera = example_camera()
    camera.save("camera.toml")
    write_image("photo.raw.png", target_photo(camera))
    write_image("distorted.raw.png", scene_photo(camera))
    checked, wrong = set(), {}
    for page in ("docs/commands.md", "docs/planner.md"):
        for command, lines in quoted(page):
            main(command)
            out, err = capsys.readouterr()
            # A page has what went to either as a terminal shows it: whichever came first.
            printed = [[line for line in text.splitlines() if not PROGRESS.match(line)]
                       for text in (out + err, err + out)]
            checked.add(command[0])
            if all(lost := [missing(lines, one) for one in printed]):
                wrong[" ".join(command)] = lost, printed[0]
    assert checked == set(QUICK) and not wrong
