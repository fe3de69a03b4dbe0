"""C code that CVXPYgen generates, as a program that the kit can ask.

``python -m verification.conformance.generated --backend qoco`` reads requests and writes answers, one a line.
For each shape (n and the sizes of the modalities) CVXPYgen writes C for one of its solvers, with X, o and the
lambdas as parameters; its example program is replaced by one that reads their values, and CMake builds it by
the files that come with the code. What has been built is kept in a folder, so that a shape is compiled once.

Generated code keeps its solver from one call to the next. ``--state`` says what came before a request:
nothing ("fresh"), another problem of the same shape, always the same ("primed"), or the requests before it
("kept", as on a robot). The answers of the first two depend on the request alone, so that a failure can be
asked for again; a request that fails primed and not fresh shows that something of the last call was left.
"""

import argparse
import fcntl
import shutil
import subprocess
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from hashlib import sha256
from itertools import accumulate, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from convexperc.problem.problem import Problem
from verification.conformance.serve import serve, strictly

LARGEST = 6
"""Largest n d that is generated: a shape takes seconds to compile."""

STATES = ("fresh", "primed", "kept")


@dataclass(frozen=True)
class Backend:
    """A solver that CVXPYgen writes code for.

    Attributes
    ----------
    solver : str
        CVXPYgen's name.
    solved : frozenset of str
        What it says where it solved the problem, perhaps to less than its tolerance; CVXPY returns these too.
    settings : mapping of str to float
        Set before each call; what is not named is as CVXPYgen sets it.
    quadratic : bool
        Whether it solves quadratic programs alone.
    defaults : bool
        Whether ``cpg_set_solver_default_settings`` is called first, as CVXPYgen's Python module does, and its
        example program in C does not.
    """

    solver: str
    solved: frozenset[str]
    settings: Mapping[str, float] = field(default_factory=dict)
    quadratic: bool = False
    defaults: bool = True


