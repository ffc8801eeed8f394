"""The parts of scripts/check_outputs.py: one module a family of formats."""
