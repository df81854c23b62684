"""Curves of single beams: a model follows a load path to labelled results; twist, bend, cycle, row, bend_twist."""
