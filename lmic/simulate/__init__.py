"""Simulation of closed loops along parameter trajectories: one file for each kind of system."""
