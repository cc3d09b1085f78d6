"""The page of an identification: its verdict, measured against predicted torques, what is left,
parameters with intervals, friction, and what to measure next."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from freebody.arrays import Array
from freebody.figures.plots import Plot, plot
from freebody.identification.collisions import DetectedCollisions
from freebody.identification.evidence import LogFit
from freebody.identification.identification import Identification, IdentifiedParameter
from freebody.identification.identified_payload import IdentifiedPayload
from freebody.report.page import filled
from freebody.report.page_figures import CaptionedDrawing
from freebody.report.tables import (
    Cell,
    Head,
    PrintedNumber,
    ReportTable,
    WordsCell,
    alone,
    table,
)

_SHOWN = 60.0
"""Time (s) of a log that curves show."""
_BINS = 12
"""Ranges of the rate, each way, over which friction is averaged."""
_TONES = {"predicts": "good", "fails": "poor", "not validated": "open"}


def identification_page(
    found: Identification,
    payload: IdentifiedPayload | None = None,
    collisions: DetectedCollisions | None = None,
) -> str:
    """The HTML text of the page of an identification, and of the load and the collisions that were
    looked for with it."""
    shown = found.fits[-1] if found.fits else None
    tone = _TONES[found.outcome]
    if tone == "good" and not found.trusted:
        tone = "open"
    sections = [
        ("verdict", "Verdict", True),
        ("measured", "Measured and predicted", shown is not None),
        ("friction", "Friction", bool(found.fits)),
        ("parameters", "Parameters", True),
        ("payload", "Payload", payload is not None),
        ("collisions", "Collisions", collisions is not None),
        ("next", "What to measure next", bool(found.next)),
    ]
    units = _units(found)
    return filled(
        "identification.html",
        model=found.model,
        found=found,
        tone=tone,
        contents=[(name, title) for name, title, there in sections if there],
        math_style="",
        joints=joints(found),
        parameters=parameters(found),
        prior_alone=found.prior_alone,
        shown=shown,
        shown_words=_shown_words(shown),
        torques=[] if shown is None else list(torques(found, shown, units)),
        friction=list(friction(found, units)) if found.fits else [],
        drift=drift(found),
        payload=payload,
        payload_numbers=None if payload is None else payload_numbers(payload),
        collisions=collisions,
        collision_table=None if collisions is None else collision_table(collisions),
        residuals=[] if collisions is None else list(residuals(collisions, units)),
    )


def _units(found: Identification) -> dict[str, str]:
    """The unit of each joint's torque or force."""
    return {b.joint.name: "N m" if b.kind.turns else "N" for b in found.model.bodies}


def joints(found: Identification) -> ReportTable:
    """The table of how well each joint's torque is predicted."""
    heads = [
        Head("Joint", number=False),
        Head("RMS torque", "N m, N"),
        Head("left by the regression", "%", "RMS of what is left over RMS of the torque"),
        Head("left by the model", "%", "of the logs that it was made from"),
        Head("left of unseen logs", "%"),
        Head("law of friction", number=False),
    ]
    rows = [
        (
            WordsCell(x.joint, strong=True),
            _number(x.torque, "torque", x.joint),
            _number(100.0 * x.regression, "regression", x.joint),
            _number(100.0 * x.model, "model", x.joint),
            WordsCell("–")
            if x.validation is None
            else _number(100.0 * x.validation, "validation", x.joint),
            WordsCell("fits" if x.law_fits else "does not fit", css="" if x.law_fits else "bad"),
        )
        for x in found.joints
    ]
    return table("How well torques are predicted", heads, list(zip(*rows, strict=True)))


def parameters(found: Identification) -> ReportTable:
    """The table of base parameters and friction with intervals."""
    rows = [
        (
            WordsCell(x.name, strong=True),
            *_interval(x.value, x.lower, x.upper, x.name),
            alone(_number(x.in_model, "in_model", x.name)),
            WordsCell(x.unit),
            WordsCell(_remark(x)),
        )
        for x in found.parameters
    ]
    return _with_intervals("Base parameters and friction, before prior and constraints", rows)


def _remark(x: IdentifiedParameter) -> str:
    return x.withdrawn or ("" if x.told else "not told by these motions")


def payload_numbers(found: IdentifiedPayload) -> ReportTable:
    """The table of a load's numbers with intervals."""
    rows = [
        (
            WordsCell(x.name, strong=True),
            *_interval(x.value, x.lower, x.upper, x.name),
            alone(_number(x.in_model, "in_model", x.name)),
            WordsCell(x.unit),
            WordsCell("" if x.told else "not told by these motions"),
        )
        for x in found.numbers
    ]
    return _with_intervals(f"The load at {found.frame}, in its axes", rows)


def _with_intervals(caption: str, rows: Sequence[Sequence[Cell]]) -> ReportTable:
    heads = [
        Head("Name", number=False),
        Head("Value"),
        Head("95 %, from"),
        Head("to"),
        Head("In the model", tip="of the nearest bodies that can exist"),
        Head("Unit", number=False),
        Head("", number=False),
    ]
    return table(caption, heads, list(zip(*rows, strict=True)))


def _number(value: float, variable: str, name: str) -> PrintedNumber:
    return PrintedNumber(float(value), variable, {"name": name})


def _interval(value: float, lower: float, upper: float, name: str) -> list[Cell]:
    """Cells of a value and the ends of its interval, as many digits as tell them apart."""
    made: list[Cell] = []
    for x, what in ((value, "value"), (lower, "lower"), (upper, "upper")):
        there = np.isfinite(x)
        made.append(alone(_number(x, what, name), 4) if there else WordsCell("–", css="n"))
    return made


