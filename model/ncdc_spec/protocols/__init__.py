"""The protocols between clients and devices, and the features that both show."""