TEXTS = frozenset(("solved", "solved inaccurate", "solved (inaccurate - reached max_iters)"))
BACKENDS = {
    "ecos": Backend("ECOS", frozenset(("0", "10"))),
    "qoco": Backend("QOCO", frozenset(("1", "2"))),
    "qocogen": Backend("QOCOGEN", frozenset(("1", "2"))),
    "qocogen_example": Backend("QOCOGEN", frozenset(("1", "2")), defaults=False),
    "scs": Backend("SCS", TEXTS),
    "scs_tight": Backend("SCS", TEXTS, {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iters": 200_000}),
    "osqp": Backend("OSQP", TEXTS, quadratic=True),
    "osqp_tight": Backend(
        "OSQP", TEXTS, {"eps_abs": 1e-10, "eps_rel": 1e-10, "max_iter": 200_000}, quadratic=True
    ),
}
"""ECOS and QOCO give their status as a number. Clarabel's code needs Rust, and is left out."""


@dataclass(frozen=True)
class Shape:
    """What code is generated for.

    Attributes
    ----------
    n : int
    sizes : tuple of int
        Columns of each modality.
    norms : bool
        Whether the objective has the norms of the modalities; without, lambda3 must be 0.
    """

    n: int
    sizes: tuple[int, ...]
    norms: bool

    @property
    def d(self) -> int:
        """Number of features."""
        return sum(self.sizes)


def model(shape: Shape) -> Any:
    """The problem with X, o and the lambdas as parameters, by the rules of CVXPY (DPP).

    lambda1 ||Xu - w||^2 would multiply two parameters; an unknown r = Xu - w takes the place of one factor.
    """
    import cvxpy as cp  # noqa: PLC0415

    rng = np.random.default_rng(0)
    X = cp.Parameter((shape.n, shape.d), name="X", value=rng.standard_normal((shape.n, shape.d)))
    o = cp.Parameter(shape.d, name="o", value=rng.standard_normal(shape.d))
    one, two, three = (cp.Parameter(nonneg=True, name=f"lambda{k}", value=1.0) for k in (1, 2, 3))
    w, u, r = (
        cp.Variable(size, name=name) for name, size in (("w", shape.n), ("u", shape.d), ("r", shape.n))
    )
    F = cp.sum_squares(X.T @ w - o) + one * cp.sum_squares(r) + two * cp.norm1(w)
    if shape.norms:
        ends = pairwise(accumulate(shape.sizes, initial=0))
        F += three * sum(cp.norm1(u[a:b]) if b == a + 1 else cp.norm2(u[a:b]) for a, b in ends)
    return cp.Problem(cp.Minimize(F), [r == X @ u - w])


MAIN = """\
#include <stdio.h>
#include "cpg_workspace.h"
#include "cpg_solve.h"

int main(void) {{
    static double given[{count}];
    {defaults}
    while (fread(given, sizeof(double), {count}, stdin) == {count}) {{
        {updates}
        {settings}
        cpg_solve();
        printf("answer\\t{status}\\t%.17g", CPG_Result.info->status, (double)CPG_Result.info->obj_val);
        for (int k = 0; k < {n}; k++) printf("\\t%.17g", (double)({w})[k]);
        for (int k = 0; k < {d}; k++) printf("\\t%.17g", (double)({u})[k]);
        printf("\\n");
        fflush(stdout);
    }}
    return 0;
}}
"""


def main_program(backend: Backend, shape: Shape) -> str:
    """C that reads lambda1 .. lambda3, X column by column and o, calls the generated code, and writes a line.

    CVXPYgen has scalars where an array would have one entry.
    """
    n, d = shape.n, shape.d
    names = ("lambda1", "lambda2", "lambda3") if shape.norms else ("lambda1", "lambda2")
    lines = [f"cpg_update_{name}(given[{int(name[-1]) - 1}]);" for name in names]
    for name, start, size in (("X", 3, n * d), ("o", 3 + n * d, d)):
        loop = f"for (int k = 0; k < {size}; k++) cpg_update_{name}(k, given[{start} + k]);"
        lines.append(f"cpg_update_{name}(given[{start}]);" if size == 1 else loop)
    settings = (f"cpg_set_solver_{name}({value!r});" for name, value in backend.settings.items())
    read = {name: f"{'&' * (size == 1)}CPG_Result.prim->{name}" for name, size in (("w", n), ("u", d))}
    status = "%d" if backend.solved is not TEXTS else "%s"
    indent = "\n        "
    return MAIN.format(
        defaults="cpg_set_solver_default_settings();" * backend.defaults, count=3 + n * d + d,
        updates=indent.join(lines), settings=indent.join(settings), status=status, n=n, d=d, **read,
    )  # fmt: skip


class Builder:
    """Generates and compiles; each shape once.

    Parameters
    ----------
    backend : Backend
    folder : Path
        Keeps what was built. One tree of sources serves all shapes: files are replaced only where they
        differ, so that the parts of a solver that are the same for all are compiled once.
    """

    def __init__(self, backend: Backend, folder: Path) -> None:
        self.backend, self.folder = backend, folder

    def program(self, shape: Shape) -> Path:
        """The program for a shape."""
        name = repr((self.backend.solver, shape, main_program(self.backend, shape)))
        built = self.folder / f"{self.backend.solver.lower()}-{sha256(name.encode()).hexdigest()[:16]}"
        if not built.exists():
            with (self.folder / "lock").open("w") as lock:
                fcntl.flock(lock, fcntl.LOCK_EX)  # the tree of sources is for one process at a time
                self._build(shape, built)
        return built

    def _build(self, shape: Shape, target: Path) -> None:
        from cvxpygen import cpg  # noqa: PLC0415 - optional

        tree = self.folder / f"{self.backend.solver.lower()}-sources"
        with tempfile.TemporaryDirectory() as room:
            code = Path(room) / "code"
            cpg.generate_code(model(shape), code_dir=str(code), solver=self.backend.solver, wrapper=False)
            (code / "c" / "src" / "cpg_example.c").write_text(main_program(self.backend, shape))
            _replace(code / "c", tree.with_suffix(".generated"), tree)
        build = tree.with_suffix(".build")
        _quietly(["cmake", "-S", str(tree), "-B", str(build), "-DCMAKE_BUILD_TYPE=Release"])
        _quietly(["cmake", "--build", str(build), "--target", "cpg_example"])
        made = next(each for each in build.rglob("cpg_example") if each.is_file())
        shutil.copy2(made, target.with_suffix(".new"))
        target.with_suffix(".new").rename(target)


def _replace(source: Path, last: Path, target: Path) -> None:
    """Copy what was generated otherwise than the last time; the rest keeps its time, and is not compiled.

    Files of the target cannot be compared themselves: CMake writes into some.
    """
    for each in source.rglob("*"):
        name = each.relative_to(source)
        known = last / name
        if each.is_file() and not (known.exists() and known.read_bytes() == each.read_bytes()):
            for place in (target / name, known):
                place.parent.mkdir(parents=True, exist_ok=True)
                shutil.copyfile(each, place)


def _quietly(words: list[str]) -> None:
    done = subprocess.run(words, capture_output=True, check=False)
    if done.returncode:
        end = (done.stdout + done.stderr).decode("utf-8", "replace")[-400:]
        raise RuntimeError(f"{' '.join(words[:2])} ended with exit code {done.returncode}: {end}")


class Generated:
    """A solver of generated code, called as the kit calls a function.

    Parameters
    ----------
    backend : Backend
    state : str
        One of `STATES`.
    largest : int
        Largest n d.
    folder : Path
        Keeps what was built.
    """

    def __init__(self, backend: Backend, state: str, largest: int, folder: Path) -> None:
        self.backend, self.state, self.largest = backend, state, largest
        self.builder = Builder(backend, folder)
        self._running: dict[Shape, subprocess.Popen[bytes]] = {}

    def __call__(self, X: Any, o: Any, modalities: Sequence[int], **weights: float) -> dict[str, Any]:
        """Solve one problem; raise `NotImplementedError` for what no code is generated for."""
        problem = Problem(X, o, modalities=list(modalities), **weights)
        sizes = tuple(map(int, problem.modalities.sizes))
        if problem.n * problem.d > self.largest:
            raise NotImplementedError(f"code is generated for n d <= {self.largest}")
        norms = not self.backend.quadratic or all(size == 1 for size in sizes)
        if not norms and problem.lambda3:
            raise NotImplementedError("a quadratic program: modalities of one column, or lambda3 = 0")
        shape = Shape(problem.n, sizes, norms)
        given = np.concatenate([problem.lambdas, problem.X.ravel(order="F"), problem.o])
        return self._answer(shape, given)

    def _answer(self, shape: Shape, given: Any) -> dict[str, Any]:
        process = self._running.pop(shape, None) or self._started(shape)
        if self.state == "primed":
            _ask(process, np.random.default_rng(1).uniform(0.5, 1.5, given.size))
        status, objective, *point = _ask(process, given)
        if self.state == "kept":
            self._running[shape] = process
        else:
            process.communicate()
        if status not in self.backend.solved:
            raise ArithmeticError(f"status {status}")
        found = np.array([float(each) for each in point])
        return {"w": found[: shape.n], "u": found[shape.n :], "objective": float(objective)}

    def _started(self, shape: Shape) -> "subprocess.Popen[bytes]":
        pipe = subprocess.PIPE
        return subprocess.Popen([str(self.builder.program(shape))], stdin=pipe, stdout=pipe)


def _ask(process: "subprocess.Popen[bytes]", given: Any) -> list[str]:
    """Write the numbers, and read the fields of the line that answers; other lines are the solver's own."""
    if process.stdin is None or process.stdout is None:
        raise TypeError("the program was started without pipes")
    process.stdin.write(given.tobytes())
    process.stdin.flush()
    for line in process.stdout:
        mark, *fields = line.decode("utf-8", "replace").rstrip("\n").split("\t")
        if mark == "answer":
            return fields
    raise ChildProcessError(f"the generated program ended with {process.wait()}")


def main() -> None:
    """Answer every line of standard input until it ends."""
    parser = argparse.ArgumentParser(prog="python -m verification.conformance.generated")
    parser.add_argument("--backend", choices=BACKENDS, required=True)
    parser.add_argument("--state", choices=STATES, default="kept", help="what was solved before a request")
    parser.add_argument("--largest", type=int, default=LARGEST, help="largest n d; larger ones are declined")
    parser.add_argument("--folder", type=Path, help="keeps what was built; a temporary one where left out")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as room:
        folder = (given.folder or Path(room)).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        serve(Generated(BACKENDS[given.backend], given.state, given.largest, folder), strictly)


if __name__ == "__main__":
    main()