def drift(found: Identification) -> ReportTable | None:
    """The table of friction block by block of time, of joints at which it drifts, or None."""
    rows = [
        (
            WordsCell(x.joint, strong=True),
            WordsCell(found.fits[int(log)].source if found.fits else f"log {log + 1:.0f}"),
            alone(_number(time, "time", x.joint)),
            alone(_number(factor, "factor", x.joint)),
            alone(_number(half, "half", x.joint), 2),
            alone(_number(warm, "temperature", x.joint)) if np.isfinite(warm) else WordsCell("–"),
        )
        for x in found.drift
        if x.significant
        for log, time, factor, half, warm in zip(
            x.log, x.time, x.factor, x.half, x.temperature, strict=True
        )
    ]
    if not rows:
        return None
    heads = [
        Head("Joint", number=False),
        Head("Log", number=False),
        Head("t", "s"),
        Head("friction", "of its mean"),
        Head("±", "95 %"),
        Head("temperature", "°C"),
    ]
    return table("Friction over time", heads, list(zip(*rows, strict=True)))


def collision_table(found: DetectedCollisions) -> ReportTable | None:
    """The table of the pushes that a log shows, or None."""
    if not found.collisions:
        return None
    heads = [
        Head("Start", "s"),
        Head("End", "s"),
        Head("outermost joint", number=False),
        Head("struck link", number=False, tip="or one farther out, where it turns no other joint"),
        Head("torque there", "N m, N"),
        Head("over threshold", "times"),
    ]
    rows = [
        (
            _number(x.start, "start", x.joint),
            _number(x.end, "end", x.joint),
            WordsCell(x.joint),
            WordsCell(x.link),
            _number(x.torque[found.names.index(x.joint)], "torque", x.joint),
            _number(x.times, "times", x.joint),
        )
        for x in found.collisions
    ]
    return table("Collisions", heads, list(zip(*rows, strict=True)))


def _shown_words(fit: LogFit | None) -> str:
    if fit is None:
        return ""
    what = "which the model was not made from" if fit.unseen else "which the model was made from"
    part = ""
    if fit.time[-1] - fit.time[0] > _SHOWN:
        part = f" The first {_SHOWN:.0f} s of {fit.time[-1] - fit.time[0]:.0f} s."
    return f"The log {fit.source.removeprefix('read from ')}, {what}.{part}"


def torques(
    found: Identification, fit: LogFit, units: dict[str, str]
) -> Iterator[CaptionedDrawing]:
    """Plots of measured and predicted torques of each joint, and behind them of what is left."""
    part = fit.time <= fit.time[0] + _SHOWN
    both, left = [], []
    for j, x in enumerate(found.joints):
        measured, predicted = fit.measured[part, j], fit.predicted[part, j]
        if np.isnan(measured).all():
            continue
        both.append((x.joint, {"measured": measured, "predicted": predicted}))
        left.append((x.joint, {"left": measured - predicted}))
    for plots, words in ((both, ""), (left, ": what is left")):
        for joint, curves in plots:
            unit, named = units[joint], len(curves) > 1
            what = Plot(joint + words, fit.time[part], curves, unit, peaks=False, names=named)
            yield CaptionedDrawing(plot(what))


def friction(found: Identification, units: dict[str, str]) -> Iterator[CaptionedDrawing]:
    """Plots of each joint's friction over its rate: of the logs, of its mean, of the model."""
    for j, x in enumerate(found.joints):
        rate = np.concatenate([fit.rate[:, j] for fit in found.fits])
        left = np.concatenate([(fit.measured - fit.predicted)[:, j] for fit in found.fits])
        law = np.concatenate([fit.friction[:, j] for fit in found.fits])
        there = np.isfinite(rate)
        rate, left, law = rate[there], left[there], law[there]
        if rate.min() >= 0.0 or rate.max() <= 0.0:
            continue
        t, curves = _over_rates(rate, {"logs": law + left, "mean": law + left, "model": law})
        across = "rate in rad/s" if units[x.joint] == "N m" else "rate in m/s"
        what = Plot(x.joint, t, curves, units[x.joint], peaks=False, across=across, faint=("logs",))
        yield CaptionedDrawing(plot(what))


def _over_rates(rate: Array, values: dict[str, Array]) -> tuple[Array, dict[str, Array]]:
    """Rates in order, with a gap between the two ways, and values over them, the first as they are,
    the others as means over ranges of equally many samples."""
    order = np.argsort(rate)
    split = int(np.searchsorted(rate[order], 0.0))
    t = np.insert(rate[order], split, 0.0)
    curves = {}
    for k, (name, x) in enumerate(values.items()):
        ways = []
        for way in (order[:split], order[split:]):
            own = x[way]
            if k:
                bins = np.array_split(np.arange(len(way)), min(_BINS, len(way)))
                at = [float(rate[way][b].mean()) for b in bins]
                means = [float(x[way][b].mean()) for b in bins]
                own = np.interp(rate[way], at, means, left=np.nan, right=np.nan)
            ways.append(own)
        curves[name] = np.concatenate([ways[0], [np.nan], ways[1]])
    return t, curves


def residuals(found: DetectedCollisions, units: dict[str, str]) -> Iterator[CaptionedDrawing]:
    """Plots of the observer's residual of each joint, with its thresholds."""
    for j, name in enumerate(found.names):
        level = float(found.threshold[j])
        values = np.where(found.judged, found.residual[:, j], np.nan)
        what = Plot(name, found.time, {name: values}, units[name], (-level, level), names=False)
        yield CaptionedDrawing(plot(what))
