"""One package of the lasso family, run where it is installed: data sets in, coefficients out, one a line.

``PYTHON lasso_runner.py PEER`` needs NumPy and the package alone, so that packages that cannot be installed
beside one another are asked in environments of their own.
"""

import json
import os
import sys
import warnings
from collections.abc import Callable
from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np

Fit = Callable[[Any, Any, dict[str, Any]], tuple[Any, float]]


def _plain(module: str, **settings: Any) -> Fit:
    """Lasso of scikit-learn and of the packages that follow it."""

    def fit(X: Any, y: Any, given: dict[str, Any]) -> tuple[Any, float]:
        kind = import_module(module).Lasso
        found = kind(alpha=given["alpha"], fit_intercept=given["intercept"], **settings).fit(X, y)
        return found.coef_, found.intercept_

    return fit


def _grouped(module: str, **settings: Any) -> Fit:
    """GroupLasso of celer and skglm."""

    def fit(X: Any, y: Any, given: dict[str, Any]) -> tuple[Any, float]:
        kind = import_module(module).GroupLasso
        model = kind(given["sizes"], alpha=given["alpha"], fit_intercept=given["intercept"], **settings)
        found = model.fit(X, y)
        return found.coef_, found.intercept_

    return fit


def _adelie(**settings: Any) -> Fit:
    def fit(X: Any, y: Any, given: dict[str, Any]) -> tuple[Any, float]:
        adelie = import_module("adelie")
        starts = np.cumsum([0, *given["sizes"][:-1]])
        path = {"lmda_path": np.array([given["alpha"]]), "early_exit": False, "progress_bar": False}
        state = adelie.grpnet(
            X, adelie.glm.gaussian(y), groups=starts, intercept=given["intercept"], **path, **settings
        )
        return state.betas[-1].toarray(), state.intercepts[-1]

    return fit


def _group_lasso(**settings: Any) -> Fit:
    def fit(X: Any, y: Any, given: dict[str, Any]) -> tuple[Any, float]:
        kind = import_module("group_lasso").GroupLasso
        groups = np.repeat(np.arange(len(given["sizes"])), given["sizes"])
        model = kind(
            groups=groups, group_reg=given["alpha"], l1_reg=0.0, fit_intercept=given["intercept"],
            supress_warning=True, random_state=0, **settings,
        )  # fmt: skip
        model.fit(X, y)
        return model.coef_, np.ravel(model.intercept_)[0]

    return fit


def _asgl(**settings: Any) -> Fit:
    def fit(X: Any, y: Any, given: dict[str, Any]) -> tuple[Any, float]:
        groups = np.repeat(np.arange(len(given["sizes"])), given["sizes"])
        model = import_module("asgl").Regressor(
            model="lm",
            penalization="gl",
            lambda1=given["alpha"],
            fit_intercept=given["intercept"],
            **settings,
        )
        model.fit(X, y, group_index=groups)
        return model.coef_, np.ravel(model.intercept_)[0]

    return fit


PEERS: dict[str, Fit] = {
    "sklearn": _plain("sklearn.linear_model"),
    "sklearn_tight": _plain("sklearn.linear_model", tol=1e-10, max_iter=1_000_000),
    "celer": _grouped("celer"),
    "celer_tight": _grouped("celer", tol=1e-10, max_iter=1000),
    "skglm": _grouped("skglm"),
    "skglm_tight": _grouped("skglm", tol=1e-8),
    "adelie": _adelie(),
    "adelie_tight": _adelie(tol=1e-14),
    "group_lasso": _group_lasso(),
    "group_lasso_tight": _group_lasso(tol=1e-10, n_iter=5000),
    "asgl": _asgl(),
    "asgl_tight": _asgl(tol=1e-14),
}
"""A fit by name: (X, y, what was given) to coefficients and intercept."""


def main(name: str, package: str) -> None:
    """Answer every line of standard input; what the package prints goes to standard error."""
    warnings.simplefilter("ignore")
    with os.fdopen(os.dup(1), "w", encoding="utf-8") as answers:
        os.dup2(2, 1)
        print(json.dumps({"version": version(package)}), file=answers, flush=True)
        for line in sys.stdin:
            given = json.loads(line)
            try:
                X, y = np.asfortranarray(given["X"], dtype=np.float64), np.array(given["y"], dtype=np.float64)
                coef, intercept = PEERS[name](X, y, given)
                answer = {"coef": np.ravel(coef).astype(float).tolist(), "intercept": float(intercept)}
            except Exception as error:  # whatever a package raises is its answer
                answer = {"error": f"{type(error).__name__}: {error}"[:200]}
            print(json.dumps(answer), file=answers, flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
