"""A joint's stiffness in a file: round trips, what comes from it, and every mistake in one line."""

import builtins
import json

import numpy as np
import pytest
import xarray as xr

import squama
from squama import InputError
from squama.beam import matrixfile
from squama.beam.matrixfile import freed
from squama.cli import main
from squama.inverse.front import beams
from squama.plot import response_figure
from squama.study.sweeping import compute, make_plan

BEAM = squama.Beam.from_ratios(eta=3, beta=0.6, lam=0.32, zeta=0.18, slenderness=45, mu=0.2)
D, E = BEAM.pitch, BEAM.substrate.youngs_modulus
A = np.array(
    [
        [1.1, 0.04, -0.05, -0.01, -0.02, 0.04, -0.02],
        [0.04, 0.8, 0.01, 0.04, 0.0, -0.09, 0.01],
        [-0.05, 0.01, 1.1, -0.01, 0.1, -0.01, 0.08],
        [-0.01, 0.04, -0.01, 0.17, 0.0, 0.0, 0.0],
        [-0.02, 0.0, 0.1, 0.0, 0.021, 0.0, 0.006],
        [0.04, -0.09, -0.01, 0.0, 0.0, 0.15, -0.007],
        [-0.02, 0.01, 0.08, 0.0, 0.006, -0.007, 0.05],
    ]
)
"""A stiffness like that of Fig. 6b, in units of the pitch and the modulus."""
STORED = matrixfile.stored(BEAM, A)
TEXT = STORED.text
# the same by hand: moment for w_Y with the rest free, by solving for the motions under a unit moment
K_THETA = 1 / np.linalg.solve(A[:6, :6], np.eye(6)[4])[4]
FREE = np.append(-np.linalg.solve(A[:6, :6], A[:6, 6]), 1.0)
RIGIDITY = FREE @ A @ FREE


@pytest.fixture
def place(tmp_path, monkeypatch):
    """A beam file with a matrix beside it, and another current folder."""
    (tmp_path / "in").mkdir()
    monkeypatch.chdir(tmp_path)
    matrixfile.write(STORED, "in/joint.csv")
    text = BEAM.to_toml().replace("[friction]", '[joint]\nmatrix = "joint.csv"\n\n[friction]')
    (tmp_path / "in" / "beam.toml").write_text(text)
    return tmp_path


def test_a_file_comes_back_to_the_last_bit(tmp_path):
    back = matrixfile.read(matrixfile.write(STORED, tmp_path / "joint.csv"))
    assert back == STORED
    assert back.text == TEXT
    assert hash(back) == hash(STORED)
    np.testing.assert_allclose(back.K, A, rtol=1e-13)
    # force of u_X on F_X is in N/m
    assert back.rows[0][0] == pytest.approx(1.1 * E * D)
    assert back.rows[0][4] == pytest.approx(-0.02 * E * D**2)
    assert back.rows[6][6] == pytest.approx(0.05 * E * D**3)
    assert back.made == {
        "beam.pitch": D, "substrate.youngs_modulus": E, "scale.embedded": BEAM.scale.embedded,
        "scale.width": BEAM.scale.width, "scale.thickness": BEAM.scale.thickness, "scale.alpha": BEAM.scale.alpha,
        "scale.theta0": BEAM.scale.theta0, "substrate.width": BEAM.substrate.width,
        "substrate.thickness": BEAM.substrate.thickness, "substrate.poisson_ratio": 0.25,
    }  # fmt: skip


def test_a_file_of_nine_has_bend_and_elongation(tmp_path):
    K = np.block([[A, 0.01 * A[:, :2]], [0.01 * A[:2], np.array([[0.06, 0.02], [0.02, 1.3]])]])
    nine = matrixfile.stored(BEAM, K)
    back = matrixfile.read(matrixfile.write(nine, tmp_path / "joint.csv"))
    assert (back, back.text) == (nine, nine.text)
    np.testing.assert_allclose(back.K, K, rtol=1e-13)
    # moment by bend, tension by elongation, moment by elongation
    assert back.rows[7][7] == pytest.approx(0.06 * E * D**3)
    assert back.rows[8][8] == pytest.approx(1.3 * E * D)
    assert back.rows[7][8] == pytest.approx(0.02 * E * D**2)
    head = next(line for line in back.text.splitlines() if line.startswith("force"))
    assert head.endswith("phi (rad),psi (rad),elongation (m)")
    # what a beam that is neither bent nor stretched takes from it is the same
    assert back.K_theta == pytest.approx(STORED.K_theta)
    assert back.rigidity(()) == pytest.approx(STORED.rigidity(()))


