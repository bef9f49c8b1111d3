"""IP-XACT of a module with AXI ports, for Vivado's IP catalogue."""

from importlib.metadata import version
from xml.etree import ElementTree

from ncdc_hdl.avalon.bus import PENDING
from ncdc_hdl.export.testbench.ports import ports_of_text

__all__ = ["IP_XACT", "component_name", "component_xml"]

IP_XACT = "component.xml"       # the name that Vivado expects

# IEEE 1685-2009, which Vivado reads and writes.
_NAMESPACE = "http://www.spiritconsortium.org/XMLSchema/SPIRIT/1685-2009"
_XILINX = "http://www.xilinx.com"
_FAMILIES = ("zynq", "zynquplus", "artix7", "kintex7", "virtex7", "kintexu", "virtexuplus",
             "versal")
_SENSOR = "sensor"      # prefix of the camera's ports, and name of its AXI4-Stream
_BURST = 16             # most words of a burst
_MANAGED = 1 << 32      # bytes that a manager can address


def component_name(text):
    """Name of the core that a ``component.xml`` describes; None if it is not one."""
    try:
        return ElementTree.fromstring(text).findtext(_tag("name"))
    except ElementTree.ParseError:
        return None


def component_xml(verilog, module, descriptor):
    """Text of ``component.xml`` for ``module`` of ``verilog``, IP-XACT of IEEE 1685-2009.

    Bus interfaces of the types that Vivado has for AXI4, AXI4-Lite, AXI4-Stream, clocks, resets and
    interrupts, named after their ports' prefixes.
    """
    return _Component(verilog, module, descriptor).text()


