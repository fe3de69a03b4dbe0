"""Where arithmetic is not what the bounds assume, nothing is proved, and every answer says why."""

import json
import math
import os
import subprocess
import sys
import threading
from contextlib import ExitStack, suppress

import numpy as np
import pytest
from floating_point import FLUSH_OPERANDS, FLUSH_RESULTS, MXCSR, SETTINGS, environment, library
from typer.testing import CliRunner

from convexperc import (
    Problem,
    certify,
    enclose,
    lambda2_max,
    recognize,
    solve,
    solve_many,
    weight_intervals,
)
from convexperc.certificate import arithmetic
from convexperc.certificate.arithmetic import FLUSHING, ROUNDING, SCHEME, THREADS, broken_assumption
from convexperc.certificate.lambda_max import zero_is_optimal
from convexperc.cli.main import app
from convexperc.errors import ConvexpercError, InputError
from convexperc.problem.files import read_problem
from convexperc.recognition import Verdict
from convexperc.report import proof
from convexperc.report.proof import proof_record
from convexperc.solution.solution import Status
from convexperc.solvers.newton.method import Newton
from verification.proof_checker import check

SMALL = 1e-155
PROBLEM = Problem([[1.0]], [SMALL], lambda1=1.0, lambda2=0.0, lambda3=2 * SMALL)
"""F* = 5e-311, a subnormal number, by w = o / 2 and u = 0."""
LARGE = {"lambda1": 1.0, "lambda2": 0.1, "lambda3": 0.1}
O = np.array([[1.0, 0.2], [0.1, 1.0]])


def reason(name: str) -> str:
    return ROUNDING if "wards" in name or "zero" in name else FLUSHING


def says(text: str, name: str) -> bool:
    return text == f"nothing is proved: {reason(name)}"


def test_here_and_now_nothing_is_wrong() -> None:
    assert broken_assumption(arithmetic.MANY) == ""
    assert solve(PROBLEM).status is Status.CERTIFIED


@pytest.mark.parametrize("name", SETTINGS)
def test_each_setting_is_noticed_and_only_while_it_holds(name: str) -> None:
    broken_assumption()  # the threads of the BLAS, once
    with environment(name):
        assert says(broken_assumption(), name)
        with np.errstate(all="raise"):
            assert says(broken_assumption(), name)
    with np.errstate(all="raise"):
        assert broken_assumption() == ""


@pytest.mark.parametrize("name", SETTINGS)
def test_a_single_answer_proves_nothing_and_says_so(name: str) -> None:
    before = solve(PROBLEM)
    with environment(name):
        found, interval = solve(PROBLEM), enclose(PROBLEM)
        proof = certify(PROBLEM, before.w, before.u)
        weights = weight_intervals(found, interval)
        bounds, zero = lambda2_max(PROBLEM), zero_is_optimal(PROBLEM)
    for each in (proof, found.certificate):
        assert (each.lower, each.upper, each.gap) == (0.0, math.inf, math.inf)
        assert says(each.method, name)
        assert not (each.certified)
        assert not (each.enclosed)
        assert not (each.zero_views.any())
        assert not (each.zero_modalities.any())
    assert found.status is Status.NOT_CERTIFIED
    assert (interval.lower, interval.upper, interval.relative_width) == (0.0, math.inf, math.inf)
    assert says(interval.method, name)
    assert interval.exact.lower == 0 < SMALL**2 < interval.exact.upper
    assert not (weights.views.determined.any())
    assert not (weights.modalities.determined.any())
    assert says(weights.views.reason, name)
    assert (bounds, zero) == ((0.0, math.inf), False)


@pytest.mark.parametrize("name", SETTINGS)
def test_many_answers_and_a_label_prove_nothing_and_say_so(name: str) -> None:
    with environment(name):
        many = solve_many(np.eye(2), O, **LARGE)
        certified, enclosed = many.certified.copy(), many.enclosed.copy()
        found = recognize(np.eye(2), O, **LARGE)
        tie = recognize(np.eye(2), O, **(LARGE | {"lambda2": 1e9}))
    assert not (certified.any())
    assert not (enclosed.any())
    assert (many.lower == 0.0).all()
    assert (many.upper == math.inf).all()
    assert says(many.singles[0].certificate.method, name)
    for each in (found, tie):
        assert each.verdict is Verdict.UNDECIDED
        assert len(each.warnings) == 1
        assert says(each.warnings[0], name)
    assert solve_many(np.eye(2), O, **LARGE).certified.all()
    assert recognize(np.eye(2), O, **LARGE).warnings == ()


