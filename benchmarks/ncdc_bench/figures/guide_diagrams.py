"""Drawings of guides and pages: ``python -m ncdc_bench.figures.guide_diagrams docs/figures``."""

import sys
from pathlib import Path
from typing import NamedTuple

from ncdc_bench.figures.box_drawing import draw_boxes

__all__ = ["DRAWINGS", "Drawing", "draw_all"]


class Drawing(NamedTuple):
    """Parameters of :func:`ncdc_bench.figures.box_drawing.boxes_figure`."""
    boxes: tuple
    arrows: tuple
    note: str
    size: tuple = (12.5, 4.1)
    vertical: tuple = ()


DRAWINGS = {
    "how-it-works.svg": Drawing(
        ((0, 6.6, 2.4, 1.5, "photo of a target"),
         (5.0, 6.6, 2.2, 1.5, "points"),
         (9.8, 6.6, 2.4, 1.5, "net.toml\n\nintegers"),
         (14.8, 6.6, 2.6, 1.5, "golden model\n\ncorrected picture"),
         (0, 3.0, 2.4, 1.6, "scan\n\nrow by row"),
         (5.0, 3.0, 2.2, 1.6, "network\n\ntan-sigmoid"),
         (9.8, 3.0, 2.4, 1.6, "fetcher\n\ncache of tiles"),
         (14.8, 3.0, 2.6, 1.6, "Bayer\ninterpolation"),
         (9.8, -.4, 2.4, 1.4, "memory\n\nraw frames"),
         (14.8, -.4, 2.6, 1.4, "memory or stream\n\ncorrected pixels")),
        ((2.4, 5.0, 7.3, "ncdc calibrate", ""), (7.2, 9.8, 7.3, "ncdc train", ""),
         (12.2, 14.8, 7.3, "ncdc correct", ""),
         (2.4, 5.0, 3.8, "x, y", "output pixel"), (7.2, 9.8, 3.8, "x', y'", "source"),
         (12.2, 14.8, 3.8, "6x6 samples", "")),
        "above: on a PC, once per camera; below: in hardware, for every frame",
        (12.5, 5.6), (
            (11.0, 6.6, 4.6, "ncdc generate: this\nwhole row as Verilog"),
            (16.1, 4.6, 6.6, "ncdc simulate:\nevery pixel compared"),
            (11.0, 1.0, 3.0, "tiles"),
            (16.1, 3.0, 1.0, "24 bits"))),
    "csi2.svg": Drawing(
        ((0, 2.6, 2.2, 3.0, "PHY\n\ndeserialisers,\nlow-power\ndetection"),
         (4.2, 2.6, 2.2, 3.0, "WordAligner\n\none per lane\n\nsync byte"),
         (8.4, 2.6, 2.2, 3.0, "LaneAligner\n\nskew of\n4 bytes"),
         (12.5, 2.6, 2.6, 3.0, "Packets\n\nHeaderDecoder\n\nChecksum"),
         (17.0, 2.6, 2.5, 3.0, "Unpacker\n\nRAW8, RAW10,\nRAW12"),
         (21.5, 0, 1.7, 5.6, "stream of\nsamples\n\nto Capture"),
         (12.5, 0, 2.6, 1.2, "Frames"),
         (4.2, 0, 2.4, 1.2, "FaultCounters")),
        ((2.2, 4.2, 4.1, "data, active", "8 bits per clock"),
         (6.4, 8.4, 4.1, "data, valid", "bytes of a burst"),
         (10.6, 12.5, 4.1, "words", "a byte per lane"),
         (15.1, 17.0, 4.1, "payload", "words of a row"),
         (19.5, 21.5, 4.1, "samples", "last of a row"),
         (15.1, 21.5, .6, "first, end, bad", "of a frame"),
         (12.5, 6.6, .6, "faults", "a pulse each, into the core's clock")),
        "all parts but the counters are in the clock of the bytes; with aligned=True the PHY "
        "aligns the words",
        (15.5, 4.9), ((13.8, 2.6, 1.2, "begins, ends, faults"),)),
    "gains.svg": Drawing(
        ((0, 4.6, 2.2, 1.6, "sensor\n\n12 bits"),
         (4.0, 4.6, 3.0, 1.6, "black level\n\nCAPTURE_GAINS"),
         (9.2, 4.6, 2.4, 1.6, "curve\n\n12 bits to 8"),
         (14.0, 4.6, 3.2, 1.6, "memory\n\nraw frames"),
         (14.0, 1.0, 3.2, 1.8, "tiles are filled\n\nRAW_GAIN_RED, ..."),
         (8.6, 1.0, 3.0, 1.8, "interpolation\n\nlens correction"),
         (2.8, 1.0, 3.0, 1.8, "GAIN_RED, ...\n\nTONE0 to TONE16"),
         (-1.6, 1.0, 1.8, 1.8, "corrected\npixels")),
        ((2.2, 4.0, 5.4, "", ""), (7.0, 9.2, 5.4, "", ""), (11.6, 14.0, 5.4, "", ""),
         (14.0, 11.6, 1.9, "", ""), (8.6, 5.8, 1.9, "RED_SUM, ...", "measured here"),
         (2.8, .2, 1.9, "", "")),
        "gains of capture: every camera system; RAW_GAIN: --raw-gains; GAIN and TONE: --colour",
        (12.5, 4.6), ((15.6, 4.6, 2.8, ""),)),
    "guide-platform-designer.png": Drawing(
        ((0, 0, 2.9, 4.6, "your system in\nPlatform Designer\n\nprocessor or\nJTAG host\n\n"
          "memory controller"),
         (6.4, 0, 2.7, 4.6, "ncdc_system\n\ncamera, frame stores,\ncorrector\n\nUSB"),
         (12.2, 2.6, 2.5, 2.0, "sensor\n\nMT9P031, ..."),
         (12.2, 0, 2.5, 2.0, "FT232H\n\nto a PC")),
        ((2.9, 6.4, 4.1, "csr", "registers; irq back"),
         (6.4, 2.9, 3.0, "read0, read1", "raw frames; frames for USB"),
         (6.4, 2.9, 1.9, "write", "raw and corrected frames"),
         (12.2, 9.1, 3.9, "sensor", "clock, frame, line, data"),
         (9.1, 12.2, 3.0, "i2c", "two lines, open drain"),
         (9.1, 12.2, 1.0, "usb", "8 data lines, 60 MHz")),
        "one clock and one reset for module and interconnect; sensor and FT232H bring their own "
        "clocks"),
    "de10-nano.png": Drawing(
        ((0, 0, 2.9, 4.6, "hard processor\n\nLinux, /dev/uio0\n\nEthernet\n\nDDR3"),
         (6.6, 0, 2.9, 4.6, "HpsCore\n\ncamera, frame stores,\ncorrector\n\nscan-out"),
         (12.4, 2.6, 2.5, 2.0, "sensor\n\nD5M"),
         (12.4, 0, 2.5, 2.0, "ADV7513\n\nHDMI monitor")),
        ((2.9, 6.6, 4.1, "csr", "lightweight bridge; f2h_irq0 back"),
         (6.6, 2.9, 3.0, "read0", "f2h_sdram0: raw frames, 64 bits"),
         (6.6, 2.9, 1.9, "write", "f2h_sdram1: both frames, 64 bits"),
         (6.6, 2.9, 0.8, "screen", "f2h_sdram2: corrected, 32 bits"),
         (12.4, 9.5, 3.9, "sensor", "clock, frame, line, data"),
         (9.5, 12.4, 2.3, "i2c", "to both"),
         (9.5, 12.4, 1.0, "picture", "24 bits, clock, syncs")),
        "100 MHz for core, ports and bridge; sensor and screen have their own clocks"),
    "board-system.png": Drawing(
        ((0, 1.3, 2.3, 2.0, "88E1111\n\ncable to a PC"),
         (5.4, 0, 3.0, 4.6, "processor\n\nVexRiscv, firmware\n\nMAC, RGMII"),
         (11.7, 0, 3.0, 4.6, "board's core\n\ncamera, corrector\n\nSDRAM, scan-out\n\npacketiser")),
        ((2.3, 5.4, 2.9, "RGMII", "4 wires each way, 125 MHz"),
         (5.4, 2.3, 1.9, "MDIO", "setup, speed"),
         (11.7, 8.4, 3.9, "packets", "whole Ethernet frames"),
         (8.4, 11.7, 2.6, "registers", "settings, lens, claims"),
         (11.7, 8.4, 1.3, "frames", "word by word, Table II")),
        "without --system there is no packetiser, and the registers are reached by serial port and "
        "JTAG alone"),
    "colorlight-i9.png": Drawing(
        ((0, 1.3, 2.3, 2.0, "B50612D\n\ncable to a PC"),
         (5.2, 0, 3.0, 4.6, "processor\n\nVexRiscv, firmware\n\nMAC, RGMII"),
         (11.2, 0, 2.8, 4.6, "board's core\n\ncamera, corrector\n\npacketiser\n\n"
          "SDRAM controller"),
         (16.6, 2.6, 2.1, 2.0, "sensor\n\nMT9P031\n(D5M)"),
         (16.6, 0, 2.1, 2.0, "SDRAM chip\n\n8 MB, 32 bits")),
        ((2.3, 5.2, 2.9, "RGMII", "4 wires each way"),
         (5.2, 2.3, 1.9, "MDIO", "delays, speed"),
         (11.2, 8.2, 3.9, "packets", "whole Ethernet frames"),
         (8.2, 11.2, 2.6, "registers", "settings, lens, claims"),
         (11.2, 8.2, 1.3, "frames", "word by word, Table II"),
         (16.6, 14.0, 4.0, "sensor", "clock, lines, data"), (14.0, 16.6, 3.0, "I2C", "registers"),
         (14.0, 16.6, 1.1, "bursts", "35.7 MHz")),
        "no screen: pictures leave by the cable alone; registers through a serial port too"),
    "guide-zynq.png": Drawing(
        ((0, 0, 2.9, 4.6, "processing system\nof a Zynq or Kria\n\nLinux, /dev/uio0\n\n"
          "DDR memory"),
         (6.4, 0, 2.7, 4.6, "ncdc_system_axi\n\ncamera, frame stores,\ncorrector"),
         (12.2, 1.3, 2.5, 2.0, "sensor\n\nMT9P031, ...")),
        ((2.9, 6.4, 4.1, "s_axi", "M_AXI_GP0 / HPM0: registers"),
         (6.4, 2.9, 3.1, "irq", "IRQ_F2P"),
         (6.4, 2.9, 2.1, "m_axi_read0", "S_AXI_HP0: raw frames"),
         (6.4, 2.9, 1.1, "m_axi_write", "S_AXI_HP1: raw and corrected frames"),
         (12.2, 9.1, 2.9, "sensor", "clock, frame, line, data"),
         (9.1, 12.2, 2.0, "i2c", "two lines, open drain")),
        "aclk, aresetn: from the same clock and reset block as the interconnect"),
    "guide-zynq-mipi.png": Drawing(
        ((0, 0, 2.9, 4.6, "processing system\nof a Zynq or Kria\n\nLinux, /dev/uio0\n\n"
          "DDR memory"),
         (6.2, 0, 3.3, 4.6, "ncdc_system_axi\n\ncamera, frame stores,\ncorrector"),
         (12.8, 1.3, 2.8, 2.3, "MIPI CSI-2 Rx\nSubsystem\n\nAMD's"),
         (18.2, .2, 2.4, 3.4, "sensor\n\nIMX219, ...")),
        ((2.9, 6.2, 4.1, "s_axi", "M_AXI_GP0 / HPM0: registers"),
         (6.2, 2.9, 3.1, "irq", "IRQ_F2P"),
         (6.2, 2.9, 2.1, "m_axi_read0", "S_AXI_HP0: raw frames"),
         (6.2, 2.9, 1.1, "m_axi_write", "S_AXI_HP1: raw and corrected frames"),
         (12.8, 9.5, 3.1, "sensor", "AXI4-Stream video"),
         (12.8, 9.5, 2.0, "sensor_clock", "video_aclk"),
         (18.2, 15.6, 2.6, "D-PHY", "clock, lanes"),
         (9.5, 18.2, .6, "i2c", "two lines, open drain")),
        "the stream has a clock of its own; aclk, aresetn: as those of the interconnect",
        (14.5, 4.1)),
    "guide-platform-designer-mipi.png": Drawing(
        ((0, 0, 2.9, 4.6, "your system in\nPlatform Designer\n\nprocessor or\nJTAG host\n\n"
          "memory controller"),
         (6.2, 0, 3.3, 4.6, "ncdc_system\n\ncamera, frame stores,\ncorrector"),
         (12.8, 1.3, 2.8, 2.3, "MIPI core\n\nwith Avalon-ST\nvideo"),
         (18.2, .2, 2.4, 3.4, "sensor\n\nIMX219, ...")),
        ((2.9, 6.2, 4.1, "csr", "registers; irq back"),
         (6.2, 2.9, 3.0, "read0", "raw frames"),
         (6.2, 2.9, 1.9, "write", "raw and corrected frames"),
         (12.8, 9.5, 3.1, "sensor", "Avalon-ST video"),
         (12.8, 9.5, 2.0, "sensor_clock", "clock of the video"),
         (18.2, 15.6, 2.6, "D-PHY", "clock, lanes"),
         (9.5, 18.2, .6, "i2c", "two lines, open drain")),
        "the stream has a clock of its own; one clock and one reset for module and interconnect",
        (14.5, 4.1)),
    "guide-litex.png": Drawing(
        ((0, 0, 2.9, 4.6, "your LiteX SoC\n\nprocessor, or a\nbridge to a PC\n\n"
          "LiteDRAM:\ncrossbar, controller"),
         (6.4, 0, 2.7, 4.6, "NCDC\n\nregisters\n\ncorrector\n\nbridges to\nnative ports"),
         (12.2, 1.3, 2.5, 2.0, "your encoder,\nfilter or DMA")),
        ((2.9, 6.4, 4.1, "bus", "Wishbone slave: registers"),
         (6.4, 2.9, 3.1, "ev.irq", "EventManager: a frame is done"),
         (6.4, 2.9, 2.1, "get_port()", "native port: raw frames"),
         (6.4, 2.9, 1.1, "get_port()", "native port: corrected frames"),
         (9.1, 12.2, 2.3, "source", 'instead, with output="stream"')),
        "one clock domain, sys; as many native ports as the corrector has hosts"),
    "guide-verilog.png": Drawing(
        ((0, 0, 2.9, 4.6, "your design\n\nregisters: one master,\none access at a time\n\n"
          "your memory\ncontroller"),
         (6.4, 0, 2.7, 4.6, "ncdc\n\nregisters\n\ncache of tiles,\nnetwork,\ninterpolation"),
         (12.2, 1.3, 2.5, 2.0, "your screen\nor encoder")),
        ((2.9, 6.4, 4.1, "csr", "address, read, write, waitrequest"),
         (6.4, 2.9, 3.1, "irq", "a frame is done"),
         (6.4, 2.9, 2.1, "read0", "bursts of 16 bytes, answers in order"),
         (6.4, 2.9, 1.1, "write", "bursts of 1 to 16 words"),
         (9.1, 12.2, 2.3, "stream", "instead, with --to stream")),
        "one clock clk, synchronous reset rst"),
    "usb.png": Drawing(
        ((0, .9, 2.2, 2.8, "PC\n\npyftdi\n\nTable I and II,\nregisters"),
         (4.6, .9, 2.2, 2.8, "FT232H\n\n245 synchronous\nFIFO"),
         (9.2, 0, 2.5, 4.6, "UsbFifo\n\ntwo queues\nbetween\nthe clocks\n\nSplitter"),
         (13.6, 0, 2.8, 4.6, "ByteCommands\n\nByteBridge\n\nTableOne\n\nMrawSender")),
        ((2.2, 4.6, 2.9, "USB 2.0", "requests"), (4.6, 2.2, 1.7, "USB 2.0", "answers, pictures"),
         (6.8, 9.2, 3.2, "RXF# RD# OE#", "60 MHz, 8 bits"),
         (9.2, 6.8, 1.9, "TXE# WR#", "60 MHz, 8 bits"),
         (11.7, 13.6, 3.2, "bytes", ""), (13.6, 11.7, 1.9, "beats", "")),
        "ByteCommands reads and writes registers of the system, and reads frames from memory by "
        "a port of its own"),
    "soc.png": Drawing(
        ((0, 3.1, 2.2, 4.7, "image sensor\n\nMT9P031\n\na model\nat its pins"),
         (4.9, 3.1, 3.4, 4.7, "ncdc_core\n\ncamera: capture,\nframe stores, I2C\n\n"
          "corrector\n\npacketiser\n\nbridges"),
         (11.2, 5.7, 3.6, 2.1, "VexRiscv\n\nROM, SRAM,\nUART, timer"),
         (11.2, 3.1, 3.6, 1.7, "LiteEth MAC\n\nframes in turn"),
         (17.4, 2.4, 2.5, 5.4, "network\n\nTAP in a\nnamespace\n\nAravis,\nviva-genicam,\n"
          "ncdc client"),
         (4.9, 0, 9.9, 1.6, "LiteDRAM: crossbar and controller, SDR SDRAM of 64 MB")),
        ((2.2, 4.9, 6.6, "pixels", "12 bits, clock, lines"),
         (4.9, 2.2, 4.4, "I2C", "exposure, gain"),
         (11.2, 8.3, 6.9, "Wishbone", "registers of all"),
         (8.3, 11.2, 4.1, "frames", "pictures, 32 bits"),
         (14.8, 17.4, 4.5, "pictures", "GVSP"), (17.4, 14.8, 3.4, "commands", "GVCP, TCP")),
        "no processor touches a pixel: it writes headers and registers",
        (12.5, 5.6), (
            (5.2, 3.1, 1.6, "port 0\nwrites"),
            (6.3, 1.6, 3.1, "port 1\npackets"),
            (7.5, 1.6, 3.1, "port 2\ncorrector"),
            (11.7, 5.7, 4.8, "answers"),
            (13.4, 4.8, 5.7, "commands"))),
    "axi.png": Drawing(
        ((-.6, 0, 2.9, 4.6, "processing system\nof a Zynq or Kria\n\nLinux, ncdc_driver.py\n"
          "/dev/uio0\n\nDDR memory"),
         (5.7, 0, 2.6, 4.6, "ncdc_axi\n\nregisters\n\ncache of tiles,\nnetwork,\ninterpolation\n\n"
          "burst writer"),
         (11.2, .9, 2.1, 1.1, "video out,\nVDMA, ...")),
        ((2.3, 5.7, 4.1, "s_axi", "M_AXI_GP0 / HPM0: registers"),
         (5.7, 2.3, 3.1, "irq", "IRQ_F2P"),
         (5.7, 2.3, 2.1, "m_axi_read0", "S_AXI_HP0: raw frame"),
         (5.7, 2.3, 1.1, "m_axi_write", "S_AXI_HP1: corrected frame"),
         (8.3, 11.2, 1.45, "m_axis", "instead, with --to stream")),
        "aclk, aresetn: from the same clock and reset block as the interconnect", (11.5, 4.1)),
    "board.png": Drawing(
        ((-.4, 1.5, 2.4, 2.2, "sensor\n\nMT9P031 (D5M),\nOV5640"),
         (4.2, 0, 3.0, 5.2, "camera system\n\ncapture\n\nframe stores\n\ncorrector"),
         (10.0, 0, 2.6, 2.2, "SDRAM controller"),
         (10.0, 3.0, 2.6, 2.2, "scan-out\n\none row early"),
         (15.4, 0, 2.0, 2.2, "SDRAM chip"),
         (15.4, 3.0, 2.0, 2.2, "monitor")),
        ((2.0, 4.2, 3.2, "pixel clock", "frame, line, data"),
         (4.2, 2.0, 2.0, "I2C", "registers"),
         (7.2, 10.0, 1.4, "write", "raw, corrected"),
         (10.0, 7.2, .6, "read", "raw"),
         (7.2, 10.0, 4.1, "reader", "newest whole frame"),
         (12.6, 15.4, 1.1, "bursts", "whole rows"),
         (12.6, 15.4, 4.1, "VGA, GPDI", "the mode's own rate")),
        "the scan-out reads from memory too, with the highest priority; buttons choose the lens; "
        "registers through a serial port", (12.5, 4.3)),
}


def draw_all(folder):
    """Write all drawings into a folder."""
    for name, drawing in DRAWINGS.items():
        draw_boxes(str(Path(folder) / name), *drawing)


if __name__ == "__main__":
    draw_all(sys.argv[1])
