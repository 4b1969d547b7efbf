"""The whole system under one seed: network, clocks, disks and processes are simulated, all the rest is real."""
