"""Proof files as written: accepted by the independent checker, narrow, and true by the exact oracles."""

import json
import re
import time
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from typer.testing import CliRunner

from convexperc.cli.main import app
from convexperc.errors import ProblemError
from convexperc.files import write_json
from convexperc.problem.files import problem_record, read_problem
from convexperc.problem.problem import Problem
from convexperc.report.proof import data_digest, proof_record
from convexperc.solution.single import solve
from convexperc.solution.solution import Status
from convexperc.solvers.conic import Conic
from convexperc.solvers.interface import SolverResult
from verification.exact.formulation import dual_objective, is_dual_feasible, objective
from verification.problems.families import FAMILIES, seeded
from verification.proof_checker import check

SUBNORMAL = Fraction(5e-324)
"""Rounding outward costs so much where F* is below the normal floats."""


def number(text):
    """A hex float of any length as a rational."""
    sign, digits, places, shift = re.fullmatch(r"(-?)0x(\w+?)(?:\.(\w+))?p([+-]\d+)", text).groups()
    value = int(digits + (places or ""), 16) * Fraction(2) ** (int(shift) - 4 * len(places or ""))
    return -value if sign else value


def rationals(texts):
    values = np.empty(len(texts), dtype=object)
    values[:] = [number(text) for text in texts]
    return values


def accepted(record):
    """The exact bounds of a record that the checker accepts."""
    verdict = check(json.dumps(record))
    assert verdict.proved, verdict
    assert verdict.sha256 == record["sha256"], verdict
    return Fraction(float.fromhex(record["claim"]["lower"])), Fraction(
        float.fromhex(record["claim"]["upper"])
    )


def narrow(problem, lower, upper):
    target = sum(Fraction(float(v)) ** 2 for v in problem.o)
    room = max(Fraction(1e-8) * upper, Fraction(1e-14) * target, SUBNORMAL)
    return upper - lower <= room


def proved(problem):
    """Solve, write, check; the width is that of a certified answer."""
    solution = solve(problem, Conic(), escalate=True)
    assert solution.status in (Status.CERTIFIED, Status.ENCLOSED), solution.certificate
    record = proof_record(solution)
    lower, upper = accepted(record)
    assert narrow(problem, lower, upper), (float(lower), float(upper))
    assert lower <= Fraction(solution.certificate.upper), (float(lower), solution.certificate)
    assert Fraction(solution.certificate.lower) <= upper, (float(upper), solution.certificate)
    return record, lower, upper


@pytest.mark.parametrize("family", FAMILIES)
def test_every_family_is_proved_and_the_oracles_agree(family):
    problem = seeded(family, 8, 1, largest=(5, 14))
    record, lower, upper = proved(problem)
    a, b = rationals(record["dual"]["a"]), rationals(record["dual"]["b"])
    w, u = rationals(record["primal"]["w"]), rationals(record["primal"]["u"])
    assert is_dual_feasible(problem, a, b)
    assert lower <= dual_objective(problem, a, b)
    assert objective(problem, w, u).lower <= upper


@pytest.mark.parametrize("lambdas", list(product([0.0, 0.3], repeat=3)))
@pytest.mark.parametrize("deficient", [False, True])
def test_every_lambda_may_be_zero(lambdas, deficient):
    rng = np.random.default_rng(5)
    X, o = np.round(rng.normal(size=(4, 9)) * 2**20) / 2**20, rng.normal(size=9)
    if deficient:
        X[2], X[3] = X[0] + X[1], X[0] - 2 * X[1]
    one, two, three = lambdas
    proved(Problem(X, o, modalities={"p": [0, 3, 8], "q": [7, 1, 2], "r": [4, 6, 5]}, lambda1=one,
                   lambda2=two, lambda3=three))  # fmt: skip


@pytest.mark.parametrize("decades", [-100, -30, 30, 100])
@pytest.mark.parametrize("lambdas", [(0.1, 0.1, 0.1), (0.1, 0.1, 0.0), (0.1, 0.0, 0.1), (0.0, 0.0, 0.1)])
def test_scales(decades, lambdas):
    rng = np.random.default_rng(6)
    t, (one, two, three) = 10.0**decades, lambdas
    X, o = rng.normal(size=(3, 7)), rng.normal(size=7) * t
    proved(Problem(X, o, modalities=[3, 4], lambda1=one, lambda2=two * t, lambda3=three * t))
    proved(Problem(X * t, o, modalities=[3, 4], lambda1=one, lambda2=two, lambda3=three))


