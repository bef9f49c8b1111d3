"""The GenICam XML of a device: what any client reads to know its features, made from the table."""

import xml.etree.ElementTree as ElementTree
from xml.etree.ElementTree import Element, SubElement

from ncdc_spec.protocols.features import FEATURES

__all__ = ["genicam_xml"]

_SCHEMA = "http://www.genicam.org/GenApi/Version_1_1"
_ACCESS = {"rw": "RW", "ro": "RO", "wo": "WO"}
_NODES = {"integer": "Integer", "float": "Float", "boolean": "Boolean",
          "enumeration": "Enumeration", "command": "Command"}


def genicam_xml(colour=True, features=FEATURES):
    """The XML text, UTF-8 bytes; the same bytes for the same features.

    Parameters
    ----------
    colour : bool
        Whether the device's corrector has gains of the colours. Without them, the XML lacks the
        features that need them.
    features : sequence of Feature
        Of the device's sensor, as of :func:`~ncdc_spec.protocols.features.features_of`.
    """
    features = [one for one in features if not one.lacking and (colour or not one.needs_colour)]
    root = Element("RegisterDescription", {
        "ModelName": "NCDC", "VendorName": "NCDC", "StandardNameSpace": "None",
        "SchemaMajorVersion": "1", "SchemaMinorVersion": "1", "SchemaSubMinorVersion": "0",
        "MajorVersion": "1", "MinorVersion": "0", "SubMinorVersion": "0",
        "ToolTip": "Camera with distortion correction",
        "ProductGuid": "6e636463-0000-4000-8000-000000000001",
        "VersionGuid": "6e636463-0000-4000-8000-000000000002", "xmlns": _SCHEMA})
    _categories(root, features)
    for one in features:
        if one.kind == "text":
            _string_register(root, one)
        else:
            _node(root, one)
            _register(root, one)
    SubElement(root, "Port", Name="Device", NameSpace="Standard")
    # One line each, not indented: devices have little space for it.
    ElementTree.indent(root, "")
    return ElementTree.tostring(root, "utf-8", xml_declaration=True)


def _values(parent, **values):
    """Append an element with text for each value, in order."""
    for name, value in values.items():
        SubElement(parent, name).text = str(value)


def _categories(root, features):
    names = list(dict.fromkeys(one.category for one in features))
    top = SubElement(root, "Category", Name="Root", NameSpace="Standard")
    for name in names:
        _values(top, pFeature=name)
    for name in names:
        category = SubElement(root, "Category", Name=name, NameSpace="Standard")
        for one in features:
            if one.category == name:
                _values(category, pFeature=one.name)


def _head(root, tag, one):
    name_space = "Custom" if one.category == "NcdcControl" else "Standard"
    node = SubElement(root, tag, Name=one.name, NameSpace=name_space)
    _values(node, Description=one.text, Visibility="Beginner")
    return node


def _string_register(root, one):
    node = _head(root, "StringReg", one)
    _values(node, Address=f"0x{one.address:X}", Length=one.length, AccessMode="RO",
            pPort="Device", Cachable="NoCache")


def _node(root, one):
    """The feature itself, and what its limits are computed by."""
    node = _head(root, _NODES[one.kind], one)
    if one.locked:
        _values(node, pIsLocked="TLParamsLocked")
    if one.locked_by:
        _values(node, pIsLocked=f"{one.locked_by}Register")     # Off is 0
    if one.kind == "enumeration":
        for choice in one.choices:
            entry = SubElement(node, "EnumEntry", Name=choice.name, NameSpace="Custom")
            _values(entry, Value=choice.value)
    register = f"{one.name}Register"
    if one.kind == "command":
        _values(node, pValue=register, CommandValue=1)
    elif one.kind == "boolean":
        _values(node, pValue=register, OnValue=1, OffValue=0)
    elif one.kind == "enumeration":
        _values(node, pValue=register)
        for selected in one.selects:
            _values(node, pSelected=selected)
    elif one.kind == "float":
        _float(root, node, one, register)
    else:
        _values(node, pValue=register, Min=one.low)
        if one.high_from:
            _values(node, pMax=_high(root, one))
        else:
            _values(node, Max=one.high)
        _values(node, Inc=one.step)
        if one.unit:
            _values(node, Unit=one.unit)
        _values(node, Representation="Linear" if one.access == "rw" else "PureNumber")


def _high(root, one):
    """Name of the node that holds the highest value of ``one``."""
    if len(one.high_from) == 1:
        return one.high_from[0]
    whole, part = one.high_from
    name = f"{one.name}Highest"
    knife = SubElement(root, "IntSwissKnife", Name=name)
    # Read past the features themselves: the limits of one need those of the other.
    for variable, used in (("WHOLE", whole), ("PART", part)):
        SubElement(knife, "pVariable", Name=variable).text = f"{used}Register"
    _values(knife, Formula="WHOLE-PART")
    return name


def _float(root, node, one, register):
    """A float feature by a converter; the limits in its unit."""
    numerator, denominator = one.scale
    converter = SubElement(root, "Converter", Name=f"{one.name}Converter")
    factor = f"{numerator}.0/{denominator}.0"
    variables = []      # of the formulas
    # Clients differ in how they round to the register; a whole number leaves them no choice.
    if one.scale_from:
        variables.append(("FACTOR", f"{one.scale_from}Register"))
        factor = f"FACTOR*{factor}"
    for name, used in variables:
        SubElement(converter, "pVariable", Name=name).text = used
    whole = "FLOOR" if one.low < 0 else "TRUNC"
    _values(converter, FormulaTo=f"{whole}(FROM/({factor})+0.5)", FormulaFrom=f"TO*({factor})",
            pValue=register, Slope="Increasing")
    _values(node, pValue=f"{one.name}Converter")
    if variables:
        for side, value in (("Min", one.low), ("Max", one.high)):
            knife = SubElement(root, "SwissKnife", Name=f"{one.name}{side}")
            SubElement(knife, "pVariable", Name="FACTOR").text = variables[0][1]
            _values(knife, Formula=f"{value}*({factor})")
            _values(node, **{f"p{side}": f"{one.name}{side}"})
    else:
        _values(node, Min=one.low * numerator / denominator, Max=one.high * numerator / denominator)
    if one.unit:
        _values(node, Unit=one.unit)
    _values(node, Representation="Linear")


def _register(root, one):
    tag, name = "IntReg", f"{one.name}Register"
    if one.field:
        tag = "MaskedIntReg"
    node = SubElement(root, tag, Name=name)
    _values(node, Address=f"0x{one.address:X}", Length=4, AccessMode=_ACCESS[one.access],
            pPort="Device", Cachable="NoCache")
    if tag == "MaskedIntReg":
        # Bits are counted from the most significant one in big-endian registers.
        lowest, width = one.field
        _values(node, LSB=31 - lowest, MSB=31 - lowest - width + 1)
    _values(node, Sign="Signed" if one.low < 0 else "Unsigned", Endianess="BigEndian")
