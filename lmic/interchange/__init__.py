"""Semidefinite programs as files of other programs, and as their objects."""
