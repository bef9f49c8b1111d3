"""Programs for a user's PC: the client of devices, and an emulated device."""
