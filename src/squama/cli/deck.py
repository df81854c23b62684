"""squama deck: an input deck of a finite beam for another finite element program."""

from __future__ import annotations

from typing import Annotated, Any

from cyclopts import Parameter

from squama.cli.options import Problems, flag, read_number, read_overrides
from squama.errors import InputError

PROGRAMS = ("calculix", "abaqus")


def deck(
    beam: str,
    /,
    *,
    out: Annotated[str, Parameter(name=("--out", "-o"), help="Deck to write (.inp).", allow_leading_hyphen=True)],
    program: Annotated[str, flag("Program that is to read it: calculix or abaqus (calculix).", "--for")] = "calculix",
    scales: Annotated[str | None, flag("Number of scales, 2 to 100 (that of the file).")] = None,
    mu: Annotated[str | None, flag("Coefficient of friction, e.g. 0.25.")] = None,
    to: Annotated[
        str, flag('Twist at the end: "5 rad/m", "0.2 rad/pitch" or "90 deg total" ("0.15 rad/pitch").')
    ] = "0.15 rad/pitch",
    size: Annotated[str, flag("Size of the substrate's elements, in pitches (0.3).")] = "0.3",
    edge_size: Annotated[str, flag("Size of elements along the embedded scales' edges, in pitches (0.08).")] = "0.08",
    increments: Annotated[str, flag("Number of increments (25).")] = "25",
    material: Annotated[str, flag("Substrate: neo-hookean or elastic (neo-hookean).")] = "neo-hookean",
    set_: Annotated[
        tuple[str, ...],
        flag('A value in place of the file\'s, e.g. scale.alpha="30 deg"; may be repeated.', "--set"),
    ] = (),
    json: Annotated[bool, Parameter(help="Print what was written as JSON.")] = False,
) -> int:
    """Write an input deck of a finite beam for CalculiX or Abaqus.

    Parameters
    ----------
    beam
        Beam file (TOML); "squama new beam.toml" writes an example.
    """
    from squama import files, store
    from squama.cli import run
    from squama.cli.row import read_scales, read_twist

    problems = Problems()
    arguments: dict[str, Any] = {}
    overrides: dict[str, dict[str, Any]] = {}
    if program not in PROGRAMS:
        problems.lines.append(f"--for = {files.label(program)}: must be {' or '.join(PROGRAMS)}")
    if material not in ("neo-hookean", "elastic"):
        problems.lines.append(f"--material = {files.label(material)}: must be neo-hookean or elastic")
    with problems.caught():
        arguments["scales"] = read_scales(scales, 100)
    with problems.caught():
        arguments["size"] = read_number("--size", size, 0.01, 10, "0.01 to 10", "0.3")
    with problems.caught():
        arguments["edge_size"] = read_number("--edge-size", edge_size, 1e-3, 10, "0.001 to 10", "0.08")
    with problems.caught():
        arguments["increments"] = _whole("--increments", increments)
    with problems.caught():
        if mu is not None:
            overrides.setdefault("friction", {})["mu"] = read_number("--mu", mu, 0.0, 10.0, "0 to 10", "0.25")
    with problems.caught():
        overrides = {**read_overrides(set_), **overrides}
    with problems.caught():
        store.check_place(out, (".inp",))
    described = None
    with problems.caught():
        described = run.read_beam(beam, overrides)
    if described is not None:
        arguments["scales"] = arguments.get("scales") or described.scales
        with problems.caught():
            described = described.replace(scales=arguments["scales"])
            arguments["twist"] = read_twist("--to", to, described) * described.pitch
        if described.friction.mu is None:
            problems.lines.append(
                f"{files.label(beam)}: friction.mu: is missing; write mu = 0.25 under [friction] or give --mu 0.25"
            )
    problems.settle()
    assert described is not None
    assert described.friction.mu is not None

    from squama.fe import deck as decks

    model = decks.model(described, mu=described.friction.mu, material=material, **arguments)
    text = decks.write(model, program)
    place = files.atomic_write(out, lambda path: path.write_text(text, encoding="utf-8"))
    facts = {
        "out": str(place),
        "program": program,
        "scales": model.scales,
        "nodes": len(model.nodes),
        "elements": len(model.tets),
        "twist_per_pitch": arguments["twist"],
    }
    if json:
        from squama.cli import record

        record.show(facts)
        return 0
    print(
        f"wrote {files.label(out)}: {model.scales} scales, {len(model.tets)} quadratic tetrahedra, "
        f"{arguments['twist']:.4g} rad per pitch"
    )
    if program == "abaqus":
        print("this deck was never run in Abaqus, only its syntax was checked; look at the contact in every increment")
    else:
        stem = files.label(out).removesuffix(".inp")
        print(f"run it with: ccx -i {stem}  (CalculiX; on Debian and Ubuntu: apt-get install calculix-ccx)")
    return 0


def _whole(name: str, text: str) -> int:
    value = read_number(name, text, 1, 10_000, "1 to 10000", "25")
    if value != int(value):
        message = f"{name} = {text}: is not a whole number; write e.g. 25"
        raise InputError(message)
    return int(value)
