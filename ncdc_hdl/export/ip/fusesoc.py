"""The corrector as a FuseSoC core."""

from importlib.metadata import version

__all__ = ["CORE_NAME", "fusesoc_core"]

CORE_NAME = "ncdc:ip:ncdc"      # vendor, library, name; a module with another name has its own


def fusesoc_core(corrector, top):
    """Text of the ``.core`` file (CAPI 2) next to the Verilog of ``corrector``.

    The fileset ``rtl`` is the file ``<top>.v`` with the module ``top``, and the waivers of
    ``<top>.vlt``. Targets: ``default``, for cores that depend on this one, and ``lint``, which is
    ``verilator --lint-only -Wall``. Cores of several modules have names of their own.
    """
    library, _, _ = CORE_NAME.rpartition(":")
    return f"""\
CAPI=2:
name: {library}:{top}:{version('ncdc')}
description: Camera distortion corrector, descriptor {corrector.descriptor.digest}

filesets:
  rtl:
    files:
      - {top}.vlt: {{file_type: vlt}}
      - {top}.v: {{file_type: verilogSource-2005}}

targets:
  default: &default
    filesets: [rtl]
    toplevel: {top}
  lint:
    <<: *default
    flow: lint
    flow_options:
      tool: verilator
      mode: lint-only
      verilator_options: [-Wall]
"""
