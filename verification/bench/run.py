"""The benchmark: every peer brought to the same gap by the same judge, one after the other, one BLAS thread.

A peer is measured in a process of its own, so that a limit of time can end it. Its tolerance is tightened
until `convexperc.certify` proves a relative gap of `GAP` on the original data; the time of that setting
counts, without its set-up, which is stated apart.

Some peers have no dual point to offer, and that of the residuals is only as good as the root of the gap. So
that no peer pays for this, the judge sets F(w, u) of every peer against the best lower bound of F* that
`certify` has proved from a tight answer; what is asked of a peer is its point, not its proof. On instances of
more than `LARGE` entries both come from the reduced data, rounding not included.
"""

import math
import multiprocessing
import os
import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, field
from multiprocessing.connection import Connection
from statistics import median
from typing import Any

from convexperc.certificate.certificate import certify
from convexperc.errors import SolverError
from convexperc.recognition.warming import warm
from verification.bench.floor import FrameTimes, frame_times
from verification.bench.instances import LAMBDAS, TINY, Instance, Lambdas, Shape
from verification.bench.peers import PEERS, Peer
from verification.bench.posed import Ours, Posed
from verification.bench.reduced_gap import LARGE, value_and_gap

GAP = 1e-9
"""Relative gap that every peer is held to."""
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
START_SECONDS = 600.0
"""Longest that a process may take to import, draw the instance and warm up, before its clock starts."""


@dataclass(frozen=True)
class Sample:
    """One template solved: by which tolerance, in what time, to which gap."""

    lambdas: Lambdas
    template: int
    tolerance: float
    seconds: float
    gap: float

    @property
    def reached(self) -> bool:
        """Whether the judge is satisfied."""
        return self.gap <= GAP


@dataclass
class Outcome:
    """What one peer did on one instance.

    Attributes
    ----------
    peer : str
    samples : list of Sample
        One a choice of lambdas and template: the first that satisfies the judge, else the one of least gap.
        With several repetitions, its time is their median.
    setups : list of float
        Seconds of each set-up.
    remark : str
        Why samples are missing; empty if none is.
    first_call : float
        Seconds of the first solve of all, compilers and imports included.
    reduction : float
        Seconds of the Gram matrices and their factors, which all reduced forms share.
    """

    peer: str
    samples: list[Sample] = field(default_factory=list)
    setups: list[float] = field(default_factory=list)
    remark: str = ""
    first_call: float = math.nan
    reduction: float = math.nan

    def seconds(self, lambdas: Lambdas | None = None) -> float:
        """Median seconds of a template; NaN without one."""
        times = [s.seconds for s in self.samples if lambdas in (None, s.lambdas)]
        return median(times) if times else math.nan

    @property
    def worst_gap(self) -> float:
        """The largest gap of all; NaN without a sample."""
        return max((s.gap for s in self.samples), default=math.nan)

    @property
    def missed(self) -> int:
        """Samples that the judge was not satisfied with."""
        return sum(not s.reached for s in self.samples)


def run(
    shape: Shape, wanted: str, templates: int, repeat: int, limit: float
) -> tuple[list[Outcome], FrameTimes]:
    """Measure every peer whose name contains `wanted` on one instance, then the whole frame and its floor.

    Parameters
    ----------
    shape : Shape
    wanted : str
    templates, repeat : int
        See `measure`.
    limit : float
        Seconds a peer may take.

    Returns
    -------
    (list of Outcome, FrameTimes)
    """
    chosen = [peer for peer in PEERS.values() if wanted in peer.name]
    with one_thread():
        instance = Instance.of(shape)
        frames = frame_times(instance, repeat)
        bounds = proved_bounds(instance, templates)
        del instance
    return [
        isolated(peer, shape, bounds, templates=templates, repeat=repeat, limit=limit) for peer in chosen
    ], frames


Send = Callable[[str, Any], None]
Bounds = dict[tuple[Lambdas, int], float]
"""The best proved lower bound of F*, by lambdas and template."""


def proved_bounds(instance: Instance, templates: int) -> Bounds:
    """Bound F* from below for the templates that are judged, each from a tight answer."""
    bounds: Bounds = {}
    for lambdas in LAMBDAS:
        tight = Ours(instance, lambdas, 1e-13)
        for j, (_, found) in enumerate(tight.run(range(min(templates, instance.shape.p)))):
            w, u = tight.point(found)
            if instance.X.size > LARGE:
                value, gap = value_and_gap(instance, j, lambdas, w, u)
                bounds[lambdas, j] = value - gap
            else:
                bounds[lambdas, j] = certify(instance.problem(j, lambdas), w, u).lower
    return bounds


