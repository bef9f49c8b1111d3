"""The mutation score of the golden model: what counts, what is rejected, the recorded score."""

import json
from pathlib import Path

import pytest

from ncdc.cli import main
from ncdc_bench.mutation import golden
from ncdc_bench.mutation.golden import (
    MIN_SCORE,
    MODULES,
    Module,
    golden_rows,
    mutants_of,
    score,
)
from ncdc_spec.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "docs/evidence/mutation_model.json"
TEXT = '''"""A module + its doc."""


def f(a, b):
    # a + b
    return a + b
'''

pytest.importorskip("cosmic_ray")


def test_mutants_of_a_text():
    every = mutants_of(TEXT)
    assert {mutant.line for mutant in every} == {6} and len({m.text for m in every}) == len(every)
    assert {("return a + b", "return a - b"), ("return a + b", "return a * b")} < {
        mutant.change for mutant in every}
    assert all(mutant.text == TEXT.replace(*mutant.change) for mutant in every)
    three = mutants_of(TEXT, 3)
    assert len(three) == 3 and set(three) < set(every) and three == mutants_of(TEXT, 3)
    assert mutants_of(TEXT, 3, seed=2) != three and len(mutants_of(TEXT, 99)) == len(every)


def test_every_module_and_its_tests_exist():
    for module in MODULES.values():
        assert (ROOT / module.source).is_file()
        assert module.tests and all((ROOT / "tests" / file).is_file() for file in module.tests)


@pytest.fixture
def tested(monkeypatch, tmp_path):
    """A function: the row of a small module of ours by the test of a given text."""
    def row(test, listed="equivalent = []", **options):
        (tmp_path / "test_it.py").write_text(test)
        (tmp_path / "list.toml").write_text(listed)
        monkeypatch.setattr(golden, "_LIST", tmp_path / "list.toml")
        monkeypatch.setitem(MODULES, "small", Module("ncdc_spec.nodes",
                                                     (str(tmp_path / "test_it.py"),)))
        return golden_rows(names=["small"], **options)[0]
    return row


BLIND = "def test_nothing():\n    import ncdc_spec.nodes\n    assert ncdc_spec.nodes\n"
SHARP = """
def test_the_nodes_of_a_row():
    from ncdc_spec.nodes import row_nodes
    assert [row_nodes(columns, 8) for columns in (1, 7, 8, 9, 64, 65)] == [4, 4, 4, 5, 11, 12]
"""
EQUIVALENT = '''[[equivalent]]
module = "ncdc_spec.nodes"
line = "{}"
mutants = ["{}"]
reason = "planted"
'''


@pytest.mark.longer
def test_a_test_that_checks_nothing_kills_nothing(tested):
    blind = tested(BLIND, number=9)
    assert blind["killed"] == 0 and blind["survived"] == 9 == len(blind["survivors"])
    # A limit that the sharp test does not look at, a mutant of which is listed.
    limit = "return nodes == 1 or width > 4 * nodes"
    sharp = tested(SHARP, EQUIVALENT.format(limit, "return nodes == 1 or width >= 4 * nodes"))
    assert sharp["killed"] > 30 and sharp["equivalent"] == 1
    assert score([sharp]) == sharp["killed"] / (sharp["mutants"] - 1) > .3
    alive = {each["change"] for each in sharp["survivors"]}
    assert any(change.startswith(limit) for change in alive)
    assert not any(change.startswith("return -(-columns // nodes)") for change in alive)


@pytest.mark.longer
@pytest.mark.parametrize("test,line,mutant,message", [
    (SHARP, "return -(-columns // nodes) + BEFORE + AFTER",
     "return -(-columns // nodes) - BEFORE + AFTER", "that a test kills, line 14: return "),
    (BLIND, "return 5", "return 6", "that does not exist: return 5 -> return 6"),
    (BLIND + "    assert False\n", "", "", "fail without a mutant: pytest tests/")])
def test_what_is_rejected(tested, test, line, mutant, message):
    with pytest.raises(InputError, match=message):
        tested(test, EQUIVALENT.format(line, mutant) if line else "equivalent = []")


@pytest.mark.longer
def test_the_command(monkeypatch, tmp_path, capsys):
    assert main(["bench", "mutation", "--model", "--module", "tansig.lvc", "--per-module", "2",
                 "--json", str(tmp_path / "model.json")]) == 0
    report = json.loads((tmp_path / "model.json").read_text())
    assert [(row["module"], row["mutants"]) for row in report["rows"]] == [("tansig.lvc", 2)]
    assert "score 100.0 %" in capsys.readouterr().out
    monkeypatch.setattr(golden, "_LIST", tmp_path / "other.toml")
    (tmp_path / "other.toml").write_text(EQUIVALENT.format("a", "b").replace("nodes",
                                                                             "tansig.design"))
    assert main(["bench", "mutation", "--model", "--module", "tansig.design"]) == 2
    assert ("other.toml has a mutant of model/ncdc_spec/tansig/design.py that does not exist: "
            "a -> b") in capsys.readouterr().err


def test_the_recorded_score():
    record = json.loads(RECORD.read_text())
    assert [row["module"] for row in record["rows"]] == list(MODULES)
    assert score(record["rows"]) >= MIN_SCORE


@pytest.mark.regress
@pytest.mark.parametrize("name", MODULES)
def test_no_other_mutant_survives(name):
    """All recorded mutants of a module, a sample by a fixed seed."""
    record = json.loads(RECORD.read_text())
    [recorded] = [row for row in record["rows"] if row["module"] == name]
    [row] = golden_rows(names=[name], number=record["per_module"], seed=record["seed"])
    assert score([row]) >= score([recorded])
    for one in (row, recorded):
        del one["seconds"]
    assert row == recorded
