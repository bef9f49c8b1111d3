"""The ULX3S as a board."""

from ncdc_boards.ecp5.board import Ecp5Board
from ncdc_boards.ecp5.csi2_camera import LANE_HZ_MAX
from ncdc_boards.sdram.chips import ULX3S_32MB
from ncdc_boards.ulx3s.clocks import CORE_MHZ, clock_plan
from ncdc_boards.ulx3s.platform import Ulx3sPlatform
from ncdc_boards.ulx3s.top import Ulx3sTop

__all__ = ["BOARD"]

BOARD = Ecp5Board(
    name="ulx3s", title="Radiona ULX3S", device="LFE5U-85F-6BG381C", platform=Ulx3sPlatform,
    chip=ULX3S_32MB, memory_bytes=ULX3S_32MB.bytes, core_mhz=CORE_MHZ, clock_plan=clock_plan,
    top=Ulx3sTop, baud=1_000_000, multiplier_bits=18,
    sources=("amaranth-boards, ulx3s.py", "litex-boards, radiona_ulx3s.py"),
    pattern_bits=1 << 21,       # of 3.8 million; the largest cores take 1.1
    csi_lane_hz=LANE_HZ_MAX)
