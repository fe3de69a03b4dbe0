"""Planting a fault: every place is changed, and put back whatever happens."""

import pytest

from convexperc.problem import formulation as objective
from convexperc.solvers.paper import trace as paper_trace
from verification.faults.fault import Fault, Patcher, everywhere, replaced


def test_a_fault_is_taken_out_after_an_exception():
    fault = Fault("half of F", "B1/objective", replaced(objective, "objective", lambda p, w, u: 0.0))
    true = objective.objective

    def interrupted():
        with fault.planted():
            assert objective.objective is not true
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        interrupted()
    assert objective.objective is true


def test_a_fault_that_cannot_be_planted_leaves_nothing_behind():
    true = objective.objective

    def half_planted(setter):
        setter.setattr(objective, "objective", None)
        setter.setattr(objective, "no such name", None)

    with pytest.raises(KeyError), Fault("half", "B1/objective", half_planted).planted():
        pytest.fail("planted")
    assert objective.objective is true


def test_everywhere_means_every_module_that_holds_the_function():
    patcher, true = Patcher(), objective.residuals
    everywhere(true, len)(patcher)
    try:
        assert objective.residuals is len
        assert paper_trace.residuals is len
    finally:
        patcher.undo()
    assert objective.residuals is paper_trace.residuals is true
