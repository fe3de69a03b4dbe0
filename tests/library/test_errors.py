import pickle
import subprocess
import sys

import pytest

from convexperc import errors
from convexperc.errors import ConvexpercError, InputError, escaped

KINDS = [
    (errors.InputError, ValueError),
    (errors.ProblemError, ValueError),
    (errors.ModalityError, ValueError),
    (errors.PointError, ValueError),
    (errors.ImageError, ValueError),
    (errors.SourceError, ValueError),
    (errors.FeatureError, ValueError),
    (errors.FileFormatError, ValueError),
    (errors.SolverError, RuntimeError),
    (errors.MissingExtraError, ImportError),
]


@pytest.mark.parametrize(("kind", "builtin"), KINDS)
def test_an_error_says_what_which_value_what_must_hold_and_what_to_do(kind, builtin):
    error = kind("lambda2", value=-1.0, must="must be >= 0", remedy="Drop the sign.")
    assert isinstance(error, ConvexpercError), kind.__mro__
    assert isinstance(error, builtin), kind.__mro__
    assert issubclass(kind, InputError) == (builtin is ValueError), kind.__mro__
    assert str(error) == "lambda2 must be >= 0; got -1.0. Drop the sign."


@pytest.mark.parametrize("kind", [kind for kind, _ in KINDS])
@pytest.mark.parametrize("remedy", ["", "Drop the sign."])
def test_an_error_pickles_with_its_parts(kind, remedy):
    error = kind("o[3]", value=float("-inf"), must="must be finite", remedy=remedy)
    again = pickle.loads(pickle.dumps(error))
    assert type(again) is kind, type(again)
    assert vars(again) == vars(error)
    assert str(again) == str(error)


@pytest.mark.parametrize("value", [list(range(1000)), 10**4000, "x" * 1000], ids=["list", "integer", "text"])
def test_a_long_value_is_shown_shortened_and_kept_whole(value):
    error = ConvexpercError("X", value=value, must="must be short")
    assert len(str(error)) < 200, str(error)
    assert error.value == value


def test_an_integer_too_long_for_repr_is_still_reported_as_ours():
    error = InputError("lambda1", value=10**5000, must="must fit into float64")
    assert "lambda1" in str(error), str(error)
    assert error.value == 10**5000


def test_a_package_that_is_there_is_not_imported_to_find_out():
    code = "import sys; from convexperc.errors import require; require('numpy', 'plot', 'the picture')"
    done = subprocess.run(
        [sys.executable, "-c", f"{code}; print('numpy' in sys.modules)"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "False\n", done.stdout


def test_a_package_that_is_missing_is_named_with_the_command_that_installs_it():
    with pytest.raises(errors.MissingExtraError) as refused:
        errors.require("no_such_package", "plot", "the picture")
    assert str(refused.value) == (
        "the picture needs no_such_package; got ModuleNotFoundError(\"No module named 'no_such_package'\")."
        " Install it: pip install 'convexperc[plot]'."
    )
    assert refused.value.value.name == "no_such_package"


@pytest.mark.parametrize(
    "text",
    [
        "9.41\u202fAM",
        "a\u00a0b",
        "全角\u3000空白",
        "👩\u200d🚀",
        "🏴\U000e0067\U000e007f",
        "שלום",
        "e\u0301 \\n",
        "",
    ],
)
def test_a_legitimate_name_is_printed_as_it_is(text):
    assert escaped(text) == text


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("a\nb\r\tc", r"a\nb\r\tc"),
        ("\x1b[2J\x00\x7f\x9b", r"\x1b[2J\x00\x7f\x9b"),
        ("\u2028\u2029\x85", r"\u2028\u2029\x85"),
        ("\u202agnp\u202e\u2066\u2069", r"\u202agnp\u202e\u2066\u2069"),
        ("byte \udce9", r"byte \udce9"),
    ],
)
def test_what_would_forge_or_reorder_a_line_is_escaped(text, printed):
    assert escaped(text) == printed
    assert escaped(printed) == printed
    error = InputError(f"picture {text}", value=None, must=f"must not be {text}")
    assert str(error) == f"picture {printed} must not be {printed}; got None."
    assert error.what == f"picture {text}"
