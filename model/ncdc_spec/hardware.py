"""Choices of the hardware that change its size and speed, never its results."""

from dataclasses import dataclass, replace

from ncdc_spec.cache_options import TILE_MEMORIES, CacheOptions
from ncdc_spec.errors import InputError
from ncdc_spec.frames import BGRX8, OUTPUT_FORMATS, check_format, output_format
from ncdc_spec.geometry import check_strip_width
from ncdc_spec.interpolation import FAST
from ncdc_spec.nodes import NODES, nodes_fit, row_nodes
from ncdc_spec.view import check_view_nodes
from ncdc_spec.view_list import MAX_VIEWS
from ncdc_spec.view_rows import MAX_MATRICES, MIN_MATRICES

__all__ = ["BUSES", "DATA_WIDTHS", "FETCHERS", "FORMATS", "HIDDEN", "LANES", "MULTIPLIER_BITS",
           "OUTPUTS", "VIDEOS", "Hardware", "check_lanes"]

DATA_WIDTHS = (32, 64, 128)
OUTPUTS = ("memory", "stream")
FETCHERS = ("cache", "multiport")
HIDDEN = ("multiply", "raster")
MULTIPLIER_BITS = (27, 18)
LANES = (1, 2, 4)
FORMATS = tuple(OUTPUT_FORMATS)
BUSES = ("avalon", "axi")
VIDEOS = ("plain", "vip")
NODE_CLOCKS = 2         # that a node takes at least: its scan adds up the next one meanwhile
VIEW_NODE_CLOCKS = 3    # with a view, whose scan adds up three coordinates in turn
ROWS_NODE_CLOCKS = 6    # with a table, which gives them for two matrices in turn


