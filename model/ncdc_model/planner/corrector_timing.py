"""Latencies of a corrector's hardware, for the planner."""

from dataclasses import dataclass

__all__ = ["CorrectorTiming"]


@dataclass(frozen=True)
class CorrectorTiming:
    """Clocks between events in a corrector with a tile cache, and capacity of its queues.

    The sums are those of the gateware's parts (``ncdc_hdl.corrector.Corrector.timing``); the
    planner has no latencies of its own. Each is the minimum number of clocks between two events.

    Parameters
    ----------
    start : int
        From the start of a frame to its first look-up in the cache's act stage.
    end : int
        From the last window read to its pixel, at the stream or at the packer.
    claim_to_command : int
        A tile is claimed; its first read command is on the bus.
    fill_to_claim : int
        A tile's last word is on the port; another tile may be claimed.
    fill_to_retire : int
        A tile's last word is on the port; the window that waits for it is read.
    push_to_retire : int
        A look-up leaves the tag stage; its window is read.
    retire_to_push : int
        A window is read; there is space for another look-up.
    retire_to_replace : int
        A window is read; a look-up that replaces its tiles may leave.
    push_to_claim : int
        A look-up leaves the tag stage; the first tile that it misses is claimed.
    pixel_to_bus : int
        A pixel is at the packer; the first word of the burst that it completes is on the bus.
    row_to_lookup : int
        ``camera_rows`` counts a row; the look-up that waited for it is in the act stage.
    end_to_interrupt : int
        The last pixel is out; the interrupt is high.
    write_burst : int
        Words of a burst of corrected pixels.
    queued_words : int
        Words of corrected pixels in the burst writer, at most.
    queued_pixels : int
        Pixels of windows read that are not yet taken, at most: on their way, or in the
        interpolator's queue.
    nodes, node_clocks : int
        Distance of nodes in pixels, and clocks per node; 1 and the clocks per group of pixels for
        a network at every pixel.
    lead : int
        Clocks by which coordinates are computed in advance, while earlier ones wait for memory.
    """
    start: int
    end: int
    claim_to_command: int
    fill_to_claim: int
    fill_to_retire: int
    push_to_retire: int
    retire_to_push: int
    retire_to_replace: int
    push_to_claim: int
    pixel_to_bus: int
    row_to_lookup: int
    end_to_interrupt: int
    write_burst: int
    queued_words: int
    queued_pixels: int
    nodes: int = 1
    node_clocks: int = 1
    lead: int = 0

    @property
    def read_to_bus(self):
        """From a window read to the first word of the burst that its pixel completes."""
        return self.end + self.pixel_to_bus
