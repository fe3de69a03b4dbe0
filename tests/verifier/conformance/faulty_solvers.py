"""Sound and faulty solvers: a plain gradient method with places for faults, and faults around the library."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from convexperc import Problem, solve
from verification.exact.formulation import objective

Prox = Callable[[Any, float], Any]


def shrunk(v: Any, by: float) -> Any:
    norm = np.linalg.norm(v)
    return v * max(0.0, 1.0 - by / norm) if norm > 0.0 else v


def soft(v: Any, by: float) -> Any:
    return np.sign(v) * np.maximum(np.abs(v) - by, 0.0)


def still(new: Any, old: Any) -> bool:
    """Whether no entry moved by more than 1e-15 of itself: what `np.allclose` says, sooner."""
    return bool((np.abs(new - old) <= 1e-15 * np.abs(old)).all())


def gradient(
    X: Any,
    o: Any,
    sizes: Sequence[int],
    lambda1: float,
    lambda2: float,
    lambda3: float,
    *,
    loss: float = 1.0,
    prox_w: Prox = soft,
    prox_u: Prox = shrunk,
    weights: Callable[[int], float] = lambda size: 1.0,
    sees: Callable[[Any], Any] = lambda w: w,
    iterations: int = 5_000,
    kind: Any = np.float64,
) -> tuple[Any, Any]:
    """Accelerated proximal gradient steps with restarts; `sees` is what the coupling sees of w."""
    X, o = X.astype(kind), o.astype(kind)
    size = float((X.astype(np.float64) ** 2).sum())
    step_w, step_u = kind(2 * loss * size + 4 * lambda1), kind(4 * lambda1 * size)
    stops = np.cumsum(sizes)
    w, u = np.zeros(len(X), kind), np.zeros(X.shape[1], kind)
    y, z, t = w, u, 1.0
    for _ in range(iterations):
        p, q = X.T @ y - o, X @ z - sees(y)
        g_w = kind(2 * loss) * (X @ p) - kind(2 * lambda1) * q
        g_u = kind(2 * lambda1) * (X.T @ q)
        w_new = prox_w(y - g_w / step_w, kind(lambda2) / step_w) if step_w > 0 else y
        u_new = z
        if step_u > 0:
            blocks = np.split(z - g_u / step_u, stops[:-1])
            u_new = np.concatenate([prox_u(v, kind(lambda3 * weights(v.size)) / step_u) for v in blocks])
        turn = step_w * ((y - w_new) @ (w_new - w)) + step_u * ((z - u_new) @ (u_new - u))
        t_new = 1.0 if turn > 0 else (1 + np.sqrt(1 + 4 * t * t)) / 2
        move = kind(0.0 if turn > 0 else (t - 1) / t_new)
        y, z = w_new + move * (w_new - w), u_new + move * (u_new - u)
        done = still(w_new, w) and still(u_new, u)
        w, u, t = w_new, u_new, t_new
        if done and not turn > 0:
            break
    return w, u


def method(**faults: Any) -> Callable[..., Any]:
    def faulty(X: Any, o: Any, modalities: Any, *, lambda1: float, lambda2: float, lambda3: float) -> Any:
        Problem(X, o, modalities=list(modalities), lambda1=lambda1, lambda2=lambda2, lambda3=lambda3)
        return gradient(X, o, modalities, lambda1, lambda2, lambda3, **faults)

    return faulty


def library(X: Any, o: Any, modalities: Any, **weights: float) -> dict[str, Any]:
    answer = solve(Problem(X, o, modalities=list(modalities), **weights))
    return {"w": np.array(answer.w), "u": np.array(answer.u), "objective": answer.value}


def asked_otherwise(**factors: float) -> Callable[..., Any]:
    """The library, asked with other lambdas; it reports no objective."""

    def faulty(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        Problem(X, o, modalities=list(modalities), **weights)
        found = library(X, o, modalities, **{name: factors.get(name, 1.0) * x for name, x in weights.items()})
        return found["w"], found["u"]

    return faulty


def other_modalities(change: Callable[[list[int]], list[int]]) -> Callable[..., Any]:
    def faulty(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        Problem(X, o, modalities=list(modalities), **weights)
        found = library(X, o, change(list(modalities)), **weights)
        return found["w"], found["u"]

    return faulty


def off_by_one(sizes: list[int]) -> list[int]:
    return (
        sizes
        if len(sizes) < 2
        else [sizes[0] + 1, *sizes[1:-1], sizes[-1] - 1]
        if sizes[-1] > 1
        else [sum(sizes)]
    )


def changed(change: Callable[[dict[str, Any], Problem], dict[str, Any]]) -> Callable[..., Any]:
    """The library's answer, changed on its way out."""

    def faulty(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        problem = Problem(X, o, modalities=list(modalities), **weights)
        return change(library(X, o, modalities, **weights), problem)

    return faulty


def value(found: dict[str, Any], problem: Problem) -> float:
    return float(objective(problem, found["w"], found["u"]).upper)


def single(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
    """The data rounded to float32 on their way in, the point on its way out."""
    found = library(*(np.asarray(x, np.float32).astype(np.float64) for x in (X, o)), modalities, **weights)
    return found["w"].astype(np.float32), found["u"].astype(np.float32)


def cached() -> Callable[..., Any]:
    """Answers for the same X are taken from a cache that forgets o."""
    seen: dict[bytes, Any] = {}

    def faulty(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
        key = X.tobytes()
        if key not in seen:
            seen[key] = library(X, o, modalities, **weights)
        return seen[key]

    return faulty


def unchecked(X: Any, o: Any, modalities: Any, **weights: float) -> Any:
    """Answers whatever it is asked."""
    return (
        {"w": np.zeros(len(X)), "u": np.zeros(len(o))}
        if not _fits(X, o, modalities, weights)
        else library(X, o, modalities, **weights)
    )


def _fits(X: Any, o: Any, modalities: Any, weights: dict[str, float]) -> bool:
    try:
        Problem(X, o, modalities=list(modalities), **weights)
    except Exception:
        return False
    return True


def traced(shape: Callable[[float], list[float]]) -> Callable[..., Any]:
    """The library's answer with a made-up trace around F."""
    return changed(lambda found, problem: found | {"trace": shape(value(found, problem))})


def clipped(found: dict[str, Any], problem: Problem) -> dict[str, Any]:
    return {"w": np.maximum(found["w"], 0.0), "u": found["u"]}


def noisy_zeros(found: dict[str, Any], problem: Problem) -> dict[str, Any]:
    w = found["w"].copy()
    w[w == 0.0] = 0.01 * max(1e-3, np.abs(w).max())
    return {"w": w, "u": found["u"]}


def rounded(found: dict[str, Any], problem: Problem) -> dict[str, Any]:
    return {"w": np.round(found["w"], 4), "u": np.round(found["u"], 4)}


def two_at_once(found: dict[str, Any], problem: Problem) -> dict[str, Any]:
    return found | {"objective": 0.5 * found["objective"]}


NUMERIC: dict[str, tuple[str, Callable[..., Any]]] = {
    "half lambda2": ("L1", asked_otherwise(lambda2=0.5)),
    "half lambda3": ("L1", asked_otherwise(lambda3=0.5)),
    "twice lambda1": ("L1", asked_otherwise(lambda1=2.0)),
    "lambda1 left out": ("L1", asked_otherwise(lambda1=0.0)),
    "lambda2 slightly off": ("L2", asked_otherwise(lambda2=1.0 + 1e-3)),
    "modality off by one": ("L1", other_modalities(off_by_one)),
    "one modality for all": ("L1", other_modalities(lambda sizes: [sum(sizes)])),
    "every column a modality": ("L1", other_modalities(lambda sizes: [1] * sum(sizes))),
    "sqrt of the sizes as weights": ("L1", method(weights=np.sqrt)),
    "squared norm": ("L1", method(prox_u=lambda v, by: v / (1.0 + 2.0 * by))),
    "squared weights of views": ("L1", method(prox_w=lambda v, by: v / (1.0 + 2.0 * by))),
    "mean for sum in the loss": ("L1", method(loss=1.0 / 7.0)),
    "sign of the coupling": ("L1", changed(lambda found, problem: found | {"u": -found["u"]})),
    "the coupling forgets w": ("L1", method(sees=lambda w: 0.0 * w)),
    "missing |w|": ("L1", method(prox_w=lambda v, by: v - by)),
    "absolute values of u for norms": ("L1", method(prox_u=soft)),
    "non-negative w": ("L1", method(prox_w=lambda v, by: np.maximum(v - by, 0.0))),
    "early stop": ("L1", method(iterations=20)),
    "float32 inside": ("L1", single),
    "w clipped": ("L1", changed(clipped)),
    "four decimals": ("L2", changed(rounded)),
    "zeros filled": ("L1", changed(noisy_zeros)),
    "status trusted": ("L1", changed(lambda found, problem: {"w": 0 * found["w"], "u": 0 * found["u"]})),
    "u stale by one request": ("L1", changed(lambda found, problem: found | {"u": 0.5 * found["u"]})),
    "objective without lambda3": (
        "L1",
        changed(
            lambda found, problem: (
                found
                | {
                    "objective": found["objective"]
                    - problem.lambda3 * sum(np.linalg.norm(found["u"][c]) for c in problem.modalities)
                }
            )
        ),
    ),
    "objective with a half": ("L1", changed(two_at_once)),
    "cache without o": ("L1", cached()),
    "trace that rises": ("L4", traced(lambda F: [4.0 * F, 2.0 * F, 2.5 * F, F])),
    "trace upside down": ("L4", traced(lambda F: [F, 2.0 * F])),
    "trace of another objective": ("L4", traced(lambda F: [4.0 * F, 0.5 * F])),
    "malformed data answered": ("L0", unchecked),
}
"""By name: the first level that fails, and the solver. All answer each request."""