class _Component:
    """Builds the description."""

    def __init__(self, verilog, module, descriptor):
        self.module, self.ports = module, ports_of_text(verilog, module)
        names = [port.name for port in self.ports]
        self.buses = [prefix for prefix in ("s_axi", "m_axi_read0", "m_axi_read1", "m_axi_read2",
                                            "m_axi_write", "m_axis")
                      if any(name.startswith(f"{prefix}_") for name in names)]
        self.video = [port for port in self.ports if port.name.startswith(f"{_SENSOR}_t")]
        ElementTree.register_namespace("spirit", _NAMESPACE)
        ElementTree.register_namespace("xilinx", _XILINX)
        self.root = ElementTree.Element(_tag("component"))
        for name, value in (("vendor", "ncdc"), ("library", "ip"), ("name", module),
                            ("version", version("ncdc"))):
            self._add(self.root, name, value)
        self._interfaces()
        self._spaces()
        self._model()
        self._files()
        g = descriptor.geometry
        self._add(self.root, "description", (
            f"NCDC camera distortion corrector: {g.distorted_width}x{g.distorted_height} raw "
            f"samples to {g.corrected_width}x{g.corrected_height} pixels"))
        self._parameters(self.root, {"Component_Name": module})
        self._extensions()

    def text(self):
        """Text of the file."""
        ElementTree.indent(self.root)
        return ('<?xml version="1.0" encoding="UTF-8"?>\n'
                + ElementTree.tostring(self.root, encoding="unicode") + "\n")

    def _add(self, parent, tag, text=None, /, **attributes):
        """A new element of ``parent``."""
        element = ElementTree.SubElement(
            parent, _tag(tag), {_tag(key): value for key, value in attributes.items()})
        element.text = None if text is None else str(text)
        return element

    def _parameters(self, parent, values):
        parameters = self._add(parent, "parameters")
        for name, value in values.items():
            parameter = self._add(parameters, "parameter")
            self._add(parameter, "name", name)
            self._add(parameter, "value", value)

    def _interface(self, parent, name, kind, mode, ports, parameters):
        """A bus interface of the type library:``kind``; ``ports``: (logical, physical) names."""
        library, kind = kind
        element = self._add(parent, "busInterface")
        self._add(element, "name", name)
        self._add(element, "busType", vendor="xilinx.com", library=library, name=kind,
                  version="1.0")
        self._add(element, "abstractionType", vendor="xilinx.com", library=library,
                  name=f"{kind}_rtl", version="1.0")
        role = self._add(element, mode)
        if kind == "aximm":
            self._add(role, "memoryMapRef" if mode == "slave" else "addressSpaceRef", None,
                      **{"memoryMapRef" if mode == "slave" else "addressSpaceRef": name})
        maps = self._add(element, "portMaps")
        for logical, physical in ports:
            one = self._add(maps, "portMap")
            self._add(self._add(one, "logicalPort"), "name", logical)
            self._add(self._add(one, "physicalPort"), "name", physical)
        if parameters:
            self._parameters(element, parameters)

    def _interfaces(self):
        parent = self._add(self.root, "busInterfaces")
        for bus in self.buses:
            ports = [(port.name.removeprefix(f"{bus}_").upper(), port.name) for port in self.ports
                     if port.name.startswith(f"{bus}_")]
            mode = "slave" if bus.startswith("s_") else "master"
            parameters = {}
            if bus == "s_axi":
                parameters = {"PROTOCOL": "AXI4LITE"}
            elif bus.startswith("m_axi_"):
                write = bus.endswith("write")
                way = "WRITE" if write else "READ"
                parameters = {"PROTOCOL": "AXI4", "READ_WRITE_MODE": f"{way}_ONLY",
                              "MAX_BURST_LENGTH": _BURST, f"NUM_{way}_OUTSTANDING": PENDING,
                              "SUPPORTS_NARROW_BURST": 0}
            self._interface(parent, bus, ("interface", "axis" if bus == "m_axis" else "aximm"),
                            mode, ports, parameters)
        self._interface(parent, "aresetn", ("signal", "reset"), "slave", [("RST", "aresetn")],
                        {"POLARITY": "ACTIVE_LOW"})
        self._interface(parent, "aclk", ("signal", "clock"), "slave", [("CLK", "aclk")],
                        {"ASSOCIATED_BUSIF": ":".join(self.buses), "ASSOCIATED_RESET": "aresetn"})
        if self.video:
            self._interface(parent, _SENSOR, ("interface", "axis"), "slave",
                            [(port.name.removeprefix(f"{_SENSOR}_").upper(), port.name)
                             for port in self.video], {})
            self._interface(parent, f"{_SENSOR}_clock", ("signal", "clock"), "slave",
                            [("CLK", f"{_SENSOR}_clock")], {"ASSOCIATED_BUSIF": _SENSOR})
        self._interface(parent, "irq", ("signal", "interrupt"), "master", [("INTERRUPT", "irq")],
                        {"SENSITIVITY": "LEVEL_HIGH"})

    def _spaces(self):
        """Address spaces of the managers; the registers' memory map."""
        spaces = self._add(self.root, "addressSpaces")
        for bus in self.buses:
            if bus.startswith("m_axi_"):
                space = self._add(spaces, "addressSpace")
                self._add(space, "name", bus)
                self._add(space, "range", _MANAGED)
                [width] = {port.width for port in self.ports
                           if port.name in (f"{bus}_rdata", f"{bus}_wdata")}
                self._add(space, "width", width)
        [address] = [port for port in self.ports if port.name == "s_axi_awaddr"]
        map_ = self._add(self._add(self.root, "memoryMaps"), "memoryMap")
        self._add(map_, "name", "s_axi")
        block = self._add(map_, "addressBlock")
        for name, value in (("name", "registers"), ("baseAddress", 0),
                            ("range", 1 << address.width), ("width", 32), ("usage", "register")):
            self._add(block, name, value)

    def _model(self):
        """Views for synthesis and simulation; the ports."""
        model = self._add(self.root, "model")
        views = self._add(model, "views")
        for use in ("synthesis", "simulation"):
            view = self._add(views, "view")
            self._add(view, "name", f"xilinx_anylanguage{use}")
            self._add(view, "envIdentifier", f"verilogSource:vivado.xilinx.com:{use}")
            self._add(view, "language", "verilog")
            self._add(view, "modelName", self.module)
            self._add(self._add(view, "fileSetRef"), "localName", "verilog")
        ports = self._add(model, "ports")
        for port in self.ports:
            element = self._add(ports, "port")
            self._add(element, "name", port.name)
            wire = self._add(element, "wire")
            self._add(wire, "direction", {"input": "in", "output": "out"}[port.direction])
            if port.range:
                vector = self._add(wire, "vector")
                self._add(vector, "left", port.width - 1)
                self._add(vector, "right", 0)
            if port.name in ("core_rst", "camera_rows"):        # may be left unconnected
                self._add(self._add(wire, "driver"), "defaultValue", 0)

    def _files(self):
        files = self._add(self._add(self.root, "fileSets"), "fileSet")
        self._add(files, "name", "verilog")
        file = self._add(files, "file")
        self._add(file, "name", f"{self.module}.v")
        self._add(file, "fileType", "verilogSource")

    def _extensions(self):
        """Further data for Vivado's catalogue."""
        core = ElementTree.SubElement(self._add(self.root, "vendorExtensions"),
                                      f"{{{_XILINX}}}coreExtensions")
        families = ElementTree.SubElement(core, f"{{{_XILINX}}}supportedFamilies")
        for name in _FAMILIES:
            family = ElementTree.SubElement(families, f"{{{_XILINX}}}family",
                                            {f"{{{_XILINX}}}lifeCycle": "Beta"})
            family.text = name
        for name, text in (("displayName", "NCDC camera distortion corrector"),
                           ("coreRevision", "1")):
            ElementTree.SubElement(core, f"{{{_XILINX}}}{name}").text = text
        taxonomies = ElementTree.Element(f"{{{_XILINX}}}taxonomies")
        category = ElementTree.SubElement(taxonomies, f"{{{_XILINX}}}taxonomy")
        category.text = "/Video_&_Image_Processing"
        core.insert(1, taxonomies)


def _tag(name):
    return f"{{{_NAMESPACE}}}{name}"
