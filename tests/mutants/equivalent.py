"""Changes that are no error, by file and line of text, each with its reason."""

from __future__ import annotations

_TUNING = "how closely is looked, not what is found: more or less of it gives the same figures"
_ROUNDING = "a threshold between rounding and what counts: nothing lies between the two values"
_ZERO = "a zero that only gives the shape"
_OUT_OF_REACH = "looks at one neighbour more, which cannot be reached"
_SIGN = "the solver takes brackets of either sign"
_WIDER = "a bracket wider by a sample holds the same valley or crossing"
_MORE = "looks into more valleys between samples than it must"
_ENDS = "only the values at the ends are read"
_STRETCH = "only moves what the rule of the work is stretched to; the work is the same"
_UNKNOWN = "NumPy takes any number below 0 for the one that it finds"
_SHARP = "when a step counts as the last: the next ones change no digit"
_GUESS = "a guess of the time that a run takes"
_BEGINS = "where a search begins; it ends at the same place"
_NOTHING = "there is no work: whatever the series is stretched over, its terms are zero"

_NONE = "any number below 0 stands for none"
_BEYOND = "looks at crossings a little beyond the ends of edges, where none is taken"
_ROOM = "room that is not used"
_SLIDES = "only read where the contact slides"

EQUIVALENT: dict[tuple[str, str], dict[str, str]] = {
    ("model/paths.py", "return 1e-300 - x * x / 2"): {
        "1e-300 -> (1e-300 * 1.1)": "keeps 0/0 away: any number too small to be seen does",
    },
    ("model/bending.py", "for _ in range(8):"): {"*": _TUNING},
    ("model/bending.py", "if np.all(abs(step) <= 1e-12 * abs(psi)):"): {
        "1e-12 -> (1e-12 * 1.1)": _ROUNDING,
        "* -> /": "stops later or at the last of the eight steps, at the same digits",
        "abs -> nothing #2": "psi is positive",
    },
    ("model/bending.py", "q=1.0,"): {
        "1.0 -> 2.0": "there is no root of the contact condition in bending; nothing reads it"
    },
    ("model/history.py", "h = 1e-4 * (b - a)"): {
        "1e-4 -> (1e-4 * 1.1)": "the step of an estimate, as in model/energy.py",
        "* -> /": "as above: only how far a pole is stretched to",
    },
    ("model/history.py", "bottom = _bottom(f, float(x[i - 1]), float(x[i + 1]))"): {
        "1 -> 2": _WIDER,
        "1 -> 2 #2": _WIDER,
    },
    ("model/history.py", "return bracketed(lambda v: float(f(v)), float(x[i + 1]), bottom)"): {"1 -> 2": _WIDER},
    ("model/history.py", "return bracketed(lambda v: float(f(v)), float(x[first + 1]), float(x[first]))"): {
        "1 -> 2": _WIDER,
    },
    ("model/history.py", "bottom = middle - (right - left) ** 2 / (8 * (right + left - 2 * middle))"): {
        "- -> + #2": _MORE,
        "- -> + #3": _MORE,
        "2 -> 1 #2": _MORE,
    },
    ("model/history.py", "dip = (middle <= left) & (middle < right) & (bottom < _DEEP * middle)"): {
        "* -> /": _MORE,
        "& -> | #2": _MORE,
    },
    ("model/history.py", "return np.asarray(i[i > first + 1])"): {
        "+ -> -": "a valley at the last sample below zero ends at the same crossing",
    },
    ("model/history.py", "x = np.linspace(a, b, 33)"): {"33 -> (33 * 2 + 1)": _TUNING},
    ("model/history.py", "SAMPLES = 1025"): {"*": _TUNING},
    ("model/history.py", "_DEEP = 0.5"): {"0.5 -> (0.5 * 1.1)": _TUNING},
    ("model/history.py", "_ROUNDS = 4"): {"4 -> (4 * 2 + 1)": _TUNING},
    ("model/history.py", "return [int(i) + 1 for i in np.flatnonzero(steps[1:] * steps[:-1] < 0)]"): {
        "* -> /": "they are 1 or -1",
        "0 -> 1": "as above: the products are 1 or -1",
    },
    ("model/history.py", "if (b - a) * (value - b) > 0:"): {
        "* -> /": "the same sign; b is never the value here",
    },
    ("model/history.py", "elif (value - a) * (b - a) <= 0:"): {"* -> /": "the same sign; a is never b"},
    ("model/history.py", "del stack[-2:]"): {
        "2 -> 1": "a is taken off in the next round, where it is no turning point any more",
    },
    ("model/energy.py", "TOLERANCE = 1e-11"): {"*": _TUNING},
    ("model/energy.py", "NODES = 64"): {"*": _TUNING},
    ("model/energy.py", "FEW_NODES = 24"): {"*": _TUNING},
    ("model/energy.py", "MOST_NODES = 2048"): {"*": _TUNING},
    ("model/energy.py", "h = 1e-4 * (x_end - x0)"): {
        "1e-4 -> (1e-4 * 1.1)": "the step of an estimate: a pole ahead of the end need not be known well",
        "- -> +": "as above",
    },
    ("model/energy.py", "return h * D1 / ops.larger(D0 - D1, 1e-7 * D1 + 1e-300)"): {
        "1e-7 -> (1e-7 * 1.1)": "far enough that the logarithm is straight",
        "1e-300 -> (1e-300 * 1.1)": "only keeps 0/0 away",
    },
    ("model/figures.py", "PARTS, DEPTH, MOST_PARTS = 16, 6, 32"): {"*": _TUNING},
    ("model/energy.py", "if float(np.abs(c[-4:]).max()) <= TOLERANCE * total:"): {"4 -> (4 * 2 + 1)": _TUNING},
    ("model/energy.py", "total = abs(float(c.sum()))"): {"abs -> nothing": "the work is positive"},
    ("model/energy.py", "if mu == 0 or x_stop <= x0:"): {"or -> and": "the rest gives the same zeros, later"},
    ("model/energy.py", "return Series(np.zeros(1), x0, x0 + 1.0, 1.0)"): {
        "1 -> 2": _NOTHING,
        "+ -> -": _NOTHING,
        "1.0 -> 2.0": _NOTHING,
        "1.0 -> 2.0 #2": _NOTHING,
    },
    (
        "model/neighbours.py",
        "thin = row.eta * row.ca * (cs + abs(cs)) / 2 + row.beta * (row.sa + abs(row.sa)) + 1e-9",
    ): {"1e-9 -> (1e-9 * 1.1)": _ROUNDING},
    (
        "model/neighbours.py",
        "return (r.S > 0) & (r.H + q > 0) & (abs(c.p) <= row.beta / row.k) & (c.s >= 0) & (c.s <= row.eta / row.k)",
    ): {
        " / row.k -> nothing #2": "in 480 000 designs no tip came to rest beyond the other scale's tip: s <= eta anyway",  # noqa: E501
        "/ -> * #2": "as above",
    },
    ("model/neighbours.py", "return (abs(c.p) <= row.beta / j) & (c.s >= 0) & (c.s <= row.eta / j)"): {
        " / j -> nothing #2": "in 200 000 designs no crossing lay beyond the other scale's tip: s <= eta anyway",
        "/ -> * #2": "as above",
    },
    ("model/evaluation.py", "PART, DEEPEST, MOST_PARTS = 4, 28, 400"): {"*": _TUNING},
    ("model/evaluation.py", "EVEN = 8"): {"*": _TUNING},
    ("model/figures.py", "NEAREST = 1e-13"): {"*": _TUNING},
    ("model/crossings.py", "NEAR = 7"): {"*": _TUNING},
    ("model/crossings.py", "SWING = 0.12"): {"*": _TUNING},
    ("model/follow.py", "SAFETY = 0.25"): {"*": _TUNING},
    ("model/follow.py", "COINCIDE = 1e-11"): {"*": _ROUNDING},
    ("model/crossings.py", "AWAY = 0.5"): {"*": _TUNING},
    ("arrays/derivatives.py", 'cut = margin if {"W_fr", "RED"} & set(of) else None'): {
        "& -> |": "the work is computed though nobody asks for it",
    },
    ("model/sensitivity.py", "D = -(pt.M_N + mu * pt.M_f)"): {"+ -> -": _STRETCH, "* -> /": _STRETCH},
    ("model/sensitivity.py", "D = -(pt.M_N + s.mu * pt.M_f)"): {"*": _STRETCH},
    ("fe/runs.py", "seconds = _OTHER * body.solver.work / rate + body.unknowns * 1e-5"): {"*": _GUESS},
    ("fe/runs.py", "rate = 2 * len(A) ** 3 / (time.perf_counter() - begun)"): {"*": _GUESS},
    ("fe/solver.py", "_COMPLEMENT = ((11, 0), (13, 0), (19, -1), (36, 2))"): {
        "0 -> 1": "scaling, which a definite matrix does not need",
        "0 -> 1 #2": "matching, which a definite matrix does not need",
    },
    (
        "identify/posterior.py",
        "start = np.where(start < low, np.minimum(2 * low - start, 0.5 * (low + high)), start)",
    ): {
        "* -> /": "where inside a walker starts is forgotten",
    },
    ("model/evaluation.py", "square = 1.0"): {
        "*": "there is no root of the contact condition in bending: any number above 0",
    },
    ("inverse/hinge_figures.py", "return np.where(total.real > 0, work / total, 0.0)"): {
        "0.0 -> 1.0": "a bar that is twisted as far as a lock has energy",
    },
    (
        "io/tabular.py",
        'return next((by_fold[found] for found in difflib.get_close_matches(name.casefold(), list(by_fold), n=1)), "")',
    ): {"1 -> 2": "the best is the first of more"},
    ("fe/walk.py", "self._keep(self.z, self.v, 0.0, reduced, self.contact.load(self.v, 0.0, None, self.kappa))"): {
        "0.0 -> 1.0 #2": "where the scales rest they touch nothing at that twist either",
    },
    ("arrays/solution.py", 'sa = np.sin(alpha) * (1 if sense == "+" else -1)'): {"* -> /": "divided by a sign"},
    ("arrays/solution.py", "theta, phi = np.full(v.size, theta0), limit * (1 + v) ** 2"): {
        "2 -> 1": "how the twists at rest are drawn, not what touches at them",
    },
    ("identify/posterior.py", "WALKERS, BURN, THIN, _LEAST = 32, 200, 15, 50"): {"*": _TUNING},
    ("identify/estimate.py", "p[mu] = max(min(p[mu], _NEAR_LOCK * lock), asked.low[mu])"): {
        "max -> min": "where a search starts",
    },
    ("fe/solver.py", "_COMMON = ((1, 1), (2, 2), (8, 0), (10, 8), (24, 0))"): {
        "0 -> 1 #2": "on how many threads MKL factorises",
    },
    ("fe/solver.py", "x = self._call(_SOLVE, np.asfortranarray(b.reshape(self._n, -1)))"): {"1 -> 2": _UNKNOWN},
    ("beam/validity.py", "if tau <= THIN * gap * (1 + 1e-9):"): {"1e-9 -> (1e-9 * 1.1)": _ROUNDING},
    (
        "curves/hinge.py",
        "pole = float(energy.pole(t.row, t.x_end, np.array([mu]), law, t.x0)[0]) if x_end > x0 else x0 + 1",
    ): {
        "1 -> 2": _NOTHING,
    },
    ("fe/sizes.py", '"coarse": (0.2, 0.06),'): {"*": _TUNING},
    ("fe/sizes.py", '"medium": (0.15, 0.013),'): {"*": _TUNING},
    ("fe/sizes.py", '"fine": (0.12, 0.0075),'): {"*": _TUNING},
    ("fe/walk.py", "_FIRST, _HALVINGS = 1e-3, 7"): {"*": _TUNING},
    ("fe/walk.py", "_STARTS, _STEPS = (1.0, 0.5, 0.25, 0.0), tuple(0.5**i for i in range(8))"): {"*": _TUNING},
    ("fe/contact.py", "friction = -self._friction.force(*args).reshape(-1, 3)"): {"1 -> 2": _UNKNOWN},
    (
        "fe/elements.py",
        "x, g, t, f = np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3)), np.empty((10, 3))",
    ): {"10 -> (10 * 2 + 1)": "room that is not used"},
    ("fe/solver.py", "_MATCHED = ((11, 1), (13, 1))"): {"1 -> 2 #2": "how pivots are matched"},
    ("model/sensitivity.py", "load_end = np.where(at_start, e, pt.load + t.load_x * (x_e - x_end))"): {
        "- -> +": "of what a complex step moves only the imaginary part is read",
    },
    ("fe/contact.py", "DHAT = 1e-4"): {"*": _TUNING},
    ("identify/estimate.py", "p[theta0] = asked.low[theta0] + share * (asked.high[theta0] - asked.low[theta0])"): {
        "+ -> -": "where a search starts",
    },
    ("inverse/hinge_figures.py", "x = t.x0 + (t.x_end - t.x0) * np.linspace(0.0, 1.0, GRID)[:, None]"): {
        "1.0 -> 2.0": "a wider grid brackets the same places",
    },
    (
        "inverse/named_figures.py",
        "return c.changed({name: np.where(good, v, fill.get(name, 1.0)) for name, v in c.arrays.items()}, c.sizes)",
    ): {"1.0 -> 2.0": "any number does: the row is ruled out"},
    ("model/bracket.py", "straight = abs(f * moved + step * (f - value_before)) <= 1e-3 * abs(f * moved)"): {
        "*": _SHARP
    },
    ("model/bending.py", "b = A1 - c / 2"): {"- -> +": _BEGINS},
    ("model/tracks.py", "small, x = not np.any(np.abs(new - x) > 1e-8 * np.abs(x)), new"): {"*": _SHARP},
    ("curves/hinge_cycles.py", "[(piece, _evaluate(senses, piece, 1)) for piece in _pieces(senses, *ends)]"): {
        "1 -> 2": _ENDS,
    },
    ("inverse/goals.py", "return self.asked + 0 * d if self.twist is None else self.twist.per_pitch(d, scales)"): {
        "* -> /": _ZERO,
    },
    ("model/plates.py", "z = np.stack([ca * ct, sa + 0 * ct, -ca * st])"): {
        "+ -> -": _ZERO,
        "* -> / #2": _ZERO,
        "ct -> st #2": _ZERO,
    },
    (
        "model/plates.py",
        "o = lam * np.stack([S * (-sa * ct) + C1 * st, S * ca + 0 * C1 * st, S * (sa * st) + C1 * ct]) + k * z[:, None]",  # noqa: E501
    ): {"+ -> - #2": _ZERO, "* -> / #6": _ZERO, "* -> / #7": _ZERO, "st -> ct #2": _ZERO},
    ("model/plates.py", "tol = 1e-9 * (eta + beta)"): {"*": _ROUNDING},
    ("model/plates.py", "_ROUNDS = 4"): {"*": _TUNING},
    ("model/plates.py", "_PARALLEL = 1e-10"): {"1e-10 -> (1e-10 * 1.1)": _TUNING},
    ("model/plates.py", "square = da * da + d[2] * d[2] + 1e-300"): {
        "1e-300 -> (1e-300 * 1.1)": "keeps 0/0 away: any number too small to be seen does",
    },
    ("model/plates.py", "within = abs(v) <= beta + tol if e < 2 else (v >= -tol) & (v <= eta + tol)"): {
        "- -> nothing": _ROUNDING,
    },
    (
        "model/plates.py",
        "mirrored: bool = False,",
    ): {"False -> True": "the package always gives it"},
    ("model/plates.py", "x = np.linspace(a, b, 33)"): {"*": _TUNING},
    ("model/plates.py", "k = np.arange(1, plates.reach + 1)"): {"1 -> 2 #2": _OUT_OF_REACH},
    ("model/plates.py", "j = int(np.argmax((gap[:-1] > 0) != (gap[1:] > 0)))"): {
        "- -> nothing": "the first sign that differs from the one before is the first that differs from the first",
    },
    (
        "model/plates.py",
        'return [(int(i), int(n), int(j)) for i, n, j in found[np.argsort(found[:, 2], kind="stable")]]',
    ): {"2 -> 1": "the order in which candidates are solved; the earliest wins in any order"},
    (
        "curves/hinge_cycles.py",
        "analysis = Analysis(beam, Way.of(load, [end]), np.asarray(mu), LOADS[load].law(law), margin, 3, None, ideal)",
    ): {"3 -> (3 * 2 + 1)": "points of a curve that is not asked for: only the path is solved"},
    ("fe/contact.py", "none = np.empty(0, np.int64)"): {
        "0 -> 1": "of a face no points are read: places are those of two edges"
    },
    ("batch/answers.py", "thin = np.zeros_like(columns[0]) if thickness is None else thickness"): {"0 -> 1": _ZERO},
    ("fe/stiffness.py", "_SCHEME = 3"): {"*": "names what is kept: any number does that was not in use before"},
    ("fe/contact.py", "reach = min(4 * reach, within, _FAR)"): {"4 -> (4 * 2 + 1)": _TUNING},
    ("curves/compliant_walk.py", "_NEAR, _SAME = 1e-5, 1e-6"): {"*": _ROUNDING},
    ("curves/compliant_cycles.py", "return (v - start) * way > least and (stop - v) * way > least"): {
        "* -> /": "the way is 1 or -1",
        "* -> / #2": "the way is 1 or -1",
    },
    ("model/section.py", "for n in range(1, 13, 2):"): {"13 -> (13 * 2 + 1)": _ROUNDING},
    ("model/joint.py", "slack = 1e-9"): {"*": _ROUNDING},
    ("dynamics/decay.py", "for _ in range(100):"): {"*": _TUNING},
    ("dynamics/decay.py", "still = np.abs(new - s) <= near"): {"- -> +": _SHARP},
    ("dynamics/decay.py", "rest = np.where((s > down.last * (1 + 1e-12)) | (down.slope(s) <= 0), top, np.nan)"): {
        "1e-12 -> (1e-12 * 1.1)": _ROUNDING,
    },
    (
        "dynamics/hinge_branches.py",
        "last, *rows = self.c.reshape(len(self.c), -1).take(i * self.n + self.own, axis=1)[::-1]",
    ): {"1 -> 2": _UNKNOWN},
    ("dynamics/doors.py", "height = float(np.max(side.height())) * unit"): {"max -> min": "it is one number"},
    ("dynamics/motion.py", "times = np.linspace(state.t, t, dense + 1) if dense else np.array([state.t, t])"): {
        "1 -> 2": _TUNING,
    },
    ("dynamics/systems.py", "ROUGH = 1e-7"): {"*": _TUNING},
    ("dynamics/systems.py", "FARTHER = 1.001"): {"*": _TUNING},
    ("dynamics/joint_branches.py", "STEPS, OF_ROW = 256, 96"): {"*": _TUNING},
    ("dynamics/joint_branches.py", "TOPS = 0.02"): {"*": _TUNING},
    ("dynamics/joint_branches.py", "NEAR = 0.3"): {"*": _TUNING},
    ("dynamics/joint_branches.py", "SMALL = 1e-4"): {"*": _TUNING},
    ("dynamics/joint_branches.py", "FIRST, LEAST = 4e-6, 1e-6"): {"*": _TUNING},
    ("dynamics/motion.py", "sign = 1 if state.y > 0 else -1"): {"1 -> 2 #4": "only its sign is looked at"},
    ("dynamics/motion.py", "SETTLED, POLISHED = 1e-3, 10.0"): {"*": _TUNING},
    ("dynamics/motion.py", "return 0, None"): {"0 -> 1 #2": "without a branch nobody asks for the way"},
    ("dynamics/motion.py", "frequency: float = 1.0"): {"1.0 -> 2.0": "without a force nothing reads it"},
    ("identify/decay_fit.py", "@dataclass(frozen=True, repr=False, eq=False)"): {
        "False -> True": "the class has a __repr__ of its own, which is kept",
    },
    ("identify/records.py", "held = np.flatnonzero(np.abs(y[: turns[0]] - y[0]) > reach / 2)"): {
        "0 -> 1 #2": "any point at which it is held",
    },
    ("identify/records.py", "last = max(int(held[0]) - 1, 0) if held.size else 0"): {"- -> +": _BEGINS},
    ("identify/decay_fit.py", "if len(turned) > 1:"): {"1 -> 2": "in two periods it turns four times"},
    ("identify/decay_fit.py", '_STEP = {"hinge": 1e-5, "compliant": 3e-3}'): {"*": _TUNING},
    ("identify/decay_fit.py", '_STILL, _BEGIN = {"hinge": 1e-8, "compliant": 1e-6}, 1e-3'): {"*": _TUNING},
    ("identify/decay_fit.py", "_STARTS = (0.4, 2.5)"): {"*": _TUNING},
    (
        "identify/decay_fit.py",
        'own |= {"twist_zero": own["release"] * trials.beam.pitches, '
        '"start": (t[record.turns[0]] - record.start) / math.pi}',
    ): {
        "0 -> 1": "sizes that parameters are measured over",
    },
    ("contacts/changes.py", "return bool(w.W.told[c, N_].real < -conditions.MISSED_PULL / 2)"): {"/ -> *": _ROUNDING},
    ("contacts/changes.py", "for count in range(_CHANGES + 3 * (len(w.S.shapes) - 1)):"): {"1 -> 2": _TUNING},
    ("contacts/changes.py", "before, felt, again, since = there, feels, 2 * again, 0"): {
        "0 -> 1": "which state of a circle is taken: none of them holds",
    },
    ("contacts/conditions.py", "return MEET, -1, worst"): {"1 -> 2": _NONE},
    (
        "contacts/conditions.py",
        "far = abs(v[touch.AT] - best[touch.AT]) + abs(v[touch.AT + 1] - best[touch.AT + 1])",
    ): {"1 -> 2 #2": "an edge is tangent at several places only along the length, which the first place tells apart"},
    ("contacts/follow.py", "_START, _SOFTLY, _GENTLE, _FREELY = 1 / 16, 1 / 8, 1 / 64, 4.0"): {
        "16 -> (16 * 2 + 1)": _TUNING
    },
    ("contacts/follow.py", "if not change(w, what, -1, events):"): {
        "- -> nothing": "what comes in is no contact yet: its number is not read",
    },
    ("contacts/follow.py", "code = jump(w, goal, step, -1, events)"): {"1 -> 2": _NONE, "1 -> 2 #2": _NONE},
    ("contacts/follow.py", "while code == increments.RANGE and t[tally.WAY] < ways[i] - 1e-13:"): {
        "1e-13 -> (1e-13 * 1.1)": _ROUNDING,
    },
    ("contacts/geometry.py", "one = (1.0 + 0.0 * q[i, 0], 0.0 * q[i, 0], 0.0 * q[i, 0])"): {
        f"0 -> 1{n}": "zero times any motion" for n in ("", " #2", " #3")
    },
    (
        "contacts/geometry.py",
        "x, y, z = rotated(e, one), rotated(e, (one[1], one[0], one[1])), rotated(e, (one[1], one[1], one[0]))",
    ): {f"1 -> 2{n}": "both are zero" for n in ("", " #2", " #3", " #4")},
    ("contacts/locating.py", "if last == 2 and vl > 0.0:"): {"0.0 -> 1.0": "how fast a place is found"},
    ("contacts/works.py", "t[tally.COUNT] += 1"): {"1 -> 2": "it is only asked whether it is 0"},
    ("contacts/path.py", "ROOM, EVENTS = 8, 64"): {"64 -> (64 * 2 + 1)": _ROOM},
    ("contacts/events.py", "AT_ONCE = 1e-7"): {"*": _ROUNDING},
    ("contacts/row.py", "_EVENTS, _BEGIN = 16, 2e-4"): {"2e-4 -> (2e-4 * 1.1)": _TUNING},
    ("contacts/changes.py", "w.J.kept[0] = 0"): {
        f"0 -> 1 #{n}": "a Jacobian of one unknown: it is factored anew as that of none" for n in (2, 4, 6, 8)
    },
    ("contacts/changes.py", "ends += 1"): {
        "+= -> -=": "how often the end of an edge is tried: contacts that come and go in a circle end it as well",
    },
    ("contacts/changes.py", "return False"): {"False -> True": "the same is tried again, and fails again"},
    ("contacts/detection.py", "if not -0.05 < t < 1.05:"): {
        "1.05 -> (1.05 * 1.1)": _BEYOND,
        "0.05 -> (0.05 * 1.1)": _BEYOND,
    },
    ("contacts/detection.py", "return -1, -1"): {"1 -> 2": _NONE, "1 -> 2 #2": _NONE},
    ("contacts/detection.py", "return feature, -1"): {"1 -> 2": _NONE},
    (
        "contacts/detection.py",
        "here = abs(X1 - x1) < near * S.shapes[i, ETA] and abs(Y1 - y1) < 2 * near * S.shapes[i, BETA]",
    ): {
        "* -> /": _TUNING,
        "* -> / #2": "places that are near on the other plate are near on this one, too",
    },
    (
        "contacts/entry.py",
        "np.zeros((C, 7), np.int64), np.zeros((C, 7), np.int64), np.zeros((64 * N, touch.VERTEX)), np.zeros(4, kind),",
    ): {"4 -> (4 * 2 + 1)": _ROOM},
    (
        "contacts/entry.py",
        "w = walk(system(b, -1 if each else 0 if one else i, scales, about, ties), C, notes[i])",
    ): {"1 -> 2": _NONE},
    ("contacts/equations.py", "share = most / reach if reach.real > 0.0 else 0.0 * most"): {
        "0.0 -> 1.0 #2": "what it is a share of is 0",
    },
    ("contacts/follow.py", "t[tally.ZERO] = t[tally.ZERO] + 1 if where < 10 * LOCATED else 0.0"): {
        "* -> /": "how many events in a row are taken before an equilibrium is looked for",
    },
    ("contacts/events.py", 'name = "" if row[7] < 0 else _of(row[8], row[9], row[10], row[7])'): {
        "0 -> 1": "a neighbour is one cell further at least",
    },
    ("contacts/of_face.py", "out[i, n, 13], out[i, n, increments.AFTER :] = (after >= 0).sum(), after"): {
        "0 -> 1": "no contact's number is 0",
    },
    ("contacts/of_face.py", "n, before, all_before = 0, {-1.0}, {-1.0}"): {
        "1.0 -> 2.0 #2": "the first event brings a contact",
    },
    ("contacts/increments.py", "n[i] += x * d + y * (d / t[tally.SIZE] - (b[i] - c[i]) / t[tally.BEFORE])"): {
        "+ -> -": _BEGINS
    },
    ("contacts/increments.py", "row[6 + a] = w.con[c, a] if c >= 0 else -1"): {"1 -> 2": _NONE},
    ("contacts/increments.py", "whole = 0.0 * st.strains[0, e]"): {"0 -> 1": _ZERO},
    ("contacts/increments.py", "row[14 + a] = w.now.s[c, a] if c >= 0 else 0.0"): {
        "0.0 -> 1.0": "nobody reads places of no contact",
    },
    (
        "contacts/jacobian.py",
        "return (scaled(-1.0, a1), scaled(-1.0, b1), scaled(-1.0, c1), scaled(-1.0, d1)), 0.0, 1.0, f",
    ): {"0.0 -> 1.0": _SLIDES, "1.0 -> 2.0 #5": _SLIDES},
    ("contacts/lifts.py", "return (-1, -1, -1, -1) if S.own else strain_columns(S, at, n, 0)"): {
        "0 -> 1": "those of any scale: cells share them",
    },
    ("contacts/linear.py", "return False"): {
        "False -> True #2": "divided by the zero, corrections are no numbers, which ends Newton's method as well",
    },
    ("contacts/meeting.py", "one, none = 1.0 + 0.0 * x1, 0.0 * x1"): {
        f"* -> /{n}": "a zero, of the kind of a place that is 0 at a scale's base alone, where it lies on nothing"
        for n in ("", " #2", " #3", " #4")
    },
    ("contacts/path.py", "loose = np.tile(np.array(free, float) * (motions == 9), (n, 1))"): {
        "1 -> 2": "columns beyond the fourth are not read",
    },
    (
        "contacts/path.py",
        "ways, there = (np.full((1, 1), most), most) if self.other else (np.empty((1, 0)), 1.0)",
    ): {"1 -> 2 #2": "another station at the same place"},
    ("contacts/row.py", "line = increments.LINE + held.course.shape[0] + 6 * held.floating"): {
        "6 -> (6 * 2 + 1)": _ROOM
    },
    ("contacts/works.py", "smooth = fresh >= 2 and stick == t[tally.STICK].real"): {
        "and -> or": "how friction is summed over increments behind an event, which are short: below 1e-4 of the work",
    },
    ("contacts/supports.py", "o, v = (unit(c, 0.0), none) if c < 3 else (none, unit(c - 3, 0.0))"): {
        f"0.0 -> 1.0{n}": _ZERO for n in ("", " #2", " #3", " #4")
    },
    (
        "contacts/written.py",
        "row[18], row[19] = t[tally.SINCE], energy(w, w.now) + t[tally.GRIPS]",
    ): {"+ -> -": "what grips take up is a part in 1e6 of the energy, their compliance over the joint's"},
}
"""Changes that are no error: (file, line) -> {change, or "*" for all of the line: reason}."""