TINY = 1e-310


@pytest.mark.parametrize("name", SETTINGS)
def test_subnormal_numbers_are_taken_as_given_under_any_setting(name: str) -> None:
    """X = o = lambda1 = 1 and lambda3 = 0: F* = lambda2 - lambda2^2 / 4."""
    with environment(name):
        problem = Problem([[1.0]], [1.0], lambda1=1.0, lambda2=TINY, lambda3=0.0)
        other = Problem([[TINY]], [TINY], lambda1=np.array(TINY), lambda2=np.float64(TINY), lambda3=5e-324)
        with pytest.raises(InputError, match="lambda2 must be a finite real number >= 0"):
            Problem([[1.0]], [1.0], lambda1=1.0, lambda2=-TINY, lambda3=0.0)
    assert problem.lambda2 == TINY > 0.0
    assert (other.X[0, 0], other.o[0], *other.lambdas) == (TINY, TINY, TINY, TINY, 5e-324)
    for found in (solve(problem).certificate, enclose(problem)):
        assert found.lower <= TINY <= found.upper
        assert found.upper > 0.0


@pytest.mark.parametrize("name", SETTINGS)
def test_numbers_that_a_setting_changes_on_their_way_are_refused(name: str, tmp_path) -> None:
    small, file = np.float32([1e-40]), tmp_path / "problem.json"
    record = {"X": [[TINY]], "o": [TINY.hex()], "lambda1": 1.0, "lambda2": 0.0, "lambda3": 1.0}
    file.write_text(json.dumps(record), encoding="utf-8")
    with environment(name):
        taken = []
        for read in (
            lambda: Problem([[1.0]], small, **LARGE).o[0],
            lambda: Problem([[1.0]], [1.0], **(LARGE | {"lambda2": small[0]})).lambda2,
            lambda: read_problem(file).problem.X[0, 0],
            lambda: read_problem(file).problem.o[0],
        ):
            with suppress(InputError):
                taken.append(read())
    assert {float(value) for value in taken} <= {float(small[0]), TINY}, taken
    assert len(taken) == 4 or reason(name) == FLUSHING, taken


def test_no_proof_file_is_written_and_a_spoilt_one_is_rejected(monkeypatch: pytest.MonkeyPatch) -> None:
    answer = solve(PROBLEM)
    with environment("both, as -ffast-math does"):
        with pytest.raises(ConvexpercError, match="must round to nearest and keep subnormal numbers"):
            proof_record(answer)
        monkeypatch.setattr(proof, "broken_assumption", lambda: "")
        spoilt = json.dumps(proof_record(answer))
        refused = check(spoilt)
    assert not refused.proved
    assert refused == check(spoilt), "the checker computes in integers, under any setting"
    assert check(json.dumps(proof_record(answer))).proved


def test_a_setting_that_comes_with_the_solver_is_noticed_before_the_proof() -> None:
    class Fast:
        name = "built with -ffast-math"

        def solve(self, problem):
            stack.enter_context(environment("both, as -ffast-math does"))
            return Newton().solve(problem)

    with ExitStack() as stack:
        found = solve(PROBLEM, Fast(), escalate=True)
    assert says(found.certificate.method, "both, as -ffast-math does")


def test_another_thread_keeps_its_own_arithmetic() -> None:
    seen: list[str] = []
    with environment("results flushed"):
        thread = threading.Thread(target=lambda: seen.append(broken_assumption()))
        thread.start()  # a thread begins with the setting of the one that starts it
        thread.join()
    thread = threading.Thread(target=lambda: seen.append(broken_assumption()))
    thread.start()
    thread.join()
    assert says(seen[0], "results flushed")
    assert seen[1] == ""


