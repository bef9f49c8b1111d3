"""Components of the gateware alone, compared with golden models: stimuli that tests and the
mutation score share."""