def measure(peer: Peer, shape: Shape, bounds: Bounds, templates: int, repeat: int, send: Send) -> None:
    """Measure one peer here, and send what becomes known: first_call, reduction, ready, setups, samples.

    Parameters
    ----------
    peer : Peer
    shape : Shape
    bounds : dict
        See `proved_bounds`.
    templates : int
        How many of the instance's templates are judged, for each choice of the lambdas.
    repeat : int
        How often a setting that satisfies the judge is timed.
    send : callable
        Takes the name of a fact and the fact.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        start = time.perf_counter()
        if issubclass(peer.kind, Ours):
            warm()
        peer.kind(Instance.of(TINY), LAMBDAS[0], peer.ladder[0]).run([0])
        send("first_call", time.perf_counter() - start)
        instance = Instance.of(shape)
        start = time.perf_counter()
        _ = instance.reduced, instance.C, instance.targets
        send("reduction", time.perf_counter() - start)
        send("ready", True)
        chosen = list(range(min(templates, shape.p)))
        for lambdas in LAMBDAS:
            _climb(peer, instance, bounds, lambdas, chosen, repeat, send)


def _climb(
    peer: Peer,
    instance: Instance,
    bounds: Bounds,
    lambdas: Lambdas,
    chosen: Sequence[int],
    repeat: int,
    send: Send,
) -> None:
    """Tighten the tolerance until every chosen template satisfies the judge."""
    best: dict[int, Sample] = {}
    for tolerance in peer.ladder:
        left = [j for j in chosen if j not in best or not best[j].reached]
        if not left:
            break
        start = time.perf_counter()
        posed = peer.kind(instance, lambdas, tolerance)
        send("setups", time.perf_counter() - start)
        for j in left:
            sample = _judged(posed, j, lambdas, bounds.get((lambdas, j), 0.0), repeat)
            if sample is not None and (j not in best or sample.gap < best[j].gap):
                best[j] = sample
                send("samples", sample)


def _judged(posed: Posed, template: int, lambdas: Lambdas, bound: float, repeat: int) -> Sample | None:
    """Time one template, judge it, and time it again where the judge is satisfied; None where it failed."""
    try:
        [(seconds, found)] = posed.run([template])
        w, u = posed.point(found)
    except (SolverError, ValueError, ArithmeticError, TypeError):
        return None
    if posed.instance.X.size > LARGE:
        value, gap = value_and_gap(posed.instance, template, lambdas, w, u)
        gap /= value - gap
    else:
        proof = certify(posed.instance.problem(template, lambdas), w, u)
        value, gap = proof.objective[1], proof.relative_gap
    if bound > 0.0:
        gap = min(gap, max(0.0, (value - bound) / bound))
    times = [seconds]
    if gap <= GAP:
        times += [posed.run([template])[0][0] for _ in range(repeat - 1)]
    return Sample(lambdas, template, posed.tolerance, median(times), gap)


def isolated(
    peer: Peer, shape: Shape, bounds: Bounds, *, templates: int, repeat: int, limit: float
) -> Outcome:
    """Measure one peer in a process of its own, which is ended `limit` seconds after it is ready."""
    outcome = Outcome(peer.name, remark=peer.left_out(shape.n * shape.d))
    if outcome.remark:
        return outcome
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe(duplex=False)
    work = (peer.name, shape, bounds, templates, repeat, theirs)
    worker = context.Process(target=_work, args=work, daemon=True)
    os.environ.update(dict.fromkeys(THREADS, "1"))
    worker.start()
    theirs.close()
    try:
        _listen(ours, outcome, limit)
    finally:
        worker.terminate()
        worker.join()
        ours.close()
    return outcome


def _work(name: str, shape: Shape, bounds: Bounds, templates: int, repeat: int, pipe: Connection) -> None:
    def send(key: str, value: Any) -> None:
        pipe.send((key, value))

    try:
        with one_thread():
            measure(PEERS[name], shape, bounds, templates, repeat, send)
        send("done", True)
    except Exception as problem:  # a peer may fail in any way; the others go on
        send("failed", f"{type(problem).__name__}: {problem}"[:200])


def _listen(pipe: Connection, outcome: Outcome, limit: float) -> None:
    """Gather what a worker sends until it is done or its time is over."""
    found: dict[tuple[Lambdas, int], Sample] = {}
    end, over = time.monotonic() + START_SECONDS, "not ready in time"
    try:
        while pipe.poll(max(0.0, end - time.monotonic())):
            key, value = pipe.recv()
            if key in ("done", "failed"):
                over = "" if key == "done" else value
                break
            if key == "ready":
                end, over = time.monotonic() + limit, f"stopped after {limit:g} s"
            elif key == "setups":
                outcome.setups.append(value)
            elif key == "samples":
                found[value.lambdas, value.template] = value
            else:
                setattr(outcome, key, value)
    except EOFError:
        over = "its process died"
    outcome.samples, outcome.remark = list(found.values()), over


def one_thread() -> AbstractContextManager[Any]:
    """Context in which BLAS uses one thread; without threadpoolctl, only the environment can say so."""
    try:
        from threadpoolctl import threadpool_limits  # noqa: PLC0415 - an optional package
    except ImportError:
        return nullcontext()
    limits: AbstractContextManager[Any] = threadpool_limits(1)
    return limits