def test_the_blas_is_looked_at_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    with environment("results flushed"):
        assert not arithmetic._products_are_sound.__wrapped__()
    with environment("upwards"):
        assert not arithmetic._products_are_sound.__wrapped__()
    assert arithmetic._products_are_sound.__wrapped__()
    monkeypatch.setattr(arithmetic, "_products_are_sound", lambda: False)
    assert broken_assumption() == f"nothing is proved: {THREADS}"
    assert certify(PROBLEM, [0.0], [0.0]).method == f"nothing is proved: {THREADS}"


BEFORE_NUMPY = """
import ctypes
libm, before = ctypes.CDLL("libm.so.6"), (ctypes.c_ubyte * 64)()
libm.fegetenv(before)
changed = (ctypes.c_ubyte * 64)(*before)
ctypes.c_uint32.from_buffer(changed, {register}).value |= {bits}
libm.fesetenv(changed)
import numpy as np
np.ones((300, 300)) @ np.ones((300, 300))
libm.fesetenv(before)
from convexperc.certificate.arithmetic import broken_assumption
print(broken_assumption())
"""


@pytest.mark.skipif((os.cpu_count() or 1) < 2, reason="on one core the BLAS has no thread of its own")
def test_threads_of_the_blas_that_began_with_another_setting_are_noticed() -> None:
    """The thread that proves has put its own right again."""
    library()
    program = BEFORE_NUMPY.format(register=MXCSR, bits=FLUSH_RESULTS | FLUSH_OPERANDS)
    for threads, said in (("2", f"nothing is proved: {THREADS}"), ("1", "")):
        done = subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"OPENBLAS_NUM_THREADS": threads},
            capture_output=True,
            text=True,
            check=True,
        )
        assert done.stdout.strip() == said, (threads, done.stderr)


def strassen(A: np.ndarray, B: np.ndarray) -> np.ndarray:
    """One step of Strassen's scheme."""
    k = len(A) // 2
    a, b, c, d = A[:k, :k], A[:k, k:], A[k:, :k], A[k:, k:]
    e, f, g, h = B[:k, :k], B[:k, k:], B[k:, :k], B[k:, k:]
    first, last = (a + d) @ (e + h), d @ (g - e)
    others = (c + d) @ e, a @ (f - h), (a + b) @ h
    corners = (c - a) @ (e + f), (b - d) @ (g + h)
    return np.block([
        [first + last - others[2] + corners[1], others[1] + others[2]],
        [others[0] + last, first - others[0] + others[1] + corners[0]],
    ])  # fmt: skip


def test_a_scheme_like_strassens_is_noticed_where_matrices_are_large(monkeypatch: pytest.MonkeyPatch) -> None:
    assert arithmetic._blas_is_classical.__wrapped__()
    A = np.random.default_rng(0).random((4, 4))
    assert np.allclose(strassen(A, A), A @ A)
    monkeypatch.setattr(arithmetic.np, "matmul", strassen)
    assert not arithmetic._blas_is_classical.__wrapped__()
    monkeypatch.setattr(
        arithmetic.np, "matmul", lambda A, B: strassen(A, B) if np.shares_memory(A, B) else A @ B
    )
    assert not arithmetic._blas_is_classical.__wrapped__(), "a matrix and its own transpose"
    monkeypatch.setattr(arithmetic, "_blas_is_classical", lambda: False)
    assert broken_assumption() == ""
    assert broken_assumption(arithmetic.MANY) == f"nothing is proved: {SCHEME}"


def test_the_command_says_so_and_exits_with_not_certified(tmp_path) -> None:
    problem = {"X": [[1.0]], "o": [SMALL], "lambda1": 1.0, "lambda2": 0.0, "lambda3": 2 * SMALL}
    (tmp_path / "problem.json").write_text(json.dumps(problem), encoding="utf-8")
    arguments = ["solve", str(tmp_path / "problem.json")]
    assert CliRunner().invoke(app, arguments).exit_code == 0
    with environment("both, as -ffast-math does"):
        done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 1, done.output
    assert FLUSHING in " ".join(done.output.split()), done.output
