"""Blocks between LiteEth's MAC and the pins of an Ethernet PHY: RGMII, GMII and MII."""

from ncdc_soc.phy.mii import GmiiPhy, MiiPhy
from ncdc_soc.phy.rgmii import RgmiiPhy

__all__ = ["GmiiPhy", "MiiPhy", "RgmiiPhy"]