def test_units_of_the_file_are_read(tmp_path):
    rows = np.array(STORED.rows)
    rows[:, :3] *= 1e-3  # per mm
    rows[3:] *= 1e3  # N mm
    rows[:3] *= 1e-3  # kN
    lines = [line for line in TEXT.splitlines() if line.startswith("#")]
    lines.append("force;u_X (mm);u_Y (mm);u_Z (mm);w_X (rad);w_Y (rad);w_Z (rad);phi (rad)")
    names = ["F_X (kN)", "F_Y (kN)", "F_Z (kN)", "M_X (N mm)", "M_Y (N mm)", "M_Z (N mm)", "T (N mm)"]
    lines += [f"{name};{';'.join(map(repr, row))}" for name, row in zip(names, rows.tolist(), strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(lines))
    np.testing.assert_allclose(matrixfile.read(tmp_path / "a.csv").K, A, rtol=1e-12)


def test_a_beam_takes_K_theta_and_C_f_from_it(place):
    beam = squama.Beam.from_toml("in/beam.toml")
    assert beam.joint_stiffness == pytest.approx(K_THETA * E * D**3)
    assert beam.torsional_rigidity == pytest.approx(RIGIDITY * E * D**4)
    # the rigidity in bending is as it was
    assert beam.bending_rigidity == BEAM.bending_rigidity
    given = beam.replace(joint={"stiffness": "5 kN m", "inclusion_factor": 1.3})
    assert (given.joint_stiffness, given.C_f) == (5000, 1.3)
    assert beam.warnings() == []
    r = squama.twist(beam, at=[1.0], joint="hinge")
    assert r["T"].item() == pytest.approx(RIGIDITY * E * D**4)


def test_a_softer_and_larger_beam_of_the_same_shape_scales_it(place):
    beam = squama.Beam.from_toml("in/beam.toml")
    scaled = {key: getattr(beam.scale, key) * 2 for key in ("length", "embedded", "width", "thickness")}
    bar = {"width": 0.064, "thickness": 0.032, "youngs_modulus": 1e6}
    larger = beam.replace(pitch=2 * D, scale=scaled, substrate=bar)
    assert larger.warnings() == []
    assert larger.joint_stiffness == pytest.approx(K_THETA * 1e6 * (2 * D) ** 3)
    assert larger.torsional_rigidity == pytest.approx(RIGIDITY * 1e6 * (2 * D) ** 4)


def test_a_beam_carries_the_matrix_wherever_it_goes(place):
    beam = squama.Beam.from_toml("in/beam.toml")
    text = beam.to_toml("copy.toml")
    (place / "in" / "joint.csv").unlink()
    for again in (squama.Beam.from_toml("copy.toml"), squama.Beam.from_toml_text(text), beam.replace(scales=3)):
        assert again.joint == beam.joint
        assert again.joint.matrix.K[4, 4] == beam.joint.matrix.K[4, 4]
    assert squama.Joint(matrix=STORED) == squama.Joint(matrix=TEXT)
    assert beam.replace(joint={"matrix": None}) == BEAM
    assert beam != BEAM


def test_python_looks_in_the_current_folder(place, monkeypatch):
    monkeypatch.chdir(place / "in")
    assert squama.Joint(matrix="joint.csv").matrix == STORED
    assert BEAM.replace(joint={"matrix": place / "in" / "joint.csv"}).joint.matrix == STORED


@pytest.mark.parametrize("door", ["text", "plot", "front", "column", "store"])
def test_a_beam_kept_in_a_result_opens_no_file(door, place):
    """The matrix is there and sound: who sent the result must not learn that."""
    named = BEAM.to_toml() + f"[joint]\nmatrix = '{place / 'in' / 'joint.csv'}'\n"
    front = xr.Dataset({"joint.matrix": ("design", [str(place / "in" / "joint.csv")])}, attrs={"start": BEAM.to_toml()})
    curve = squama.twist(BEAM, points=4, joint="hinge").assign_attrs(beam=named)
    plan = make_plan(BEAM, {"mu": [0.1, 0.2]}, joint="hinge")._replace(beam_toml=named)
    doors = {
        "text": lambda: squama.Beam.from_toml_text(named),
        "plot": lambda: response_figure(curve),
        "front": lambda: beams(front.drop_vars("joint.matrix").assign_attrs(start=named)),
        "column": lambda: beams(front),
        "store": lambda: compute(plan, next(plan.tiles())),
    }
    with pytest.raises(InputError, match=r"joint\.matrix = .*: names a file, which only a beam's own file can"):
        doors[door]()


def test_another_shape_is_named_in_one_line(place):
    beam = squama.Beam.from_toml("in/beam.toml")
    (line,) = beam.replace(scale={"embedded": "5 mm", "alpha": "50 deg"}, substrate={"poisson_ratio": 0.3}).warnings()
    assert "joint.csv): was made for another shape, scale.embedded = 4.5 mm (0.18 d), not 5 mm (0.2 d); " in line
    assert "scale.alpha = 45 deg, not 50 deg; substrate.poisson_ratio = 0.25, not 0.3; make it anew with" in line
    # the exposed part plays no role
    assert beam.replace(scale={"length": "70 mm"}).warnings() == []
    (line,) = beam.replace(pitch="26 mm").warnings()
    assert "scale.embedded = 4.5 mm (0.18 d), not 4.5 mm (0.1731 d)" in line


def test_a_matrix_of_ones_own_says_what_it_scales_with(tmp_path):
    keep = ("# beam.pitch", "# substrate.youngs_modulus", "force", "F_", "M_", "T ")
    lines = [line for line in TEXT.splitlines() if line.startswith(keep)]
    (tmp_path / "own.csv").write_text("\n".join(lines))
    beam = BEAM.replace(joint={"matrix": tmp_path / "own.csv"}, scale={"embedded": "5 mm"})
    assert beam.warnings() == []
    assert beam.joint_stiffness == pytest.approx(K_THETA * E * D**3)


def changed(row, column, value):
    rows = [line.split(",") for line in TEXT.splitlines()]
    rows[-7 + row][1 + column] = value
    return "\n".join(",".join(cells) for cells in rows)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("\n".join(TEXT.splitlines()[:-1]), "has 6 rows and 7 columns of numbers; a joint's matrix has 9 and 9 (or"),
        (TEXT.replace(",phi (rad)", ""), "has 7 rows and 6 columns of numbers"),
        (changed(0, 4, "3.1"), "is not symmetric: F_X by w_Y is 3.1, M_Y by u_X is -312500; both must be the same"),
        (changed(4, 4, "1"), "is not positive definite, so some motion would need no force or give energy away"),
        (changed(4, 4, "-1"), "is not positive definite: M_Y by w_Y is -1, must be above 0"),
        (changed(2, 2, "stiff"), 'line 15: u_Z = "stiff": is not a number; write e.g. 1234.5'),
        (changed(2, 2, "nan"), "u_Z = nan: is not a finite number"),
        (changed(2, 2, ""), 'u_Z = "": is empty'),
        (TEXT.replace("u_X (m)", "u_X (deg)"), 'line 12: "u_X (deg)": has no unit that fits; write e.g. u_X (m)'),
        (TEXT.replace("M_Y (N m)", "M_Y (N)"), '"M_Y (N)": has no unit that fits; write e.g. M_Y (N m)'),
        (TEXT.replace("F_X (N)", "F_X (kg)"), '"F_X (kg)": has no unit that fits; write e.g. F_X (N)'),
        (TEXT.replace("w_X (rad)", "w_X"), '"w_X": must be w_X with its unit, as w_X (rad); the order is u_X, u_Y'),
        (TEXT.replace("u_X (m),u_Y (m)", "u_Y (m),u_X (m)"), '"u_Y (m)": must be u_X with its unit'),
        (TEXT.replace("# beam.pitch", "# pitch"), "does not say what it was made for; write a line above the header"),
        (TEXT.replace('"25 GPa"', '"25 mm"'), '# substrate.youngs_modulus = "25 mm": is a length, but a pressure is'),
        (TEXT.replace('"25 GPa"', "25"), '# substrate.youngs_modulus = "25": has no unit'),
        ("1,2,3", "has 0 rows and 2 columns of numbers"),
    ],
)  # fmt: skip
def test_what_is_no_such_matrix_is_refused_in_one_line(text, words, place):
    (place / "in" / "joint.csv").write_text(text)
    with pytest.raises(InputError) as caught:
        squama.Beam.from_toml("in/beam.toml")
    (line,) = str(caught.value).splitlines()
    assert line.startswith("in/beam.toml: joint.matrix: in/joint.csv: ")
    assert words in line


