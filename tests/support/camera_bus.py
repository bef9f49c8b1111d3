"""A camera system as its drivers see it, without gateware."""

__all__ = ["Bus"]


class Bus:
    """Registers of a camera system as words, targets on its I2C bus, and what its readers claim.

    A transfer is rejected if no device has its address.

    Parameters
    ----------
    names : module
        The project's ``ncdc_registers``.
    targets : dict
        Of each address on the bus {register as bytes: value as bytes}; what is written is stored.
    """

    def __init__(self, names, targets):
        self.names, self.words = names, {}
        self.newest = {}    # of "RAW" and "CORRECTED": the buffer that a claim gets, and its number
        self.lose = 0       # so many claims are taken away while they are read
        self.at = {offset: name for name, offset in names.OFFSET.items()}
        self.targets, self.transfer, self.answer = targets, None, []
        self.log = []       # (address, bytes), and the names of registers that are written

    def read(self, offset):
        return self.words.get(offset, 0)

    def write(self, offset, value):
        name = self.at[offset]
        if name.startswith("READER") and name[-1].isdigit():
            self.words[offset] = self._claimed(name, value)
        elif name == "I2C_COMMAND":
            self.words[self.names.OFFSET["I2C_RESULT"]] = self._i2c(value)
        elif name != "CAMERA_STATUS":
            self.words[offset] = value
            self.log.append(name)

    def _claimed(self, reader, word):
        """What the reader's register then has."""
        flags = {flag: getattr(self.names, f"{reader}_{flag}") for flag in (
            "CLAIM_RAW", "CLAIM_CORRECTED", "RELEASE", "HELD", "LOST", "BUFFER")}
        store = "RAW" if word & flags["CLAIM_RAW"] else "CORRECTED"
        if word & flags["RELEASE"] or store not in self.newest:
            return 0
        buffer, number = self.newest[store]
        self.words[self.names.OFFSET[f"{store}{buffer}_NUMBER"]] = number
        lost, self.lose = flags["LOST"] * (self.lose > 0), max(0, self.lose - 1)
        return flags["HELD"] | lost | buffer * (flags["BUFFER"] & -flags["BUFFER"])

    def _i2c(self, word):
        names = self.names
        has = {flag: word & getattr(names, f"I2C_COMMAND_{flag}")
               for flag in ("START", "WRITE", "READ", "STOP")}
        byte, data = word & 0xFF, 0
        if has["START"]:
            if byte >> 1 not in self.targets:
                return names.I2C_RESULT_NACK
            if byte & 1:
                self.answer = list(self.targets[byte >> 1].get(bytes(self.transfer[1]), b"\0\0"))
            else:
                self.transfer = (byte >> 1, [])
        elif has["WRITE"]:
            self.transfer[1].append(byte)
        elif has["READ"] and self.answer:
            data = self.answer.pop(0)
        if has["STOP"] and has["WRITE"]:
            address, sent = self.transfer[0], bytes(self.transfer[1])
            self.log.append((address, sent))
            self.targets[address][sent[:1]] = sent[1:]
        return data
