"""What a run of the benchmark says: the machine, the versions, and the tables."""

import math
import os
import platform
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich.table import Table

from verification.bench.floor import FrameTimes, Growth
from verification.bench.instances import LAMBDAS, Shape
from verification.bench.peers import ABSENT, OURS
from verification.bench.picture_frames import PictureTimes
from verification.bench.proof_times import ProofTimes
from verification.bench.reduced_gap import LARGE
from verification.bench.run import GAP, Outcome, one_thread
from verification.provenance import installed, processor

PACKAGES = ("numpy", "scipy", "numba", "cvxpy", "clarabel", "qoco", "scs", "skglm", "celer")


def machine() -> dict[str, Any]:
    """Processor, system, versions and BLAS kernels; no path and no host."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": {name: installed(name) for name in PACKAGES},
        "blas": _blas(),
    }


def _blas() -> list[str]:
    """Each BLAS that is loaded: library, version, kernel and threads."""
    try:
        from threadpoolctl import threadpool_info  # noqa: PLC0415 - an optional package
    except ImportError:
        return ["unknown: threadpoolctl not installed (extra bench)"]
    with one_thread():
        found = [info for info in threadpool_info() if info["user_api"] == "blas"]
    names = ("internal_api", "version", "architecture", "num_threads")
    return [
        f"{info['prefix']}: " + ", ".join(f"{name} {info.get(name, 'unknown')}" for name in names)
        for info in found
    ]


def peers_table(shape: Shape, outcomes: Sequence[Outcome]) -> Table:
    """One line a peer."""
    title = f"{shape.name}: n {shape.n}, d {shape.d} {shape.sizes}, p {shape.p}, seed {shape.seed}"
    judge = "certify" if shape.n * shape.d <= LARGE else "the gap of the reduced data"
    caption = f"ms a template, median; gap of {GAP:g} by {judge}; set-up apart"
    table = Table("peer", "ms", "by lambdas", "to ours", "worst gap", "set-up ms", "remark", title=title)
    table.caption = caption
    base = next((o.seconds() for o in outcomes if o.peer == OURS), math.nan)
    for outcome in outcomes:
        table.add_row(outcome.peer, *_cells(outcome, base), _remark(outcome))
    for name, reason in ABSENT.items():
        table.add_row(name, "-", "-", "-", "-", "-", reason)
    return table


def _cells(outcome: Outcome, base: float) -> list[str]:
    each = " / ".join(_number(1e3 * outcome.seconds(lambdas)) for lambdas in LAMBDAS)
    setup = sorted(outcome.setups)[len(outcome.setups) // 2] if outcome.setups else math.nan
    gap = "-" if math.isnan(outcome.worst_gap) else f"{outcome.worst_gap:.1e}"
    return [
        _number(1e3 * outcome.seconds()),
        each,
        _number(outcome.seconds() / base),
        gap,
        _number(1e3 * setup),
    ]


def _remark(outcome: Outcome) -> str:
    parts = []
    if outcome.missed:
        parts.append(f"not reached on {outcome.missed} of {len(outcome.samples)}")
    if outcome.remark:
        parts.append(f"{outcome.remark}, {len(outcome.samples)} solved")
    if outcome.first_call > 5.0:
        parts.append(f"first call {outcome.first_call:.0f} s")
    return "; ".join(parts)


def _number(value: float) -> str:
    return "-" if math.isnan(value) else f"{value:.3g}" if value < 1e3 else f"{value:,.0f}"


def frames_table(times: dict[str, FrameTimes]) -> Table:
    """Recognition against floor, one line an instance."""
    table = Table(
        "instance", "floor ms", "recognition ms", "ratio", "proved", "solved to the end",
        title="whole frame: X and O to the proved label with w and u; floor: Gram and X O",
    )  # fmt: skip
    for name, frame in times.items():
        whole = " / ".join(_number(1e3 * seconds) for seconds in frame.recognition)
        ratios = " / ".join(f"{ratio:.1f}" for ratio in frame.ratios)
        proved, full = f"{frame.labelled} of {len(LAMBDAS)}", " / ".join(map(str, frame.full))
        table.add_row(name, _number(1e3 * frame.floor), whole, ratios, proved, full)
    return table


def proofs_table(name: str, found: Sequence[ProofTimes]) -> Table:
    """What proofs cost, one line a choice of the lambdas."""
    table = Table(
        "lambdas", "certify ms", "width", "reduced ms", "128 bits ms", "width", "whole frame ms",
        title=f"{name}: proofs of a template, and the whole frame with all answers and intervals",
    )  # fmt: skip
    for each in found:
        table.add_row(
            ", ".join(f"{value:g}" for value in each.lambdas),
            _number(1e3 * each.certified),
            f"{each.relative_width:.1e}",
            _number(1e3 * each.reduced),
            _number(1e3 * each.enclosed),
            f"{each.enclosed_width:.1e}",
            _number(1e3 * each.many),
        )
    return table


def pictures_table(found: PictureTimes) -> Table:
    """From six pictures to the label."""
    table = Table(
        "first frame ms", "warm frame ms", "features ms", "label ms", "references ms", "right and proved",
        title="six 320 x 240 pictures to the proved label against eight references",
    )  # fmt: skip
    times = found.first, found.warm, found.extraction, found.recognition, found.preparation
    cells = [_number(1e3 * seconds) for seconds in times]
    table.add_row(*cells, f"{found.proved} of {len(found.frames)}")
    return table


def growth_table(found: Sequence[Growth]) -> Table:
    """Exponents of the growth, one line a size."""
    table = Table("size", "values", "floor ms", "solve ms", "exponent: floor", "solve", title="growth")
    for line in found:
        floor, solve = line.exponents
        times = (" / ".join(_number(1e3 * s) for s in part) for part in (line.floor, line.solve))
        table.add_row(line.size, " / ".join(map(str, line.values)), *times, f"{floor:.2f}", f"{solve:.2f}")
    return table


def as_json(
    outcomes: dict[str, list[Outcome]],
    frames: dict[str, FrameTimes],
    grown: Sequence[Growth],
    proofs: dict[str, list[ProofTimes]],
    pictures: PictureTimes | None,
    made: Mapping[str, Any],
) -> dict[str, Any]:
    """Plain data; what is not finite becomes None. `made` is the stamp of the code that was timed."""
    data = {
        "made": dict(made),
        "machine": machine(),
        "gap": GAP,
        "lambdas": LAMBDAS,
        "peers": {name: [asdict(o) for o in found] for name, found in outcomes.items()},
        "absent": ABSENT,
        "frames": {name: {**asdict(frame), "ratios": frame.ratios} for name, frame in frames.items()},
        "proofs": {name: [asdict(each) for each in found] for name, found in proofs.items()},
        "pictures": None if pictures is None else asdict(pictures),
        "growth": [{**asdict(line), "exponents": line.exponents} for line in grown],
    }
    plain: dict[str, Any] = _finite(data)
    return plain


def _finite(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _finite(part) for key, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
