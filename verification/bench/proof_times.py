"""What a proof costs: the float64 certificate, the one from the reduced data, ball arithmetic."""

from dataclasses import dataclass
from functools import partial

import numpy as np

from convexperc.certificate.cases import AnswerBounds
from convexperc.certificate.certificate import certify
from convexperc.certificate.data_bounds import Points
from convexperc.enclosure.enclosure import enclose
from convexperc.solution.batch import solve_many
from verification.bench.floor import timed
from verification.bench.instances import LAMBDAS, Instance, Lambdas

BITS = 128
"""Precision of the ball arithmetic that is timed."""


@dataclass(frozen=True)
class ProofTimes:
    """Median seconds on one template, for one choice of the lambdas.

    Attributes
    ----------
    lambdas : (float, float, float)
    certified : float
        `certify` on the original data, in float64.
    relative_width : float
        Of its interval.
    reduced : float
        All templates bounded from the reduced data, over their number.
    enclosed : float
        `enclose` in 128 bits from the solver's answer.
    enclosed_width : float
        Of its interval before it is rounded to float64.
    many : float
        All templates of the frame: Gram matrices, X O, answers, intervals.
    """

    lambdas: Lambdas
    certified: float
    relative_width: float
    reduced: float
    enclosed: float
    enclosed_width: float
    many: float


def proof_times(instance: Instance, repeat: int) -> list[ProofTimes]:
    """Time the proofs of an instance's first template; a first call of each is not counted."""
    found = []
    for lambdas in LAMBDAS:
        problem = instance.problem(0, lambdas)
        one, two, three = lambdas
        work = partial(
            solve_many, instance.X, instance.O, lambda1=one, lambda2=two, lambda3=three,
            modalities=instance.modalities,
        )  # fmt: skip
        answers = work()
        w, u = np.array(answers.w[0]), answers.u(0)
        proof, ball = certify(problem, w, u), enclose(problem, bits=BITS, start=(w, u))
        exact = ball.exact
        bound = partial(
            answers.bounds.of_points, np.arange(len(answers)), answers.data.normalised(answers.penalties),
            Points(answers.reduced.W, answers.reduced.T, answers.reduced.Q),
            AnswerBounds.unknown(len(answers), problem.n, problem.m), tolerances=answers.tolerances,
            uncoupled=False,
        )  # fmt: skip
        found.append(
            ProofTimes(
                lambdas,
                timed(partial(certify, problem, w, u), repeat),
                (proof.upper - proof.lower) / proof.upper,
                timed(bound, repeat) / len(answers),
                timed(partial(enclose, problem, bits=BITS, start=(w, u)), repeat),
                float((exact.upper - exact.lower) / exact.upper),
                timed(work, repeat),
            )
        )
    return found
