"""Free and forced vibration of beams, damped by the friction between scales (docs, theory: vibration)."""
