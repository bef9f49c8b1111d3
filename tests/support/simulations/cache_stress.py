"""The tile cache's Verilog on random windows, with a random memory and a random sink."""

from ncdc_hdl.backend.layouts import request_layout, window_layout
from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import build, command_of
from ncdc_sim.transcript import transcribed
from ncdc_spec.white_balance import GAIN_BITS
from simulations import HDL

__all__ = ["stress_cache"]

TOP = "cache"


def stress_cache(cache, *, groups, frame_bits=12, seed=1, resets=0, far=0, verilog=None,
                 transcripts=None):
    """Run ``groups`` groups of windows through a :class:`ncdc_hdl.backend.cache.cache.Cache`.

    See ``hdl/cache_main.cpp`` for what happens to it and what is checked.

    Parameters
    ----------
    cache : Cache
    groups : int
        Groups of as many windows as the cache has lanes.
    frame_bits : int
        log2 of the most groups of a frame.
    seed : int
        Seed of all random behaviour.
    resets : int
        Frames of 256 that a reset cuts short.
    far : int
        1: windows lie at the end of their frames, and these anywhere in the address space.
    verilog : str
        Text of the cache, whose module is ``cache``; None: it is made.
    transcripts : list
        The run's transcript is added to it.

    Returns
    -------
    dict
        ``windows`` compared, ``wrong`` ones among them, ``total_clocks``, ``tiles`` read,
        ``frames`` completed, ``resets``, and ``outputs``, a hash of the outputs of all clocks.

    Raises
    ------
    SimulationError
        If the cache reads a wrong tile, breaks a rule of its ports, or hangs.
    """
    needs = cache.options.interpolation
    defines = {"NCDC_LANES": cache.lanes, "NCDC_DATA_WIDTH": cache.data_width,
               "NCDC_TILES": cache.options.tiles, "NCDC_FRACTION_BITS": cache.f_bits,
               "NCDC_CORE": needs.core, "NCDC_MARGIN": needs.margin,
               "NCDC_TILE_HEIGHT": needs.tile_height, "NCDC_TILE_ROWS": needs.tile_rows,
               "NCDC_BOX_ROWS": needs.box_rows, "NCDC_BOX_WORDS": needs.box_words(cache.lanes)[0],
               "NCDC_BOX_WORD": needs.box_words(cache.lanes)[1],
               "NCDC_WINDOW_LATENCY": cache.window_latency,
               "NCDC_GAIN_BITS": GAIN_BITS * cache.raw_balance}
    for letter, layout in (("I", request_layout(cache.f_bits, cache.lanes, needs)),
                           ("O", window_layout(cache.f_bits, cache.lanes, needs))):
        fields, lanes = dict(layout), 0
        if cache.lanes > 1:
            lanes = layout["lane"].shape.elem_shape.size
            fields |= dict(layout["lane"].shape.elem_shape)
        defines |= {f"{letter}_{name.upper()}": field.offset for name, field in fields.items()}
        defines[f"{letter}_LANE"] = lanes
    flags = " ".join(f"-D{name}={value}" for name, value in sorted(defines.items()))
    program = build("cache-stress", TOP, [(f"{TOP}.v", verilog or module_verilog(cache, TOP))],
                    main=HDL / "cache_main.cpp", options=("-CFLAGS", flags))
    command = [*command_of(program), f"+seed={seed}", f"+groups={groups}", f"+resets={resets}",
               f"+frame_bits={frame_bits}", f"+far={far}"]
    lines = []
    transcribed(command, lines.append, transcripts)
    return {name: int(value) for _, name, value in map(str.split, lines)}
