"""Sweeps: one theorem at many scalars, plants, bases and relaxations, on every core or on a cluster."""
