"""Solver's problem: prepared tables, checks, and notes on defects of the mesh."""
