"""Studies beside each other: what differs, ratios, curves, and the page."""

import numpy as np
import pytest

import freebody as fb
from support.command import run


def arm(second=1.0):
    return fb.planar("RR", l=[1.0, second], m=[2.0, 1.0], I=[0.1, 0.05], lc=[0.5, second / 2])


@pytest.fixture(scope="module")
def empty():
    return fb.study(arm())


@pytest.fixture(scope="module")
def loaded(empty):
    return fb.study(arm().with_payload(2.0), empty.motion)


@pytest.fixture(scope="module")
def faster(empty):
    return fb.study(arm(), empty.motion, speed=2.0)


def told(comparison):
    return {row.what: row.each for row in comparison.differences}


def test_only_what_differs_is_told(empty, loaded, faster):
    by_load = fb.compare([empty, loaded])
    assert by_load.names == ("0 kg", "2 kg")
    assert set(told(by_load)) == {"mass", "load"}
    assert told(by_load)["mass"] == ("3 kg", "5 kg")
    by_pace = fb.compare([empty, faster])
    assert by_pace.names == ("1 times as fast", "2 times as fast")
    assert set(told(by_pace)) == {"motion", "pace", "duration"}
    assert told(fb.compare({"a": empty, "b": empty})) == {}


def test_ratios_are_those_of_the_summaries(empty, loaded):
    found = fb.compare({"empty": empty, "loaded": loaded})
    peak = next(q for q in found.quantities if q.variable == "peak_torque")
    for row in found.drives:
        first, second = (
            abs(float(s.summary["peak_torque"].sel(coordinate=row.name))) for s in found.studies
        )
        one, other = found.texts(peak, row)
        assert "×" not in one
        assert float(other.partition("× ")[2].rstrip(")")) == pytest.approx(
            second / first, rel=6e-3
        )
    speed = next(q for q in found.quantities if q.variable == "peak_speed")
    assert found.alike(speed)
    assert not found.alike(peak)


def test_curves_are_those_of_the_studies_and_end_with_them(empty, faster):
    found = fb.compare({"slow": empty, "fast": faster})
    row = found.drives[1]
    t, curves = found.over_time(
        row, lambda study, drive: study.data["tau"].sel(coordinate=drive).values
    )
    for name, study in zip(found.names, found.studies, strict=True):
        own = study.motion.t - study.motion.t[0]
        at = np.searchsorted(t, own)
        assert np.array_equal(t[at], own)
        assert curves[name][at] == pytest.approx(study.data["tau"].sel(coordinate=row.name).values)
    assert np.isnan(curves["fast"][t > faster.motion.duration + 1e-9]).all()
    assert np.isfinite(curves["slow"]).all()


def test_drives_with_unlike_names_stand_in_their_order(empty):
    other = fb.study(fb.load("cart_pole"))
    found = fb.compare([empty, other])
    assert found.by_order
    assert [row.of for row in found.drives] == [("joint1", "x"), ("joint2", "")]
    assert "in their order" in found.matched
    assert found.texts(found.quantities[0], found.drives[1])[1] == "–"


def test_a_torque_is_no_multiple_of_a_force_and_what_is_not_drawn_is_told(tmp_path):
    numbers = {"l": [0.5, 0.4], "m": [1.0, 1.0], "I": [0.1, 0.1], "lc": [0.2, 0.2]}
    found = fb.compare([fb.study(fb.planar(kinds, **numbers)) for kinds in ("RR", "PR")])
    peak = found.quantities[0]
    turned, slid = found.texts(peak, found.drives[0])
    assert turned.endswith("N m")
    assert slid.endswith(" N")
    assert "×" in found.texts(peak, found.drives[1])[1]
    assert found.unlike_kinds == ("joint1",)
    text = found.to_html(tmp_path / "page.html").read_text(encoding="utf-8")
    assert text.count("Not drawn, since one turns and one slides: joint1.") == 2


def test_the_page_stands_alone_and_names_are_text(empty, loaded, tmp_path):
    page = fb.compare({"<script>alert(1)</script>": empty, "b": loaded}).to_html(
        tmp_path / "page.html"
    )
    text = page.read_text(encoding="utf-8")
    assert "<script>alert" not in text
    assert "&lt;script&gt;alert(1)" in text
    assert text.count("<h2>") == 6
    assert "://" not in text.replace("http://www.w3.org/2000/svg", "")


@pytest.mark.parametrize(
    ("studies", "said"),
    [
        (lambda study: [study], "1 study given, expected 2 to 8"),
        (lambda study: [study] * 9, "9 studies given, expected 2 to 8"),
        (lambda study: [study, study.model], r"studies\[1\] is Model, expected a study"),
        (lambda study: {1: study, "1": study}, "two studies are named '1'"),
        (lambda study: {" ": study, "b": study}, "a study is named ''"),
        (lambda study: "ur5e", "a list of studies, or a mapping"),
        (lambda study: study, "a list of studies, or a mapping"),
    ],
)
def test_what_cannot_be_compared_is_refused(empty, studies, said):
    with pytest.raises(fb.FreebodyError, match=said):
        fb.compare(studies(empty))


def test_the_command_takes_each_case_with_its_own_options(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert run(["compare", "pendulum", "heavy: pendulum --payload 2", "--out", "p.html"]) == 0
    said = capsys.readouterr().out
    assert "heavy" in said
    assert "payload, 2 kg" in said
    assert (tmp_path / "p.html").exists()
    assert run(["compare", "pendulum", "pendulum --pyload 2"]) == 2
    assert "'pendulum --pyload 2': No such option: --pyload" in capsys.readouterr().err
    assert run(["compare", "pendulum", "pendulum 'a"]) == 2
    assert "No closing quotation" in capsys.readouterr().err
    (tmp_path / "day.toml").write_text("[[segment]]\npoints = [[0.0], [1.0]]\ntimes = [0, 1]\n")
    assert run(["compare", "pendulum --motion day.toml", "pendulum"]) == 2
    assert "day.toml is a duty cycle, and one motion each" in capsys.readouterr().err
    assert run(["compare", "pendulum", "pendulum", "--out", "p.txt"]) == 2
    assert "expected an .html or .pdf file" in capsys.readouterr().err
