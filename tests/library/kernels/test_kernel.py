"""Which form a kernel takes, and where its machine code is kept."""

import os
import threading
import time
import types
import warnings
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from convexperc import errors
from convexperc.errors import MissingExtraError, SlowWarning
from convexperc.kernels import compiling, machine_code
from convexperc.kernels import kernel as kernel_module
from convexperc.kernels.identity import digest
from convexperc.kernels.kernel import LOAD_MORE_SECONDS, LOAD_SECONDS, Kernel

FACTOR = 2.0


def _inner(x: float) -> float:
    return FACTOR * x


def _outer(x: float) -> float:
    return _inner(x) + 1.0


def _until_stopped(seen: np.ndarray, most: int) -> int:
    """Count, marking all entries but the first, until somebody else marks that."""
    count = 0
    while count < most and seen[0] == 0.0:
        seen[1 + count % (seen.size - 1)] = 1.0
        count += 1
    return count


def new(seconds: float = 0.0, compile_seconds: float = 5.0) -> Kernel:
    return Kernel(_outer, lambda x: seconds, compile_seconds)


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of its own for machine code, and no choice made by the caller."""
    monkeypatch.setenv(machine_code.FOLDER_VARIABLE, str(tmp_path / "cache"))
    monkeypatch.delenv(kernel_module.CHOICE_VARIABLE, raising=False)
    monkeypatch.setattr(kernel_module, "COMPILING", "not.imported")
    errors.warn_once.cache_clear()
    return tmp_path / "cache"


def form(kernel: Kernel) -> str:
    assert kernel(3.0) == 7.0
    return "interpreted" if kernel._machine_code is None else "compiled"


def test_little_work_is_interpreted_and_much_is_compiled() -> None:
    assert form(new(0.5 * LOAD_SECONDS)) == "interpreted"
    assert form(new(4.9)) == "interpreted"
    assert form(new(5.1)) == "compiled"


def test_what_is_compiled_already_is_loaded_sooner(folder: Path) -> None:
    new().compiled(3.0)
    assert len(list(folder.iterdir())) == 1
    assert form(new(0.9 * LOAD_SECONDS)) == "interpreted"
    assert form(new(1.1 * LOAD_SECONDS)) == "compiled"


def test_after_another_kernel_it_is_loaded_sooner_still(monkeypatch: pytest.MonkeyPatch) -> None:
    new().compiled(3.0)
    monkeypatch.setattr(kernel_module, "COMPILING", "convexperc.kernels.compiling")
    assert form(new(0.9 * LOAD_MORE_SECONDS)) == "interpreted"
    assert form(new(1.1 * LOAD_MORE_SECONDS)) == "compiled"
    assert form(Kernel(made("x + 3.0"), lambda x: 4.9, 5.0)) == "interpreted"


def replacing(function: Any = _outer, compile_seconds: float = 5.0) -> Kernel:
    return Kernel(function, lambda x: 1e9, compile_seconds, smallest=(0.0,))


def test_it_replaces_a_library_once_that_has_taken_as_long_as_compiling() -> None:
    kernel = replacing()
    assert [kernel.replaces(seconds) for seconds in (2.0, 2.9, 0.0, 0.2, 0.0)] == [
        False,
        False,
        False,
        True,
        True,
    ]
    assert kernel.compiled(3.0) == 7.0


def test_machine_code_that_exists_replaces_a_library_sooner() -> None:
    new().compiled(3.0)
    kernel = replacing()
    assert [kernel.replaces(0.4 * LOAD_SECONDS) for _ in range(4)] == [False, False, True, True]


@pytest.mark.parametrize("choice", ["interpreted", "compiled"])
def test_the_environment_decides_what_replaces_a_library(
    choice: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(kernel_module.CHOICE_VARIABLE, choice)
    assert replacing().replaces(1e9 if choice == "interpreted" else 0.0) is (choice == "compiled")


def test_without_numba_nothing_replaces_a_library(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(kernel_module, "installed", lambda module: False)
    kernel = replacing()
    assert not kernel.replaces(4.9)
    with pytest.warns(SlowWarning, match=r"convexperc\[fast\]"):
        assert not kernel.replaces(0.2)


def test_a_function_that_cannot_be_compiled_replaces_no_library() -> None:
    calls = []
    kernel = replacing(calls.append, 1.0)
    with pytest.warns(SlowWarning, match="stays interpreted"):
        assert not kernel.replaces(1.1)
    assert not kernel.replaces(1e9)
    assert calls == [0.0]


def in_threads(work: Callable[[int], Any], count: int = 8) -> list[Any]:
    """What threads that begin at once return."""
    barrier = threading.Barrier(count)

    def each(k: int) -> Any:
        barrier.wait(60.0)
        return work(k)

    with ThreadPoolExecutor(count) as pool:
        return list(pool.map(each, range(count)))


def test_threads_that_call_a_kernel_at_once_compile_it_once(monkeypatch: pytest.MonkeyPatch) -> None:
    kernel, made_of = new(1e9), []
    original = compiling.dispatcher
    monkeypatch.setattr(compiling, "dispatcher", lambda *given: made_of.append(given) or original(*given))
    assert in_threads(lambda k: [kernel(float(k)) for _ in range(50)]) == [
        [2.0 * k + 1.0] * 50 for k in range(8)
    ]
    assert len(made_of) == 1


def test_kernels_that_share_what_they_call_may_be_compiled_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    inner, original = made(), compiling.called

    def called(function: Any) -> Any:
        time.sleep(0.02)  # time for another thread to find a copy whose names do not yet stand for copies
        return original(function)

    monkeypatch.setattr(compiling, "called", called)
    kernels = [Kernel(calling(inner, f"inner(x) + {k}.0"), lambda x: 1e9, 1.0) for k in range(4)]
    assert in_threads(lambda k: kernels[k](3.0), 4) == [7.0 + k for k in range(4)]


def test_machine_code_runs_without_the_lock_of_the_interpreter() -> None:
    kernel, seen, most = Kernel(_until_stopped, lambda seen, most: 1e9, 1.0), np.zeros(3), 2**30
    assert kernel(np.zeros(3), 1) == 1

    def stop() -> None:
        while not seen.any():
            time.sleep(1e-3)
        seen[0] = 1.0

    stopping = threading.Thread(target=stop)
    stopping.start()
    assert kernel(seen, most) < most
    stopping.join()


def test_interpreted_seconds_add_up() -> None:
    kernel = new(0.0, 1.2)
    assert form(kernel) == "interpreted"
    kernel._spent = 1.3
    assert form(kernel) == "compiled"


@pytest.mark.parametrize("choice", ["interpreted", "compiled"])
def test_the_environment_decides(choice: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(kernel_module.CHOICE_VARIABLE, choice)
    assert form(new(1e9 if choice == "interpreted" else 0.0)) == choice


def test_without_numba_it_is_said_once_how_to_get_faster(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(errors, "installed", lambda module: False)
    monkeypatch.setattr(kernel_module, "installed", lambda module: False)
    assert form(new(4.9)) == "interpreted"
    with pytest.warns(SlowWarning, match=r"convexperc\[fast\]"):
        assert form(new(5.1)) == "interpreted"
    assert form(new(5.1)) == "interpreted"
    with pytest.raises(MissingExtraError, match=r"convexperc\[fast\]"):
        new().compiled(3.0)


def test_a_function_that_cannot_be_compiled_stays_interpreted() -> None:
    kernel = Kernel(lambda x: str(object()) and x, lambda x: 1e9, 1.0)
    with pytest.warns(SlowWarning, match="stays interpreted"):
        assert kernel(3.0) == 3.0
    assert kernel(4.0) == 4.0


@pytest.mark.parametrize("damage", [b"", b"x", None])
def test_a_damaged_file_is_compiled_anew(damage: bytes | None, folder: Path) -> None:
    new().compiled(3.0)
    (path,) = folder.iterdir()
    whole = path.read_bytes()
    path.write_bytes(whole[: len(whole) // 2] if damage is None else damage)
    assert new().compiled(3.0) == 7.0
    assert len(path.read_bytes()) >= len(whole) // 2
    name, form = path.name[: -len(machine_code.SUFFIX)].rsplit("-", 1)
    assert machine_code.read(name, form) is not None


def test_a_file_of_another_version_of_numba_is_compiled_anew(folder: Path) -> None:
    new().compiled(3.0)
    (path,) = folder.iterdir()
    name, form = path.name[: -len(machine_code.SUFFIX)].rsplit("-", 1)
    assert machine_code.write(name, form, b"no pickle") == path
    assert new().compiled(3.0) == 7.0


def test_a_file_of_somebody_else_is_not_used(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    kernel = new()
    kernel.compiled(3.0)
    assert machine_code.places(kernel.name)
    monkeypatch.setattr(machine_code, "_owners", lambda: {os.getuid() + 1})
    assert not machine_code.places(kernel.name)


def test_without_a_folder_each_process_compiles_and_says_so_once(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(machine_code.FOLDER_VARIABLE, "/proc/nowhere")
    with pytest.warns(SlowWarning, match="CONVEXPERC_CACHE_DIR"):
        assert new().compiled(3.0) == 7.0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert Kernel(_inner, lambda x: 0.0, 1.0).compiled(3.0) == 6.0


def test_no_home_and_a_package_that_cannot_be_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(machine_code.FOLDER_VARIABLE)
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr(machine_code, "BESIDE_SOURCES", tmp_path / "archive.zip" / "__pycache__")
    monkeypatch.setenv("HOME", "/nonexistent")
    assert [str(folder) for folder in machine_code.folders()] == ["/nonexistent/.cache/convexperc"]
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert (
        machine_code.write("name", "form", b"content") == tmp_path / "convexperc" / "name-form.machine-code"
    )


def test_the_oldest_machine_code_of_this_installation_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv(machine_code.FOLDER_VARIABLE)
    monkeypatch.setattr(machine_code, "BESIDE_SOURCES", tmp_path)
    names = "solve.python-a", "bound.python-a", *(f"solve.python-{each}" for each in "bcdef")
    for age, name in enumerate(names):
        written = machine_code.write(name, "form", b"content")
        assert written is not None
        os.utime(written, ns=(age, age))
    assert sorted(path.name.partition("-form")[0] for path in tmp_path.iterdir()) == sorted(
        ["bound.python-a", *(f"solve.python-{each}" for each in "cdef")]
    )


def test_a_file_that_goes_while_the_folder_is_listed_hides_no_other(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for form in "abc":
        machine_code.write("name", form, b"content")
    gone, real = folder / "name-b.machine-code", Path.stat

    def stat(self: Path, **more: Any) -> os.stat_result:
        if self == gone:
            gone.unlink(missing_ok=True)
        return real(self, **more)

    monkeypatch.setattr(Path, "stat", stat)
    found = [path.name for path in machine_code.places("name")]
    assert found == ["name-a.machine-code", "name-c.machine-code"]


CODE = "def inner(x):\n    return {inner}\n\ndef outer(x):\n    return inner(x) + SUMMAND\n"


def made(inner: str = "2.0 * x", summand: Any = 1.0, comment: str = "") -> Any:
    module = types.ModuleType("made")
    module.__dict__["SUMMAND"] = summand
    exec(comment + CODE.format(inner=inner), module.__dict__)
    return module.__dict__["outer"]


def calling(inner: Any, outer: str) -> Any:
    module = types.ModuleType("calling")
    module.__dict__["inner"] = inner
    exec(f"def outer(x):\n    return {outer}\n", module.__dict__)
    return module.__dict__["outer"]


def test_the_digest_is_that_of_everything_that_is_reached() -> None:
    assert digest(made()) == digest(made()) == digest(made(comment="# only a comment\n"))
    changed = (
        made("3.0 * x"), made("x * 2.0"), made(summand=np.nextafter(1.0, 2.0)), made(summand=np.array([1.0])),
        made(summand=np.array([2.0])), made("-(2.0 * x)"),
    )  # fmt: skip
    found = {digest(function) for function in (made(), *changed)}
    assert len(found) == 1 + len(changed)


def test_machine_code_older_than_what_it_calls_is_not_used(folder: Path) -> None:
    first = Kernel(made(), lambda x: 0.0, 1.0)
    assert first.compiled(3.0) == 7.0
    second = Kernel(made("5.0 * x"), lambda x: 0.0, 1.0)
    assert second.compiled(3.0) == 16.0
    assert len(list(folder.iterdir())) == 2
