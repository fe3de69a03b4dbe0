"""Hypothesis profiles: random at home, derandomised where CI says so. What draws, where something does."""

import os
import signal
from collections.abc import Iterator

import pytest
import typed
from hypothesis import HealthCheck, settings
from interpreter import Interpreter
from jaxtyping import config

from convexperc.errors import MissingExtraError
from convexperc.simulation.backends import RenderingError
from convexperc.simulation.opengl import Engine, engine

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
"""For the workers and the processes that tests start: their matrices are small, and threads that wait for one
another, where every core is in use, cost more than the products."""

for each, default in ((signal.SIGINT, signal.default_int_handler), (signal.SIGHUP, signal.SIG_DFL)):
    if (
        signal.getsignal(each) is signal.SIG_IGN
    ):  # by nohup, or by a shell that started this in the background
        signal.signal(each, default)
"""Processes that tests start, to end them so, inherit what is ignored."""

settings.register_profile("default", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.register_profile("ci", parent=settings.get_profile("default"), derandomize=True)
settings.load_profile("ci" if os.environ.get("CI") else "default")


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup() -> None:
    """Types are checked from the first call of each test on; see `typed`."""
    typed.begin()


@pytest.fixture
def untyped() -> None:
    """Arguments of other types than are declared reach the function; the next test is typed again."""
    config.update("jaxtyping_disable", True)


@pytest.fixture(scope="session")
def interpreter() -> Iterator[Interpreter]:
    """Runs programs as ``python -c`` does."""
    forking = Interpreter()
    yield forking
    forking.close()


@pytest.fixture(scope="session")
def opengl() -> Engine:
    """What draws here; without it a test that draws is skipped, with the packages to install."""
    try:
        return engine()
    except (MissingExtraError, RenderingError) as missing:
        pytest.skip(str(missing))
