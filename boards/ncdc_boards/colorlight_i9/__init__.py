"""Colorlight i9 on its extension board: a camera on the network, without a screen."""
