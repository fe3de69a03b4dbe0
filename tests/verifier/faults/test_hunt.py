"""The mutation test: on the quick profile's problems every fault is named by its part, and by no other."""

from dataclasses import replace

import pytest

from convexperc.problem import formulation as objective
from verification.checks import cost
from verification.checks.catalogue import CHECKS
from verification.faults.fault import Fault, replaced
from verification.faults.hunt import by_check, hunt, look, look_all
from verification.faults.own import FAULTS
from verification.ledger.claims import PARTS

COUNTED = {f"C1/{name}" for name in cost.EXPONENTS}
"""Parts that counts of operations judge, and no check on problems."""

FAULT = {fault.name: fault for fault in FAULTS}
ENOUGH = 3
"""Families in which a fault shows, after which the rest are left out: most faults show in nearly all."""


GROUPS = by_check(FAULTS)
"""Those of one check are looked at together, as the check's problems are drawn once."""


@pytest.mark.parametrize("group", GROUPS, ids=[f"{len(group)}-{group[0].part}" for group in GROUPS])
def test_every_planted_fault_is_named_by_its_parts_and_by_no_other(group: list[Fault]):
    """In a process of its own, where nothing checks the types of every call."""
    wrong: dict[str, object] = {}
    looked = look_all(group, enough=ENOUGH, jobs=2)
    for name, seen in looked.items():
        fault = FAULT[name]
        if not seen.names(fault):
            wrong[name] = ("not named by all that must", seen.parts, seen.broken)
        elif not seen.parts <= {fault.part, *fault.also, *fault.may}:
            wrong[name] = ("named by another", seen.failing, seen.silent)
        elif seen.broken or not (seen.held & {fault.part, *fault.also} or seen.silent):
            wrong[name] = ("the check broke, or nothing is ever held", seen.broken)
    assert not wrong, wrong
    assert set(looked) == {fault.name for fault in group}


def test_every_planted_fault_is_in_a_group():
    assert sorted(fault.name for group in GROUPS for fault in group) == sorted(FAULT)


@pytest.mark.parametrize("fault", FAULTS, ids=[fault.name for fault in FAULTS])
def test_a_planted_fault_is_taken_out(fault: Fault):
    with fault.planted() as patcher:
        places = list(patcher.before)
        assert places
        assert all(vars(target)[name] is not before for target, name, before in places)
    assert all(vars(target)[name] is before for target, name, before in places)


def test_names_are_different_and_parts_are_those_of_the_ledger():
    names = [fault.name for fault in FAULTS]
    assert len(set(names)) == len(names), sorted(name for name in names if names.count(name) > 1)
    assert {part for fault in FAULTS for part in (fault.part, *fault.also, *fault.may)} <= set(PARTS)


def test_every_part_that_is_observed_has_a_fault():
    observed = {part for check in CHECKS for part in check.parts} | COUNTED
    named = {part for fault in FAULTS for part in (fault.part, *fault.also)}
    assert observed == named, observed ^ named


@pytest.mark.parametrize("part", ["B1/objective", "D1/printed", "C1/step6"])
def test_without_a_fault_nothing_is_named(part):
    found = look(Fault("no fault", part, lambda setter: None))
    assert not found.parts, found
    assert not found.broken, found.broken
    assert not found.names(Fault("no fault", part, lambda setter: None))


def test_a_check_that_breaks_has_not_named_the_fault():
    plant = replaced(objective, "terms", lambda problem, w, u: 1 / 0)
    found = hunt(Fault("broken", "B1/objective", plant))
    assert not found.caught, found
    assert (found.n, found.d, found.family) == (0, 0, ""), found
    assert "ZeroDivisionError" in found.detail, found.detail


def test_a_part_that_is_observed_nowhere_is_refused():
    with pytest.raises(KeyError, match="R1/defined"):
        look(Fault("unseen", "R1/defined", lambda setter: None))


def test_a_counterexample_is_shrunk_and_the_same_each_time():
    fault = next(fault for fault in FAULTS if fault.name == "Xu + w for Xu - w")
    found = hunt(fault)
    assert (found.n, found.d) == (1, 1), found
    assert found == replace(hunt(fault), seconds=found.seconds), "two hunts differ"
