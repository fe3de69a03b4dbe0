"""Several threads at once: the same bits as one after the other, and nothing left behind in the process."""

import sys
import warnings
from concurrent.futures import ThreadPoolExecutor

import flint
import numpy as np
import pytest

from convexperc.enclosure.balls import precision
from convexperc.enclosure.enclosure import enclose
from convexperc.enclosure.interval import Interval
from convexperc.problem.problem import Problem
from convexperc.recognition.label import recognize
from convexperc.solution.single import solve
from convexperc.solution.weights import weight_intervals
from convexperc.solvers.conic import Conic
from convexperc.solvers.osqp import Quadratic
from verification.problems.families import seeded

FAMILIES = ("mixed_scales", "extreme_data", "nearly_zero_view")
OWN_BITS = 77
"""A precision that a caller has chosen for work of its own."""


@pytest.fixture
def own_precision():
    """The caller's precision, and threads that take turns as often as possible."""
    bits, interval = flint.ctx.prec, sys.getswitchinterval()
    flint.ctx.prec = OWN_BITS
    sys.setswitchinterval(1e-5)
    yield OWN_BITS
    flint.ctx.prec = bits
    sys.setswitchinterval(interval)


def enclosed(problem):
    found = enclose(problem)
    return found.lower, found.upper, found.w.tobytes(), found.u.tobytes(), found.bits, found.exact


def solved(problem, solver=None):
    found = solve(problem, solver)
    proof = found.certificate
    return found.w.tobytes(), found.u.tobytes(), proof.lower, proof.upper, proof.gap


def weighed(problem):
    found = weight_intervals(solve(problem), enclose(problem))
    return [part.lower.tobytes() + part.upper.tobytes() for part in (found.views, found.modalities)]


def recognized(X, O):
    found = recognize(X, O, modalities=[4, 8], lambda1=1, lambda2=0.1, lambda3=0.1)
    answers = found.answers
    bounds = answers.lower.tobytes(), answers.upper.tobytes(), answers.w.tobytes()
    return found.verdict, found.candidates, *bounds


def jobs():
    """Calls of every kind, as functions without arguments."""
    conic, quadratic = Conic(), Quadratic()
    for index in range(6):
        for family in FAMILIES:
            problem = seeded(family, 3, index, largest=(4, 6))
            yield from (lambda f=f, problem=problem: f(problem) for f in (enclosed, solved, weighed))
        rng = np.random.default_rng(index)
        X, O = rng.normal(size=(3, 12)), rng.normal(size=(12, 20))
        close = np.column_stack([O[:, 0], O[:, 0] * (1 + 2**-50), O])
        yield from (lambda X=X, O=O: recognized(X, O) for O in (O, close))
        problem = Problem(X, O[:, 0], lambda1=1, lambda2=0.1, lambda3=0)
        yield from (lambda s=s, problem=problem: solved(problem, s) for s in (conic, quadratic))


def test_eight_threads_give_the_bits_of_one_and_leave_nothing_behind(own_precision):
    filters = list(warnings.filters)
    alone = [job() for job in jobs()]
    with ThreadPoolExecutor(8) as pool:
        together = list(pool.map(lambda job: job(), jobs()))
    for one, other in zip(alone, together, strict=True):
        assert one == other
    assert flint.ctx.prec == own_precision
    assert warnings.filters == filters


@pytest.mark.parametrize("kind", [KeyboardInterrupt, RuntimeError])
def test_the_precision_of_the_caller_outlives_any_end(own_precision, monkeypatch, kind):
    def broken_off(self, near):
        assert flint.ctx.prec != own_precision
        raise kind

    monkeypatch.setattr(Interval, "refine", broken_off)
    with pytest.raises(kind):
        enclose(Problem([[1.0]], [1.0], lambda1=1, lambda2=0.5, lambda3=0.25))
    assert flint.ctx.prec == own_precision
    with ThreadPoolExecutor(1) as pool:  # which would never end if this thread still held the lock
        assert pool.submit(bits_inside, 99).result() == 99
    assert flint.ctx.prec == own_precision


def bits_inside(bits):
    with precision(bits):
        return flint.ctx.prec
