"""Reasons of mutants of the gateware that no bench kills, from ``reasons.toml``.

A mutant with the kind ``equivalent`` cannot change what the gateware means. It counts like one
that Yosys proves equivalent. One that is ``accepted`` still counts as a survivor.
"""

import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from ncdc_bench.mutation.score import score
from ncdc_spec.errors import InputError

__all__ = ["KINDS", "LIST", "Reason", "explained", "read_reasons", "stale"]

LIST = Path(__file__).with_name("reasons.toml")
KINDS = "equivalent", "accepted"


@dataclass(frozen=True)
class Reason:
    """Why no bench kills a mutant.

    Parameters
    ----------
    design, module, mutant : str
        As in a row of the report; ``mutant`` is Yosys's command.
    kind : str
        One of :data:`KINDS`.
    why : str
        One sentence.
    """
    design: str
    module: str
    mutant: str
    kind: str
    why: str

    @property
    def key(self):
        """What names the mutant."""
        return self.design, self.module, self.mutant


@cache
def read_reasons(path=LIST):
    """The reasons of a file, a tuple of :class:`Reason`.

    An entry has ``design``, ``module``, ``kind``, ``why`` and a list of ``mutants``.

    Raises
    ------
    InputError
        If an entry is incomplete or has another kind, or if a mutant is listed twice.
    """
    found = []
    for entry in tomllib.loads(path.read_text()).get("reason", []):
        if {*entry} != {"design", "module", "kind", "why", "mutants"}:
            raise InputError(f"{path.name} has an entry with the keys {', '.join(entry)}")
        if entry["kind"] not in KINDS or not entry["why"].strip() or not entry["mutants"]:
            raise InputError(f"{path.name} has an entry of {entry['module']} without a mutant, a "
                             f"reason, or one of the kinds {', '.join(KINDS)}")
        found += [Reason(entry["design"], entry["module"], mutant, entry["kind"], entry["why"])
                  for mutant in entry["mutants"]]
    keys = [one.key for one in found]
    twice = next((key for key in keys if keys.count(key) > 1), None)
    if twice is not None:
        raise InputError(f"{path.name} has a mutant twice: {', '.join(twice)}")
    return tuple(found)


def explained(row, reasons=None):
    """A row of the report with the ``reasons`` of its survivors; applied twice it is the same.

    Survivors that are listed as equivalent move to ``argued``, and are counted as equivalent. All
    others of which a reason is known have it as ``why``.
    """
    known = {one.key: one for one in (read_reasons() if reasons is None else reasons)}
    before = row.get("argued", [])
    survivors, argued = [], []
    for one in (*row["survivors"], *before):
        plain = {name: value for name, value in one.items() if name != "why"}
        reason = known.get((row["design"], row["module"], one["mutant"]))
        (argued if reason and reason.kind == "equivalent" else survivors).append(
            plain | ({"why": reason.why} if reason else {}))
    made = row | {"equivalent": row["equivalent"] - len(before) + len(argued),
                  "survived": len(survivors), "survivors": survivors, "argued": argued}
    return made | {"score": score(made)}


def stale(rows, reasons=None):
    """Those of the ``reasons`` that name no mutant that survives in one of the ``rows``.

    Reasons of modules that have no row are left out.
    """
    alive = {(row["design"], row["module"], one["mutant"])
             for row in rows for one in (*row["survivors"], *row.get("argued", ()))}
    judged = {(row["design"], row["module"]) for row in rows}
    return [one for one in (read_reasons() if reasons is None else reasons)
            if (one.design, one.module) in judged and one.key not in alive]
