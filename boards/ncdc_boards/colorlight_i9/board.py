"""The Colorlight i9 as a board of the catalogue."""

from ncdc_boards.camera_board.board import EthernetChip
from ncdc_boards.colorlight_i9.clocks import CORE_MHZ, clock_plan
from ncdc_boards.colorlight_i9.platform import ColorlightI9Platform
from ncdc_boards.colorlight_i9.top import ColorlightI9Top
from ncdc_boards.ecp5.board import Ecp5Board
from ncdc_boards.ecp5.csi2_camera import LANE_HZ_MAX
from ncdc_boards.sdram.chips import M12L64322A_7
from ncdc_spec.interpolation import FAST, GRADIENT

__all__ = ["BOARD"]

BOARD = Ecp5Board(
    name="colorlight-i9", title="Colorlight i9", device="LFE5U-45F-6BG381C",
    platform=ColorlightI9Platform, chip=M12L64322A_7, memory_bytes=M12L64322A_7.bytes,
    core_mhz=CORE_MHZ, clock_plan=clock_plan, top=ColorlightI9Top, baud=1_000_000,
    multiplier_bits=18,
    sources=("litex-boards, colorlight_i5.py", "github.com/wuxx/Colorlight-FPGA-Projects, "
             "colorlight_i9_v7.2.md"),
    ethernet=EthernetChip(addresses=range(1), delays=True), screen=False, byte_masks=False,
    interpolations=(FAST.name, GRADIENT.name), tile_memory="shared", csi_lane_hz=LANE_HZ_MAX)
