"""The reference system: processor, memory controller and Ethernet around the camera system."""
