"""The commands and where they live; each is imported when it is called."""

from __future__ import annotations

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import MissingArgumentError, UnusedCliTokensError

from squama._version import __version__
from squama.io.files import label

COMMANDS = {
    "new": "Write a commented example of a beam file.",
    "twist": "Twist a beam as it is made, beside simpler models: torque, stiffness, stress and friction.",
    "bend": "Bend a beam of hinged scales towards them: moment, locking and friction, from a beam file.",
    "cycle": "Load and unload a beam: loops, stick intervals, dissipation, damping, jamming.",
    "vibrate": "Let a beam swing: its decay, and the damping of every cycle.",
    "shake": "Shake a beam by a harmonic torque: steady states over frequencies, both ways.",
    "fit": "Find friction, joint stiffness and other parameters of a beam from measured torque and twist.",
    "design": "Find beams of hinged scales that lock, bear or dissipate as asked, from a target file.",
    "pareto": "Trade stiffness, range and dissipation of hinged scales off: a front, from a target file (extra fit).",
    "row": "Twist a finite row of scales: every scale's inclination, and how far the ends are felt.",
    "joint": "Stiffness of a scale's joint by finite elements, beside the scaling laws (extra fe).",
    "cell": "Twist one pitch of finite elements with helical periodicity, or a finite beam (extra fe).",
    "verify": "Set the models beside finite elements: differences along the twist, and how far each holds (extra fe).",
    "deck": "Write an input deck of a finite beam for CalculiX or Abaqus.",
    "export": "Write scales, substrate and mould as solids for the printer, with a bill of materials (extra export).",
    "ends": "Find where many designs of hinged scales engage and how they end, from a table.",
    "sweep": "Solve a beam of hinged scales over ranges of parameters, into a store that can be resumed.",
    "map": "Draw a slice of a sweep: contours, regimes, lock envelopes; or write it as CSV.",
    "view": "Draw a beam in space: picture, animation, or a page of its own that turns it.",
    "explore": "Open a page in the browser on which a beam is turned, changed, loaded and compared (extra web).",
    "uncertainty": "Say what tolerances do to hinged scales: Monte Carlo, probability of locking, Sobol indices.",
    "paper": "Compute the figures of the paper on twisting (2020) and check its claims.",
}
"""Names of the commands and what they do; each is the function of that name in its module (:func:`make`)."""

_ROOMS = {
    "twist": ("bend", "row"),
    "design": ("pareto",),
    "elements": ("cell", "verify", "deck"),
    "sweep": ("map",),
    "vibrate": ("shake",),
    "short": ("new", "ends", "paper", "explore"),
}
_ELSEWHERE = {name: module for module, names in _ROOMS.items() for name in names}


def make() -> App:
    """Return the program."""
    app = App(
        name="squama",
        version=__version__,
        help="Mechanics of scale-covered beams in twisting and bending, with friction.",
        help_epilogue='Start with "squama new beam.toml", then "squama twist beam.toml".',
        help_format="plaintext",
        default_parameter=Parameter(negative=(), show_default=False),
        suppress_keyboard_interrupt=False,
    )
    for name, text in COMMANDS.items():
        module = _ELSEWHERE.get(name, name)
        app.command(f"squama.cli.{module}:{name}", name=name, help=text)
    return app


def usage_problem(error: CycloptsError) -> str:
    """Return what is wrong with a command line, in one line."""
    chain = " ".join(("squama", *(error.command_chain or ())))
    see = f'see "{chain} --help"'
    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        return f"{label(' '.join(error.unused_tokens))}: is more than the command takes; {see}"
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        return f"{error.argument.name}: is missing or has no value; {see}"
    text = label(" ".join(str(error).split()))
    return text if text.endswith("?") else f"{text.rstrip('.')}; {see}"