@pytest.mark.parametrize(
    ("value", "words"),
    [
        ('"none.csv"', "matrix: in/none.csv: no such file; write it with: squama joint beam.toml --matrix joint.csv"),
        ("3", 'joint.matrix = 3: is not the name of a file; write e.g. "joint.csv"'),
        ('""', "joint.matrix = \"\": is not the name of a file"),
        ('"."', "is a folder"),
    ],
)  # fmt: skip
def test_a_name_that_is_none(value, words, place, capsys):
    file = place / "in" / "beam.toml"
    file.write_text(file.read_text().replace('"joint.csv"', value))
    assert main(["twist", "in/beam.toml"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert words in line


@pytest.mark.slow
def test_the_command_says_where_the_stiffness_comes_from(place, capsys):
    outputs = ["--csv", "curve.csv", "--plot", "curve.png"]
    assert main(["twist", "in/beam.toml", "--joint", "hinge", "--full", *outputs]) == 0
    assert "per rad, from in/joint.csv" in capsys.readouterr().out
    assert main(["twist", "in/beam.toml", "--full", *outputs]) == 0
    assert "joint of a scale: six motions, from the beam's matrix" in capsys.readouterr().out
    # a stored curve knows its beam without the file
    (place / "in" / "joint.csv").unlink()
    assert squama.Beam.from_toml_text(squama.read("curve.csv").attrs["beam"]).joint.matrix == STORED
    assert main(["twist", "curve.toml"]) == 2


def test_a_compliant_joint_needs_no_elements(place, capsys, monkeypatch):
    known = builtins.__import__

    def without(name, *rest, **more):
        if name.split(".")[0] in {"ipctk", "netgen", "pypardiso"} or name == "squama.fe.stiffness":
            raise ImportError(name)
        return known(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    asked = ["twist", "in/beam.toml", "--to", "0.1 rad/pitch", "--points", "21"]
    assert main([*asked, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["beam"]["joint"]["matrix"] == STORED.tolist()
    # before contact the torque is the matrix' own
    assert found["curve"]["T"][5] == pytest.approx(RIGIDITY * E * D**3 * found["curve"]["phi"][5], rel=1e-6)
    assert main([*asked, "--full"]) == 0
    said = capsys.readouterr().out
    assert "six motions, from the beam's matrix" in said
    assert "by finite elements" not in said
    beam = squama.Beam.from_toml("in/beam.toml")
    assert squama.twist(beam, points=3).attrs["K_theta"] == pytest.approx(K_THETA * E * D**3)
    # what was measured goes before
    r = squama.twist(beam.replace(joint={"stiffness": "5 kN m"}), points=3, to="0.02 rad/pitch")
    assert r.attrs["K_theta"] == pytest.approx(5e3)


def test_a_freed_stiffness_is_that_of_the_least_energy():
    K = np.array([[4.0, 1.0, 0.5], [1.0, 3.0, -0.2], [0.5, -0.2, 2.0]])
    for i, found in enumerate(freed(K)):
        others = [j for j in range(3) if j != i]
        # the others take the place in which nothing works on them
        x = np.zeros(3)
        x[i] = 1.0
        x[others] = -np.linalg.solve(K[np.ix_(others, others)], K[others, i])
        assert found == pytest.approx(x @ K @ x, rel=1e-12)
