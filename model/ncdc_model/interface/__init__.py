"""What gateware, drivers, firmware and clients agree on: registers, and frames in memory."""
