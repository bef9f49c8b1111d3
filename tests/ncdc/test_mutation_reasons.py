"""Reasons of the mutants of the gateware that survive: what counts, and what has no mutant."""

import json
from pathlib import Path

import pytest

from ncdc_bench.mutation import command
from ncdc_bench.mutation.page import PAGE, REPORT, filled, reasoned
from ncdc_bench.mutation.reasons import Reason, explained, read_reasons, stale
from ncdc_bench.mutation.score import score
from ncdc_spec.errors import InputError

ROW = {"design": "d", "module": "m", "mutants": 10, "killed": 6, "equivalent": 1, "survived": 3,
       "survivors": [{"line": f"a.py:{k}", "change": "bit", "mutant": f"mutate {k}"}
                     for k in range(3)]}
ENTRY = '[[reason]]\ndesign = "d"\nmodule = "m"\nkind = "{}"\nwhy = "{}"\nmutants = {}\n'


def reason(mutant, kind, why="why", module="m"):
    """A reason of a mutant of the row."""
    return Reason("d", module, mutant, kind, why)


def test_an_equivalent_is_not_counted_and_one_that_is_accepted_is():
    made = explained(ROW, [reason("mutate 0", "equivalent"), reason("mutate 2", "accepted"),
                           reason("mutate 1", "equivalent", module="other")])
    assert (made["killed"], made["equivalent"], made["survived"]) == (6, 2, 2)
    assert made["score"] == score(made) == 6 / 8
    assert made["argued"] == [ROW["survivors"][0] | {"why": "why"}]
    assert made["survivors"] == [ROW["survivors"][1], ROW["survivors"][2] | {"why": "why"}]


def test_reasons_are_applied_anew():
    """Twice it is the same, and without reasons all is as at first."""
    reasons = [reason("mutate 0", "equivalent"), reason("mutate 2", "accepted")]
    once = explained(ROW, reasons)
    assert explained(once, reasons) == once
    back = explained(once, [])
    assert back["argued"] == [] and back["equivalent"] == 1 and back["score"] == 6 / 9
    assert sorted(one["mutant"] for one in back["survivors"]) == [
        one["mutant"] for one in ROW["survivors"]]


def test_a_reason_without_a_survivor_is_stale():
    reasons = [reason("mutate 0", "equivalent"), reason("mutate 7", "equivalent"),
               reason("mutate 8", "accepted"), reason("mutate 9", "accepted", module="unjudged")]
    assert stale([explained(ROW, reasons)], reasons) == reasons[1:3]


@pytest.mark.parametrize("text,message", [
    (ENTRY.format("likely", "why", '["a"]'), "without a mutant, a reason, or one of the kinds"),
    (ENTRY.format("accepted", " ", '["a"]'), "without a mutant, a reason"),
    (ENTRY.format("accepted", "why", "[]"), "without a mutant, a reason"),
    (ENTRY.format("accepted", "why", '["a", "a"]'), "has a mutant twice: d, m, a"),
    (ENTRY.format("accepted", "why", '["a"]') + 'line = "3"\n', "has an entry with the keys")])
def test_what_is_rejected(text, message, tmp_path):
    (tmp_path / "reasons.toml").write_text(text)
    with pytest.raises(InputError, match=message):
        read_reasons(tmp_path / "reasons.toml")


def test_the_command_reports_a_stale_reason(monkeypatch):
    planted = reason("mutate 7", "accepted")
    monkeypatch.setattr("ncdc_bench.mutation.reasons.read_reasons", lambda: (planted,))
    assert command._failures([ROW | {"score": 1.0}], {"score": 1.0}) == [
        "reasons.toml has a mutant of d, m that does not survive: mutate 7"]


def test_the_report_has_the_present_reasons():
    """Each reason is that of a survivor, and each survivor that is below 100 % is shown."""
    report = json.loads(REPORT.read_text())
    judged = {(row["design"], row["module"]) for row in report["rows"]}
    assert [one for one in read_reasons() if (one.design, one.module) not in judged] == []
    assert stale(report["rows"]) == []
    assert reasoned(report) == report, "run python -m ncdc_bench.mutation.page"
    page = Path(PAGE).read_text()
    assert filled(page, report) == page, "run python -m ncdc_bench.mutation.page"
    assert all(one.why in page for one in read_reasons())
