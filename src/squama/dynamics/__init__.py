"""Vibration: what the friction of scales takes from a swing (docs, theory: vibration)."""
