"""Mutation score of the gateware: which planted faults its tests find."""
