"""The corrector as a core of other tools: AXI, Platform Designer, FuseSoC."""
