"""Single beams: a load path is followed by a model to a labelled answer; twist, bend, cycle and row."""