CLOSED_FORMS = {
    "19/32": (Problem([[1.0]], [1.0], lambda1=1, lambda2=0.5, lambda3=0.25), Fraction(19, 32)),
    "3/8": (Problem([[1, 0], [3, 1]], [1, 0], lambda1=1, lambda2=1, lambda3=0), Fraction(3, 8)),
    "135/476": (
        Problem([[1, 3], [0, 1]], [1, 3], lambda1=1, lambda2=0, lambda3=1, modalities=[1, 1]),
        Fraction(135, 476),
    ),
    "least squares": (Problem([[1, 0], [1, 0]], [3, 2], lambda1=1, lambda2=0, lambda3=0), Fraction(4)),
    "more views than features": (
        Problem([[1], [1], [2]], [3], lambda1=0, lambda2=0, lambda3=1),
        Fraction(0),
    ),
    "o = 0": (Problem([[1, 2]], [0, 0], lambda1=1, lambda2=1, lambda3=1), Fraction(0)),
    "X = 0": (Problem([[0, 0]], [1, 2], lambda1=1, lambda2=0, lambda3=0), Fraction(5)),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_the_claim_holds_the_closed_form(name):
    problem, value = CLOSED_FORMS[name]
    _, lower, upper = proved(problem)
    assert lower <= value <= upper, (float(lower), float(upper))


@pytest.mark.parametrize("lambda2", [0.1, 1e-14])
def test_the_size_of_the_paper_is_practical(lambda2):
    rng = np.random.default_rng(0)
    X = rng.random((6, 2558)) / 30
    o = 0.7 * X[0] + 0.3 * X[3] + 1e-4 * rng.random(2558)
    problem = Problem(X, o, modalities=[768, 1764, 26], lambda1=0.1, lambda2=lambda2, lambda3=1e-3)
    solution = solve(problem, Conic())
    start = time.perf_counter()
    record = proof_record(solution)
    written = time.perf_counter()
    lower, upper = accepted(record)
    assert written - start < 3, written - start
    assert time.perf_counter() - written < 5
    assert narrow(problem, lower, upper), (float(lower), float(upper))


class Poor:
    """Answers w = u = 0, whatever it is asked."""

    name = "poor"

    def solve(self, problem):
        return SolverResult(np.zeros(problem.n), np.zeros(problem.d), "optimal", 1)


def test_a_wide_certificate_gives_a_wide_and_valid_proof():
    rng = np.random.default_rng(1)
    problem = Problem(rng.normal(size=(3, 8)), rng.normal(size=8), lambda1=1, lambda2=0.1, lambda3=0.1)
    solution = solve(problem, Poor())
    assert solution.status is Status.NOT_CERTIFIED, solution.certificate
    lower, upper = accepted(proof_record(solution))
    assert upper - lower <= Fraction(solution.certificate.upper) - Fraction(solution.certificate.lower)
    _, low, high = proved(problem)
    assert lower <= low <= high <= upper


def test_an_optimum_that_no_float_point_attains_is_proved():
    X = np.array([[1.0, 0.1], [1.0, 0.1 * (1 + 2**-52)]])
    problem = Problem(X, [1.0, 3.0], lambda1=1, lambda2=0, lambda3=0)
    assert solve(problem, Poor(), escalate=True).status is Status.ENCLOSED
    _, lower, upper = proved(problem)
    assert lower == 0, float(lower)
    assert upper <= 1e-50, float(upper)


def test_an_optimum_beyond_float64_is_refused():
    problem = Problem([[1.0, 0.0]], [0.0, 1e200], lambda1=1, lambda2=1, lambda3=1)
    with pytest.raises(ProblemError, match=r"must have an optimum below 1\.8e308"):
        proof_record(solve(problem, Poor()))


def test_the_digest_tells_partitions_apart_and_signs_of_zero():
    same = {"lambda1": 1, "lambda2": 1, "lambda3": 1}
    X, o = [[1.0, 0.0, 2.0]], [1.0, 1.0, 1.0]
    digests = [
        data_digest(Problem(X, o, modalities=sizes, **same))
        for sizes in ([3], [1, 2], [2, 1], {"p": [0, 2], "q": [1]}, {"p": [0], "q": [2, 1]})
    ]
    digests.append(data_digest(Problem([[1.0, -0.0, 2.0]], o, **same)))
    assert len(set(digests)) == len(digests), digests
    assert data_digest(Problem(X, o, modalities={"other": 3}, **same)) == digests[0]


def test_the_command_writes_a_proof_that_holds_its_problem_file(tmp_path):
    rng = np.random.default_rng(7)
    problem = Problem(
        rng.normal(size=(3, 6)), rng.normal(size=6), modalities=[2, 4], lambda1=1, lambda2=0.1, lambda3=0.1
    )
    asked, out, inner = tmp_path / "problem.json", tmp_path / "proof.json", tmp_path / "inner.json"
    write_json(asked, problem_record(problem, "case 1"))
    result = CliRunner().invoke(app, ["solve", str(asked), "--proof", str(out)])
    assert result.exit_code == 0, result.output
    assert result.stderr.split() == ["wrote", str(out)], result.stderr
    verdict = check(out)
    assert verdict.proved, verdict
    assert verdict.sha256 == data_digest(problem), verdict
    inner.write_text(json.dumps(json.loads(out.read_text())["problem"]), encoding="utf-8")
    assert data_digest(read_problem(inner).problem) == verdict.sha256
    result = CliRunner().invoke(app, ["solve", str(asked), "--proof", str(tmp_path / "none" / "proof.json")])
    assert result.exit_code == 2, result.output
