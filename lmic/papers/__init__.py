"""The papers' tables and figures: case tables, their verdicts, and their pictures."""
