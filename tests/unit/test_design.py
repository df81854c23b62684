"""The beam as data: frozen, exact round trips, derived values, and its warnings."""

import copy
import math
import pickle
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from squama.beam.beamfile import TABLES
from squama.beam.design import Beam, Friction, Joint, Scale, Substrate
from squama.errors import InputError

PRINTED = Beam(
    scale=Scale(length="60 mm", embedded="7 mm", width="30 mm", thickness="1 mm", alpha="45 deg", theta0="10 deg"),
    substrate=Substrate(width="32 mm", thickness="16 mm", youngs_modulus="1.5 MPa", poisson_ratio=0.49),
    pitch="20 mm",
)
FIG_6B = Beam.from_ratios(beta=0.6, lam=0.32, zeta=0.18, slenderness=45)


def test_the_ratios_come_back():
    given_ratios = {"eta": 4.2, "beta": 0.7, "lam": 0.3, "zeta": 0.2, "slenderness": 40}
    beam = Beam.from_ratios(**given_ratios, alpha="30 deg", theta0=0.1, thickness="12 mm", scales=9)
    for name, value in given_ratios.items():
        assert getattr(beam, name) == pytest.approx(value, rel=1e-13)
    assert beam.pitch == pytest.approx(0.02)  # 2t = 12 mm, lambda = .3
    assert beam.length == pytest.approx(0.18)
    assert beam.scale.alpha == math.radians(30)
    assert beam.scale.theta0 == 0.1
    assert set(beam.ratios) == {"eta", "beta", "lam", "alpha", "theta0"}


def test_derived_values_of_fig_6b():
    # theory section 5: t = 8, d = 25, b = 15, L = 4.5, t_s = .1 mm
    scale = FIG_6B.scale
    sizes = (FIG_6B.pitch, scale.width / 2, scale.embedded, scale.thickness)
    assert sizes == pytest.approx((0.025, 0.015, 0.0045, 1e-4))
    assert pytest.approx(10e9) == FIG_6B.G_B
    # tolerance: the figures have five digits
    assert pytest.approx(29974e-12, abs=5e-13) == FIG_6B.J
    assert pytest.approx(54613e-12, abs=5e-13) == FIG_6B.I
    assert pytest.approx(29974 / 54613, rel=1e-4) == FIG_6B.C_w
    assert pytest.approx(1.448875) == FIG_6B.C_f
    assert FIG_6B.joint_stiffness == pytest.approx(0.01269 * 25e9 * 0.025**3, rel=5e-4)
    assert FIG_6B.torsional_rigidity == pytest.approx(1.448875 * FIG_6B.J * 10e9)
    assert FIG_6B.bending_rigidity == pytest.approx(25e9 * 0.032 * 0.016**3 / 12)


def test_given_joint_values_replace_the_laws_in_both_loads():
    beam = FIG_6B.replace(joint={"stiffness": "2 N mm/deg", "inclusion_factor": 1.3})
    assert beam.joint_stiffness == pytest.approx(2e-3 * 180 / math.pi)
    assert beam.C_f == 1.3
    same = Beam.from_ratios(
        beta=0.6, lam=0.32, zeta=0.18, slenderness=45, stiffness="2 N mm/deg", inclusion_factor=1.3, mu=0.3
    )
    assert same == beam.replace(friction={"mu": 0.3})
    assert beam.bending_rigidity == pytest.approx(1.3 * FIG_6B.bending_rigidity)


def test_plain_dicts_numbers_and_text_make_equal_beams():
    scale = {"length": 0.06, "embedded": 0.007, "width": 0.03, "thickness": 1e-3}
    angles = {"alpha": math.radians(45), "theta0": math.radians(10)}
    substrate = {"width": 0.032, "thickness": 0.016, "youngs_modulus": 1.5e6, "poisson_ratio": "0.49"}
    same = Beam(scale={**scale, **angles}, substrate=substrate, pitch=0.02)
    assert same == PRINTED
    assert hash(same) == hash(PRINTED)
    assert same.joint == Joint()
    assert same.friction == Friction()


def test_a_beam_is_frozen_and_can_be_copied():
    with pytest.raises(AttributeError, match="Beam is frozen; make a changed copy"):
        PRINTED.pitch = 0.03
    with pytest.raises(AttributeError, match="Scale is frozen"):
        PRINTED.scale.alpha = 0.1
    assert pickle.loads(pickle.dumps(PRINTED)) == copy.deepcopy(PRINTED) == PRINTED
    changed = PRINTED.replace(scale={"alpha": "30 deg"}, friction={"mu": 0.3}, scales=7)
    assert changed.scale == Scale(**{**PRINTED.scale.model_dump(), "alpha": "30 deg"})
    assert (changed.friction.mu, changed.scales, changed.pitch) == (0.3, 7, PRINTED.pitch)
    with pytest.raises(InputError, match=r"scale\.alpha = 30 rad: is out of range .* write \"30 deg\""):
        PRINTED.replace(scale={"alpha": 30})


