"""What a run looks at: enough of every family, most of it more than zeros, and code of the product."""

import sys
from collections.abc import Callable
from dataclasses import replace
from itertools import product
from types import FrameType
from typing import Any

import numpy as np
import pytest

import convexperc
from verification.checks.catalogue import CHECKS
from verification.checks.interface import Check
from verification.problems.families import FAMILIES, ZERO, is_trivial, seeded, zero_parts
from verification.problems.sources import Seeded
from verification.search.engine import Result, plan
from verification.search.profiles import PROFILES
from verification.search.shards import Found, Shard, explore

CHECK = {check.name: check for check in CHECKS}
NAMES = list(CHECK)
REFEREE = CHECK["answer"]
"""Every one of its problems goes to the exact referee."""
DATA = ("problem", "arrays", "conversion", "modalities", "penalties", "views", "reduction")
"""Modules of `convexperc.problem` that hold the data and compute nothing that a claim is about."""


@pytest.mark.parametrize("name", NAMES)
def test_every_check_gets_strictly_more_in_a_larger_profile(name: str) -> None:
    for family in CHECK[name].families:
        budgets = [PROFILES[profile].budget(CHECK[name], family) for profile in ("quick", "ci", "full")]
        assert budgets == sorted(set(budgets)), (name, family, budgets)


def test_the_plan_reaches_every_family_of_every_check() -> None:
    planned = {(shard.check, shard.family) for shard in plan(CHECKS, PROFILES["quick"])}
    assert planned == {(check.name, family) for check in CHECKS for family in check.families}, planned
    unreached = set(FAMILIES) - {family for _, family in planned if _ == REFEREE.name}
    assert not unreached, unreached


def drawn(family: str, problems: int) -> Found:
    """The problems that the referee's check gets in a quick run, without what it does with them."""
    check = replace(REFEREE, observe=lambda problem, source: [])
    return explore(Shard(check.name, family, 0, problems), check, 0)


@pytest.mark.parametrize("family", FAMILIES)
def test_refereed_problems_are_many_and_most_of_them_not_trivial(family: str) -> None:
    budget = PROFILES["quick"].budget(REFEREE, family)
    assert budget >= 12, budget
    found = drawn(family, budget)
    assert found.problems == budget, found
    assert 2 * found.nontrivial >= found.problems, found


def test_a_run_says_where_most_problems_were_trivial_or_none_was_tried() -> None:
    found = [Found("answer|random|0|12|", 12, 5), Found("answer|zero_row|0|12|", 12, 6)]
    result = Result.of(found, [replace(REFEREE, families=("random", "zero_row", "zero_target"))])
    assert result.unreached == [
        "answer was not tried on zero_target",
        "answer: 5 of 12 problems of random are not trivial",
    ], result.unreached


@pytest.mark.parametrize("family", FAMILIES)
def test_what_a_family_makes_0_is_0_and_nothing_else_needs_to_be(family: str) -> None:
    problems = [seeded(family, 5, index, largest=(4, 8)) for index in range(12)]
    always = frozenset.intersection(*(zero_parts(problem) for problem in problems))
    allowed = ZERO.get(family, frozenset())
    assert always <= allowed, (family, always)
    if family != "near_duplicates_without_lambdas":
        assert always == allowed, (family, always)
    assert 2 * sum(is_trivial(problem, family) for problem in problems) <= len(problems), family


def test_zeros_that_a_family_does_not_ask_for_are_trivial() -> None:
    assert is_trivial(seeded("zero_target", 5, 0), "random")
    assert is_trivial(seeded("lambda1_zero", 5, 0), "lambda2_zero")
    assert not is_trivial(seeded("zero_target", 5, 0), "zero_target")


def called(check: Check, problems: int) -> set[str]:
    """Modules of convexperc, those of the data apart, that the first problem with any of them calls."""
    found: set[str] = set()
    root = convexperc.__name__

    def note(frame: FrameType, event: str, argument: Any) -> None:
        module = frame.f_globals.get("__name__", "")
        if event == "call" and module.split(".")[0] == root:
            found.add(module)

    for family, index in product(check.families[:2], range(problems)):
        observe_profiled(check, seeded(family, 6, index, largest=check.largest), index, note)
        found -= {f"{root}.problem.{name}" for name in DATA}
        if found:
            break
    return found


def observe_profiled(check: Check, problem: Any, index: int, note: Callable[..., None]) -> None:
    """Observe with a profile function; it is taken out again, whatever happens."""
    source, before = Seeded(np.random.default_rng(index), check.largest), sys.getprofile()
    sys.setprofile(note)
    try:
        list(check.observe(problem, source))
    finally:
        sys.setprofile(before)


@pytest.mark.parametrize("name", NAMES)
def test_checks_of_formulas_alone_are_those_that_call_no_code_of_the_product(name: str) -> None:
    check = CHECK[name]
    modules = called(check, 3)
    assert bool(modules) == check.product, (name, sorted(modules))


def test_formulas_are_counted_apart() -> None:
    found = [Found("vectors|random|0|64|", 64, 64), Found("answer|random|0|12|", 12, 12)]
    result = Result.of(found, [CHECK["vectors"], replace(REFEREE, families=("random",))])
    assert (result.total, result.formulas) == (76, 64), result