@dataclass(frozen=True)
class Hardware:
    """Configuration of a corrector; every choice gives the same pixels.

    The one object that carries these choices from the command line to planner, gateware, simulation
    and the header of the Verilog.

    Parameters
    ----------
    data_width : int
        Bits of the memory ports: 32, 64 or 128.
    output : str
        "memory": corrected pixels are written to memory; "stream": they leave as video, row by row.
    fetcher : str
        "cache": a prefetching cache of tiles; "multiport": the paper's three burst readers.
    cache : CacheOptions, optional
        Sizes of the tile cache; those of :meth:`CacheOptions.for_width` if absent.
    split : int, optional
        The tile cache's split, after configuration; default :meth:`CacheOptions.split_for`.
    strip : int
        Columns of the strips in whose order pixels are made, after configuration; 0: a raster.
    hidden : str
        "multiply": two multipliers per hidden neuron; "raster": one adder per hidden neuron,
        which follows the scan.
    share : int, optional
        Hidden neurons that one tan-sigmoid serves in turn: one coordinate, or one node, every
        ``share`` clocks. The multipliers are shared likewise. If absent as many as let a coordinate
        follow per clock and lane, see :meth:`share_for`.
    multiplier_bits : int
        Bits of the device's multiplier blocks: 27 makes each product of the neurons one
        multiplication, 18 cuts it into parts that fit blocks of 18 x 18 bits.
    lanes : int
        Pixels per clock, 1, 2 or 4: neighbours of a row, each with a network of its own.
    colour : bool
        Whether there are registers for white balance and tone, which after configuration change
        no pixel, and sums of the colours.
    raw_balance : bool
        Whether there are gains of the colours before interpolation, of raw samples as the tile
        cache is filled, which after configuration change no pixel.
    view : bool
        Whether there are registers for the matrix of a :class:`~ncdc_spec.view.View`, which after
        configuration changes no pixel. The network must be at nodes.
    views : int
        Most views of one raw frame that a start makes, 2 to 8, for hardware with a ``view`` and
        pixels in memory; 0: no list of views.
    view_rows : int
        Matrices of a view's :class:`~ncdc_spec.view_rows.RowTable` that there is space for; 0:
        there is none.
    format : str
        Name of the ``OutputFormat`` of pixels in memory, after configuration.
    bus : str
        "avalon": ports for Avalon-MM and Avalon-ST; "axi": for AXI4, AXI4-Lite and AXI4-Stream.
    video : str
        Packets of a stream: "plain", one packet of pixels per frame, or "vip", those of Intel's
        Video and Image Processing Suite.
    tile_memory : str
        Of the tile cache, one of :data:`~ncdc_spec.cache_options.TILE_MEMORIES`.
    fixed_lens : bool
        Whether lens, sizes, format and order of pixels are constants: of the set, only addresses
        and colour have registers.
    follow : bool
        Whether a frame may begin before its raw frame is complete.
    counters : bool
        Whether events of a frame are counted; frames are in any case.

    Raises
    ------
    InputError
        If a value is none of the above, strips or a format are asked of a stream, the multiport
        fetcher is to give more than one pixel per clock, gains of raw samples or tiles in LUTs,
        packets of Intel's suite are asked of anything but a stream of Avalon's with one pixel per
        clock, or several views of hardware without a view, or of a stream, or a table of matrices
        without a view, with a list of views, or of other than 2 to 64, or a view of a fixed lens.
    """
    data_width: int = 32
    output: str = "memory"
    fetcher: str = "cache"
    cache: CacheOptions | None = None
    split: int | None = None
    strip: int = 0
    hidden: str = "multiply"
    share: int | None = None
    multiplier_bits: int = 27
    lanes: int = 1
    colour: bool = False
    raw_balance: bool = False
    view: bool = False
    views: int = 0
    view_rows: int = 0
    format: str = BGRX8.name
    bus: str = BUSES[0]
    video: str = VIDEOS[0]
    tile_memory: str = TILE_MEMORIES[0]
    fixed_lens: bool = False
    follow: bool = True
    counters: bool = True

    def __post_init__(self):
        for name, value, choices in (
                ("the memory's data width", self.data_width, DATA_WIDTHS),
                ("the output", self.output, OUTPUTS), ("fetch", self.fetcher, FETCHERS),
                ("hidden", self.hidden, HIDDEN),
                ("the tile memory", self.tile_memory, TILE_MEMORIES),
                ("multiplier bits", self.multiplier_bits, MULTIPLIER_BITS),
                ("pixels per clock", self.lanes, LANES), ("the format", self.format, FORMATS),
                ("the bus", self.bus, BUSES), ("the video", self.video, VIDEOS)):
            if value not in choices:
                raise InputError(f"{name} is {value!r}, one of {', '.join(map(str, choices))} is "
                                 f"needed")
        if self.share is not None and self.share < 1:
            raise InputError(f"share is {self.share}, the least is 1")
        check_strip_width(self.strip)
        if self.strip and self.stream:
            raise InputError(f"the strip width is {self.strip}, a video stream needs 0 (raster)")
        if self.stream and self.format != BGRX8.name:
            raise InputError(f"the format is {self.format}, a video stream has none: its pixels "
                             f"are always of 24 bits")
        if self.lanes > 1 and not self.cached:
            raise InputError(f"pixels per clock is {self.lanes}, the multiport fetcher can have 1 "
                             f"only")
        if self.tile_memory != TILE_MEMORIES[0] and not self.cached:
            raise InputError(f"fetch is multiport, tile memory {self.tile_memory} needs cache")
        if self.tile_memory == "shared" and (self.lanes, self.data_width) != (1, 32):
            raise InputError(f"tile memory is shared, with {self.lanes} pixels per clock and data "
                             f"of {self.data_width} bits; it needs 1 pixel and 32 bits")
        if self.raw_balance and not self.cached:
            raise InputError("fetch is multiport, gains of raw samples need cache")
        if self.fixed_lens and self.view:
            raise InputError("the hardware has a fixed lens, a view needs registers of the lens")
        if self.views:
            self._check_views()
        if self.video != VIDEOS[0]:
            self._check_video()
        if self.view_rows:
            self._check_rows()

    def _check_rows(self):
        """Reject a table of matrices without a view, or of a size that there is not."""
        if not MIN_MATRICES <= self.view_rows <= MAX_MATRICES:
            raise InputError(f"the view's table has {self.view_rows} matrices, the limits are "
                             f"{MIN_MATRICES} and {MAX_MATRICES}")
        if not self.view:
            raise InputError(f"the view's table has {self.view_rows} matrices, it needs a view")
        if self.views:
            raise InputError(f"the view's table has {self.view_rows} matrices, hardware with a "
                             f"list of {self.views} views has no table")

    def _check_views(self):
        """Reject a list of views of a wrong length, without a view, or of a stream."""
        if not 2 <= self.views <= MAX_VIEWS:
            raise InputError(f"the number of views is {self.views}, the limits are 2 and "
                             f"{MAX_VIEWS}")
        if not self.view:
            raise InputError(f"the number of views is {self.views}, it needs hardware with a view")
        if self.stream:
            raise InputError(f"the number of views is {self.views}, a video stream has one")

    def _check_video(self):
        """Reject packets of Intel's suite without an Avalon stream of one pixel per clock."""
        for name, value, needed in (("the output", self.output, "stream"),
                                    ("the bus", self.bus, "avalon"),
                                    ("pixels per clock", self.lanes, 1)):
            if value != needed:
                raise InputError(f"{name} is {value}, the video {self.video} needs {needed}")

    @property
    def stream(self):
        """Whether corrected pixels leave as a video stream."""
        return self.output == "stream"

    @property
    def axi(self):
        """Whether its ports are those of AXI."""
        return self.bus == "axi"

    @property
    def cached(self):
        """Whether raw windows come from the tile cache."""
        return self.fetcher == "cache"

    @property
    def min_node_clocks(self):
        """Clocks that a node takes at least."""
        if self.view_rows:
            return ROWS_NODE_CLOCKS
        return VIEW_NODE_CLOCKS if self.view else NODE_CLOCKS

    def cache_for(self, geometry):
        """Sizes of the tile cache for a camera of ``geometry``."""
        return self.cache or CacheOptions.for_width(geometry.distorted_width,
                                                    geometry.interpolation)

    def split_for(self, geometry):
        """The tile cache's split for a camera of ``geometry``.

        Raises
        ------
        InputError
            If the tile cache has no such split.
        """
        cache = self.cache_for(geometry)
        if self.split is None:
            return cache.split_for(geometry.distorted_width)
        return cache.check_split(self.split)

    def units(self, hidden_neurons):
        """Tan-sigmoids of a network of ``hidden_neurons``.

        Raises
        ------
        InputError
            If there are fewer neurons than one tan-sigmoid could serve.
        """
        share = self.share or 1
        if share > hidden_neurons:
            raise InputError(f"share is {share}, the limit is the number of hidden neurons, "
                             f"{hidden_neurons}")
        return -(-hidden_neurons // share)

    def served(self, hidden_neurons):
        """Neurons that the tan-sigmoids of a network of ``hidden_neurons`` could serve, turns
        without a neuron included."""
        return self.units(hidden_neurons) * (self.share or 1)

    def in_memory(self, layer):
        """Whether what the neurons of ``layer``, "hidden" or "output", have for each hidden neuron
        lies in memories, where a unit reads it in turn, and not in registers."""
        return (not self.fixed_lens and (self.share or 1) > 1
                and (layer == "output" or self.hidden == "multiply"))

    def node_clocks(self, descriptor):
        """Clocks that a node may take, if a row's nodes are to come in the clocks of its groups.

        The row is that of a full strip, or of the picture without strips; at least 1.
        """
        width = descriptor.geometry.corrected_width
        columns = min(self.strip or width, width)
        return max(1, columns // (self.lanes * row_nodes(columns, descriptor.nodes)))

    def share_for(self, descriptor):
        """Neurons that a tan-sigmoid serves in turn, for the camera of ``descriptor``.

        It is 1 for a network at every pixel. With nodes, the fewest tan-sigmoids are used that give
        a node within :meth:`node_clocks`, and the neurons are distributed evenly over them.
        """
        if self.share is not None or descriptor.nodes == 1:
            return self.share or 1
        neurons = descriptor.hidden_neurons
        return -(-neurons // -(-neurons // self.node_clocks(descriptor)))

    def row_clocks(self, descriptor):
        """(Groups of pixels of a row, clocks that its nodes take) of a network at nodes.

        The row is that of a full strip, or of the picture without strips.
        """
        width = descriptor.geometry.corrected_width
        columns = min(self.strip or width, width)
        return (columns // self.lanes, max(self.share_for(descriptor), self.min_node_clocks)
                * row_nodes(columns, descriptor.nodes))

    def keeps_rate(self, descriptor):
        """Whether the front end can give a coordinate per clock and lane."""
        share = self.share_for(descriptor)
        if descriptor.nodes == 1:
            return share == 1
        groups, clocks = self.row_clocks(descriptor)
        return clocks <= groups

    def nodes_at_rate(self, descriptor):
        """Distances of nodes above the descriptor's at which no pixel waits for a node: a list.

        With as many units as the hardware would have for each.
        """
        width, free = descriptor.geometry.corrected_width, replace(self, share=None)
        return [nodes for nodes in NODES if nodes > descriptor.nodes and nodes_fit(nodes, width)
                and free.keeps_rate(replace(descriptor, nodes=nodes))]

    def made_for(self, descriptor):
        """This hardware, with a tile cache and units of a number, for the camera of ``descriptor``.

        Raises
        ------
        InputError
            If the pixels per clock do not divide the corrected width, a tan-sigmoid is to serve
            more neurons than there are, hidden neurons at nodes are to follow the scan of pixels,
            there is to be a view of a network at every pixel,
            the tile cache has no such split, the windows of the descriptor's interpolation
            cannot be fetched, or the format would lose the camera's colours.
        """
        geometry = descriptor.geometry
        needed = geometry.interpolation
        if not self.cached and needed != FAST:
            raise InputError(f"the descriptor's interpolation is {needed.name}, the multiport "
                             f"fetcher can have {FAST.name} only, which ncdc train "
                             f"--interpolation {FAST.name} gives")
        if self.cached and self.cache_for(geometry).interpolation != needed:
            raise InputError(f"the tile cache is for the interpolation "
                             f"{self.cache.interpolation.name}, the descriptor's is {needed.name}")
        check_lanes(geometry.corrected_width, self.lanes)
        check_format(output_format(self.format), geometry)
        if self.hidden == "raster" and descriptor.nodes > 1:
            raise InputError(f"hidden is raster, a network at every {descriptor.nodes}th pixel "
                             f"needs multiply")
        if self.view:
            check_view_nodes(descriptor.nodes)
        self.units(descriptor.hidden_neurons)
        self.split_for(geometry)
        return replace(self, cache=self.cache_for(geometry), share=self.share_for(descriptor))

    def report(self, geometry):
        """The choices under their names in every report, for a camera of ``geometry``."""
        cache = self.cache_for(geometry) if self.cached else None
        return {"fetch": self.fetcher, "cache_bytes": cache.bytes if cache else 0,
                "cache_split": self.split_for(geometry) if cache else 0, "strip": self.strip,
                "data_width": self.data_width, "output": self.output, "hidden": self.hidden,
                "share": self.share, "multiplier_bits": self.multiplier_bits,
                "pixels_per_clock": self.lanes, "format": None if self.stream else self.format,
                "colour": self.colour, "raw_balance": self.raw_balance, "view": self.view,
                "views": self.views, "view_rows": self.view_rows,
                "tile_memory": self.tile_memory if cache else None,
                "fixed_lens": self.fixed_lens, "follow": self.follow,
                "counters": self.counters, "bus": self.bus,
                "video": self.video if self.stream else None}

    def options(self, geometry):
        """The options of ``ncdc generate`` that choose this, for a camera of ``geometry``."""
        cache = [*self.cache_for(geometry).options,
                 f"--cache-split {self.split_for(geometry)}"] if self.cached else []
        return [f"--fetch {self.fetcher}", *cache, f"--strip {self.strip}",
                f"--data-width {self.data_width}", f"--to {self.output}",
                f"--hidden {self.hidden}", f"--share {self.share}",
                f"--multiplier-bits {self.multiplier_bits}", f"--pixels-per-clock {self.lanes}",
                *([] if self.stream else [f"--format {self.format}"]),
                *(["--colour"] if self.colour else []),
                *(["--raw-gains"] if self.raw_balance else []),
                *(["--view"] if self.view else []),
                *([f"--views {self.views}"] if self.views else []),
                *([f"--view-rows {self.view_rows}"] if self.view_rows else []),
                *([f"--tile-memory {self.tile_memory}"]
                  if self.tile_memory != TILE_MEMORIES[0] else []),
                *(["--fixed-lens"] if self.fixed_lens else []),
                *([] if self.follow else ["--no-follow"]),
                *([] if self.counters else ["--no-counters"]),
                *([f"--bus {self.bus}"] if self.axi else []),
                *([f"--video {self.video}"] if self.video != VIDEOS[0] else [])]


def check_lanes(width, lanes):
    """Raise :class:`InputError` unless a picture ``width`` pixels wide has whole groups of
    ``lanes``."""
    if width % lanes:
        raise InputError(f"the corrected width is {width}, {lanes} pixels per clock need a "
                         f"multiple of {lanes}")
