"""squama plan: expected errors of a test's loops."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from squama.cli import flags, output
from squama.cli.fit import Joint, with_unit
from squama.cli.flags import flag, settled, whole
from squama.errors import refuse
from squama.loads import LOADS
from squama.units import is_number

if TYPE_CHECKING:
    import xarray as xr

    from squama.identify.expected import Plan

_NOISE = 'Standard deviation of a measured torque, e.g. "0.2 N mm"; must be given.'
_TWIST_NOISE = 'Standard deviation of a measured twist, e.g. "0.2 deg total". Default: 0.'
_MACHINE = 'Stiffness of the testing machine in series, e.g. "2 N m/rad". Default: rigid.'
_FIND = "Parameters to find, as in squama fit: mu, K_theta, C_f, E_B, theta0, torque_zero ... Default: mu,K_theta,E_B."
_TO = f"Largest twist of the test: {flags.TWISTS}."
_TOPS = 'Tops of the loops, e.g. "60, 90, 140 deg total". Default: 1.2, 1.5, 2 and 3 times the engagement.'


def _tops(name: str, text: str) -> tuple[str, ...]:
    """Return the twists of a list whose last number has the unit of all."""
    *numbers, last = (part.strip() for part in text.split(","))
    if is_number(last) or not all(map(is_number, numbers)):
        refuse(name, f'"{text}"', "are not numbers with one unit behind them", 'write e.g. "60, 90, 140 deg total"')
    unit = last.lstrip("+-.0123456789eE")
    return (*(f"{number} {unit.strip()}" for number in numbers), last)


@flags.group
class Test:
    """The test, and its required accuracy."""

    noise: Annotated[str | None, flag(_NOISE, read=with_unit("N mm"))] = None
    twist_noise: Annotated[str | None, flag(_TWIST_NOISE, read=with_unit("deg total"))] = None
    machine: Annotated[str | None, flag(_MACHINE, read=with_unit("N m/rad"))] = None
    to: Annotated[str | None, flag(_TO, read=with_unit("deg total"))] = None
    tops: Annotated[tuple[str, ...] | None, flag(_TOPS, read=flags.Reader(_tops, ()))] = None
    points: Annotated[int, flag("Readings of a loop. Default: 100.", read=whole(10, 10_000, "100"))] = 100
    accuracy: Annotated[str, flag('Relative standard error to reach, e.g. "2 %". Default: 5 %.')] = "5 %"


@flags.group
class Model:
    """Load and model."""

    load: flags.Load = "twisting"
    law: flags.Law = "edge"
    joint: Joint = None
    ends: flags.Ends = None


TEST, MODEL = Test(), Model()


def plan(
    beam: flags.BeamFile,
    /,
    *,
    find: Annotated[str | None, flag(_FIND)] = None,
    test: Test = TEST,
    model: Model = MODEL,
    full: flags.Full = False,
    common: flags.Common = flags.COMMON,
) -> int:
    """Plan a test: which loops would tell friction, joint stiffness and modulus, and how exactly."""
    if test.noise is None and "--noise" not in flags.problems().flags:
        flags.problems().add("--noise", "", "is not given", 'say how exact the load cell is, e.g. --noise "0.2 N mm"')
    common.check(beam)
    described = settled(common.beam(beam, friction=False))

    from squama.identify.planning import plan as planned

    names = {name: f"--{name.replace('_', '-')}" for name in (*vars(test), *vars(model))} | {"parameters": "--find"}
    given = {name: value for name, value in {**vars(test), **vars(model)}.items() if value is not None}
    with flags.laid(names):
        found = planned(described, *(() if find is None else (find,)), **given)
    written = output.write(common, found.dataset, "plan_figure", flat)
    return output.report(common.json, beam, written, found.report(), _summary(found).shown(full=full))


def _summary(found: Plan) -> output.Summary:
    """Return the summary: the recommended test and its errors; all loops in full."""
    kind = LOADS[found.load].model(found.law, found.joint, found.scales)
    first, *others = found.verdict()
    rests, *notes = found.notes()
    table = output.table(*found.table(), left=1)
    return output.Summary(first, [("errors", rests), ("model", kind)], others, (), [table, *notes])


def flat(dataset: xr.Dataset) -> xr.Dataset:
    """Return a plan as a table: a row for each loop, a column for each correlation."""
    names, related = dataset["parameter"].values.tolist(), dataset["correlation"].values
    pairs = {
        f"correlation_{names[j]}_{one}": ("candidate", related[:, i, j], {"long_name": "correlation"})
        for i, one in enumerate(names)
        for j in range(i)
    }
    return dataset.drop_dims(["parameter", "other"]).assign(pairs)
