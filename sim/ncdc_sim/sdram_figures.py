"""Prints the table of docs/reference/sdram.md: python -m ncdc_sim.sdram_figures"""

from dataclasses import replace

from ncdc_boards.sdram.chips import AS4C16M16SA_6, IS42S16320D_7, in_parallel
from ncdc_boards.sdram.controller import SdramController
from ncdc_sim.sdram import ALONE, ANYWHERE, CORRECTOR, ONWARDS, SILENT, Host, run_sdram
from ncdc_sim.tools import SimulationError

__all__ = ["SHARES", "WAITS", "figures"]

_OFF = Host(SILENT)
_FULL = Host(ANYWHERE, 0, 16, 16)       # whole bursts anywhere, in each clock
_ALONE = Host(ANYWHERE, ALONE, 16, 16)
_PICTURE = Host(CORRECTOR, 0, 2, 4)
_ONWARDS = Host(ONWARDS, 0, 16, 16)
# Traffic of two readers, the video's reader and the writer.
SHARES = {
    "corrector: 2 to 4 words, two readers": [_PICTURE, _PICTURE, _OFF, _OFF],
    "camera: bursts of 16": [_OFF, _OFF, _OFF, _ONWARDS],
    "video: bursts of 16": [_OFF, _OFF, _ONWARDS, _OFF],
    "all of these": [_PICTURE, _PICTURE, _ONWARDS, _ONWARDS],
    "bursts of 16 read anywhere": [_OFF, _OFF, _FULL, _OFF],
    "1 to 8 words anywhere, all ports": [Host(ANYWHERE, 0, 1, 8)] * 4,
    "single words read anywhere, one port": [Host(ANYWHERE, 0, 1, 1), _OFF, _OFF, _OFF]}
# Who waits while all others ask for whole bursts.
WAITS = {"video": (2, [_FULL, _FULL, _ALONE, _FULL]), "write": (3, [_FULL, _FULL, _FULL, _ALONE]),
         "read": (0, [_ALONE, _FULL, _FULL, _FULL])}
_CHIPS = ((AS4C16M16SA_6, 133e6, 32), (in_parallel(IS42S16320D_7, 2), 100e6, 32),
          (IS42S16320D_7, 100e6, 64))


def figures(chip, clock_hz, data_width, clocks=400_000):
    """{what: percent of clocks with data, or clocks}, with three read ports and bursts of 16.

    Raises
    ------
    SimulationError
        If a word was wrong or a rule broken.
    """
    made = SdramController(replace(chip, pause=2), clock_hz, data_width, 3, 16)

    def measured(hosts):
        result = run_sdram(made, hosts, clocks=clocks, clock_hz=clock_hz)
        if result["rules"] or result["wrong"]:
            raise SimulationError(f"{result['wrong']} words are wrong, broken: {result['rules']}")
        return result

    found = {name: f"{100 * measured(hosts)['beats'] / clocks:.0f} %"
             for name, hosts in SHARES.items()}
    found["first word, row open"] = made.latency
    for name, (index, hosts) in WAITS.items():
        found[f"burst of 16 done, {name}: longest seen"] = measured(hosts)["longest"][index]
        found[f"burst of 16 done, {name}: bound"] = made.bounds[name]
    return found


def main():
    """Print the table."""
    columns = [figures(*each) for each in _CHIPS]
    titles = (f"{chip.name}, {hz / 1e6:g} MHz, words of {width} bits" for chip, hz, width in _CHIPS)
    print("| | " + " | ".join(titles) + " |")
    print("|---" * (1 + len(columns)) + "|")
    for name in columns[0]:
        print(f"| {name} | " + " | ".join(str(column[name]) for column in columns) + " |")


if __name__ == "__main__":
    main()
