"""The commands and their modules; a module is imported when its command is called."""

from __future__ import annotations

from cyclopts import App, CycloptsError, Parameter
from cyclopts.exceptions import MissingArgumentError, UnknownCommandError, UnusedCliTokensError

from squama._version import __version__
from squama.io.files import label

COMMANDS = {
    "new": "Write a commented example of a beam file.",
    "twist": "Twist a beam: free range, torque, stiffness, stress, friction.",
    "bend": "Bend a beam: free range, moment, stiffness, stress, friction.",
    "bend-twist": "Bend and twist a beam along a path: moment, torque, contacts, end.",
    "cycle": "Load and unload a beam: loops, dissipation, damping, jamming.",
    "vibrate": "Let a beam vibrate freely: frequency, decay, damping of every cycle.",
    "shake": "Shake a beam by a harmonic torque: steady states over the frequency, up and down.",
    "fit": "Fit friction, joint stiffness and other parameters to measured torque and twist.",
    "plan": "Plan a test: which loops would tell friction, joint stiffness and modulus, and how exactly.",
    "design": "Find beams that meet a target file: engagement, stiffness, torque, stress, dissipation.",
    "pareto": "Find trade-offs between stiffness, torque, range and dissipation, from a target file (extra fit).",
    "row": "Twist a row of N scales: inclination of every scale, influence of the ends.",
    "load": "Load a part of N scales on its supports: forces, moments, a tendon, its weight.",
    "law": "Write the law of a beam's section for rod and section programs: CSV, npz, Abaqus, Ansys, LS-DYNA.",
    "joint": "Compute the stiffness of a scale's joint by finite elements (extra fe).",
    "cell": "Twist one pitch, or a finite beam, by finite elements (extra fe).",
    "verify": "Compare the models with finite elements along the twist (extra fe).",
    "deck": "Write an input deck of a finite beam for CalculiX or Abaqus (extra fe).",
    "export": "Write scales, substrate and mould as solids for the printer, with a bill of materials (extra export).",
    "ends": "Find engagement and end of many designs of hinged scales, from a table.",
    "sweep": "Solve a beam over ranges of its parameters, into a store that can be resumed.",
    "map": "Draw a slice of a sweep, or write it as CSV: contours, regimes, lock envelopes.",
    "view": "Draw a beam in space: picture, animation, or a page to turn it.",
    "explore": "Open a page in the browser to turn, change, load and compare a beam (extra web).",
    "uncertainty": "Compute what tolerances do to a beam: Monte Carlo, probabilities, Sobol indices.",
    "paper": "Compute the figures of the paper on twisting (2020) and check its claims.",
}
"""Names of the commands and their descriptions; each is the function of its name ("_" for "-") in its module."""

EXAMPLES = {
    "new": "beam.toml",
    "twist": 'beam.toml --to "90 deg total" --plot curve.png --csv curve.csv',
    "bend": "beam.toml --mu 0,0.3 --plot bend.png",
    "bend-twist": 'beam.toml --path "bend 4 rad/m; twist 8 rad/m" --plot path.png',
    "cycle": 'beam.toml --to "90 deg total" --loops 2 --plot loop.png',
    "vibrate": 'beam.toml --rotor "1e-4 kg m2" --release "100 deg total"',
    "shake": 'beam.toml --rotor "1e-4 kg m2" --static "20 deg total" \\\n  --lowest "2 Hz" --highest "3 Hz"',
    "fit": "test.csv beam.toml --plot fit.png",
    "plan": 'beam.toml --noise "0.2 N mm" --plot plan.png',
    "design": "target.toml -o designs",
    "pareto": "target.toml --plot front.png --csv front.csv",
    "row": "beam.toml --scales 9 --plot row.png",
    "load": "cantilever.toml --plot part.png",
    "law": 'beam.toml --bend "5 rad/m" --twist "5 rad/m" --mu 0 -o beam.inp',
    "joint": "beam.toml --levels 2",
    "cell": 'beam.toml --to "0.15 rad/pitch" --mesh coarse --csv cell.csv',
    "verify": 'beam.toml --to "0.15 rad/pitch" -o verify',
    "deck": "beam.toml -o beam.inp",
    "export": "beam.toml -o printed",
    "ends": "designs.csv -o ends.csv",
    "sweep": "beam.toml --over mu=0:1:41 --over alpha=15deg:75deg:31 -o map.zarr",
    "map": "map.zarr --plot map.png",
    "view": 'beam.toml -o beam.png --twist "60 deg total"',
    "explore": "beam.toml",
    "uncertainty": 'beam.toml --vary mu="0.25 +- 0.03" --plot tolerances.png',
    "paper": "fig4 fig7b -o paper",
}
"""Arguments of the example under the help of each command, in lines of 80 characters."""

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
    """Return the command-line program."""
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
        module = _ELSEWHERE.get(name, name).replace("-", "_")
        below = f"Example:\nsquama {name} {EXAMPLES[name]}"
        app.command(f"squama.cli.{module}:{name.replace('-', '_')}", name=name, help=text, help_epilogue=below)
    completes = "Let the shell complete commands, flags and files: bash, zsh, fish, PowerShell."
    app.register_install_completion_command(group="Shell", help=completes)
    return app


def usage_problem(error: CycloptsError) -> str:
    """Return the mistake of a command line, in one line."""
    chain = " ".join(("squama", *(error.command_chain or ())))
    see = f'see "{chain} --help"'
    if isinstance(error, UnusedCliTokensError) and error.unused_tokens:
        return f"{label(' '.join(error.unused_tokens))}: is more than the command takes; {see}"
    if isinstance(error, MissingArgumentError) and error.argument is not None:
        return f"{error.argument.name}: is missing or has no value; {see}"
    words = " ".join(str(error).split())
    if isinstance(error, UnknownCommandError):
        words = words.partition(" Available commands:")[0]
    text = label(words)
    return text if text.endswith("?") else f"{text.rstrip('.')}; {see}"