@settings(deadline=None)
@given(
    st.fixed_dictionaries(
        {
            "eta": st.floats(1.1, 9),
            "beta": st.floats(0.2, 3),
            "lam": st.floats(0.2, 2),
            "zeta": st.floats(0.05, 0.5),
            "slenderness": st.floats(5, 90),
            "alpha": st.floats(1e-3, 1.57),
            "theta0": st.floats(1e-3, 0.4),
            "youngs_modulus": st.floats(1e4, 1e12),
            "poisson_ratio": st.floats(-0.99, 0.4999),
            "scales": st.integers(2, 900),
            "mu": st.none() | st.floats(0, 10),
            "stiffness": st.none() | st.floats(1e-6, 1e3),
            "inclusion_factor": st.none() | st.floats(0.5, 5),
        }
    )
)
def test_toml_round_trip_is_exact(arguments):
    beam = Beam.from_ratios(**arguments)
    assert Beam.from_toml_text(beam.to_toml()) == beam


def test_toml_file(tmp_path):
    path = tmp_path / "beam.toml"
    text = PRINTED.to_toml(path)
    assert path.read_text(encoding="utf-8") == text
    assert Beam.from_toml(path) == Beam.from_toml(str(path)) == PRINTED
    assert 'length = "60 mm"' in text
    assert 'alpha = "45 deg"' in text
    # Windows line ends and a byte order mark are no mistakes
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", "\r\n").encode())
    assert Beam.from_toml(path) == PRINTED


def test_overrides_of_a_file():
    text = PRINTED.to_toml()
    beam = Beam.from_toml_text(text, overrides={"friction": {"mu": 0.4}, "beam": {"pitch": "21 mm"}})
    assert beam == PRINTED.replace(friction={"mu": 0.4}, pitch=0.021)
    with pytest.raises(InputError, match=r'beam: scale\.alpha = 30: has no unit; write "30 deg"'):
        Beam.from_toml_text(text, overrides={"scale": {"alpha": 30}})


def test_the_file_has_exactly_the_models_keys():
    models = {"scale": Scale, "substrate": Substrate, "joint": Joint, "friction": Friction}
    assert {name: set(TABLES[name]) for name in models} == {
        name: set(model.model_fields) for name, model in models.items()
    }
    assert set(Beam.model_fields) == set(models) | set(TABLES["beam"])
    # the examples that messages show are a whole, valid file, the line of one face left out
    text = "\n".join(
        f"[{table}]\n" + "\n".join(f"{key} = {row.example}" for key, row in keys.items())
        for table, keys in TABLES.items()
    )
    text = text.replace('matrix = "joint.csv"', "").replace('neutral = "face"', "")
    assert Beam.from_toml_text(text).friction.mu == 0.25


def _only(beam, load="twisting", part=""):
    lines = [line for line in beam.warnings(load) if part in line]
    assert all(len(line.splitlines()) == 1 for line in lines)
    assert len(lines) == 1
    return lines[0]


def test_no_warning_inside_every_range():
    assert FIG_6B.warnings() == []
    assert FIG_6B.warnings("bending") == []
    with pytest.raises(InputError, match="write one of twisting, bending"):
        FIG_6B.warnings("shear")


def test_printed_plate_uses_41_percent_of_the_gap():
    line = _only(PRINTED, part="not thin")
    assert "41 % of the gap d sin(theta0) cos(alpha) = 2.46 mm" in line
    thick, thin = (float(x) for x in re.findall(r"at ([\d.]+) deg", line))
    assert 0.3 * thin < thick < 0.7 * thin
    assert "41 % of the gap d sin(theta0) cos(alpha) = 2.46 mm" in _only(PRINTED, "bending", "not thin")


def test_thin_ends_at_five_percent():
    gap = 0.02 * math.sin(math.radians(10)) * math.cos(math.radians(45))
    for share, told in ((0.0499, False), (0.0501, True)):
        beam = PRINTED.replace(scale={"thickness": share * gap})
        assert any("not thin" in line for line in beam.warnings()) is told
    assert "touch at rest" in _only(PRINTED.replace(scale={"thickness": gap}), part="not thin")


def test_wide_scales():
    # theory section 5: wider than the bar for alpha < 43.9 deg
    assert not any("wider" in line for line in Beam.from_ratios(alpha="44 deg").warnings())
    line = _only(Beam.from_ratios(alpha="40 deg"), part="wider")
    assert "34.05 mm against 32 mm" in line
    assert "alpha >= 43.95 deg" in line


def test_the_other_warnings():
    assert "eta = l/d = 1" in _only(PRINTED.replace(scale={"length": 0.02}), part="overlap")
    assert "t_s/d = 0.05" in _only(PRINTED, part="joint stiffness K_theta")
    assert "zeta beta/lambda = 1.2" in _only(
        PRINTED.replace(scale={"embedded": 0.0128, "width": 0.03}), part="inclusion factor C_f: zeta"
    )
    # the joint of a scale is one whatever the load
    thick = _only(PRINTED.replace(scale={"thickness": "4 mm"}), "bending", "joint stiffness K_theta: t_s/(l + L)")
    assert "t_s/(l + L) = 0.0597" in thick
    assert "no stiffness" in _only(PRINTED.replace(scale={"embedded": 0}), part="embedded")
    known = PRINTED.replace(scale={"embedded": 0}, joint={"stiffness": 0.01, "inclusion_factor": 1})
    assert not [line for line in known.warnings() if "joint" in line or "embedded" in line]


def test_a_tab_that_goes_through_is_refused():
    edge = 0.016 / math.sin(math.radians(10))
    assert PRINTED.replace(scale={"embedded": 0.999 * edge}).zeta > 4
    with pytest.raises(InputError, match=r"scale\.embedded = 92\.14 mm: the tab goes through .* 92\.14 mm"):
        PRINTED.replace(scale={"embedded": 1.00001 * edge})
