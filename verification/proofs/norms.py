"""Facts about |t| and ||t|| that several arguments use, each for one entry of w or one block of u."""

from verification.ledger.evidence import Step
from verification.proofs.checkers.matrices import matrix_identity
from verification.proofs.checkers.polynomials import identity
from verification.proofs.checkers.reals import real


def cauchy_schwarz() -> tuple[Step, ...]:
    """The inequality of Cauchy and Schwarz: x'y <= ||x|| ||y||."""
    return (
        matrix_identity(
            "cauchy-schwarz-square",
            "||s x - r y||^2 = s^2 ||x||^2 - 2 r s x'y + r^2 ||y||^2 for vectors of any length",
            "(s1*u - r1*k).T*(s1*u - r1*k)",
            "s1**2*u.T*u - 2*r1*s1*u.T*k + r1**2*k.T*k",
        ),
        real(
            "cauchy-schwarz",
            "with r = ||x|| > 0 and s = ||y|| > 0 that square is 2 r s (r s - x'y), so x'y <= r s",
            ["r > 0", "s > 0", "s**2*r**2 - 2*r*s*c + r**2*s**2 >= 0"],
            "c <= r*s",
        ),
    )


def majorise_view() -> tuple[Step, ...]:
    """|t| <= t^2/(2|v|) + |v|/2."""
    return (
        real(
            "majorise-view",
            "|t| <= t^2/(2|v|) + |v|/2 for v != 0 (times 2|v|); equality at t = v and at t = -v only",
            ["v != 0"],
            "2*abs(v)*abs(t) <= t**2 + v**2 and (2*abs(v)*abs(t) == t**2 + v**2) == (abs(t) == abs(v))",
        ),
    )


def majorise_modality() -> tuple[Step, ...]:
    """||t|| <= ||t||^2/(2||v||) + ||v||/2."""
    return (
        identity(
            "majorise-square",
            "with a = ||t||, b = ||v|| > 0: a^2/(2b) + b/2 - a = (a - b)^2/(2b)",
            "a**2/(2*b) + b/2 - a",
            "(a - b)**2/(2*b)",
        ),
        real(
            "majorise-modality",
            "hence ||t|| <= ||t||^2/(2||v||) + ||v||/2 for v != 0, equality if and only if ||t|| = ||v||",
            ["a >= 0", "b > 0"],
            "2*b*a <= a**2 + b**2 and (2*b*a == a**2 + b**2) == (a == b)",
        ),
    )


def slope_view() -> Step:
    """Sign of w is the slope of |w|."""
    return real(
        "slope-view",
        "| |w + h| - |w| - h w/|w| | = 0 for |h| < |w|: the derivative of |w| at w != 0 is w/|w|",
        ["w != 0", "abs(h) < abs(w)"],
        "abs(w)*(abs(w + h) - abs(w)) == w*h",
    )


def slope_modality() -> Step:
    """u/||u|| is the slope of ||u||."""
    return real(
        "slope-modality",
        "0 <= ||u + h|| - ||u|| - u'h/||u|| <= ||h||^2/(2||u||) at u != 0 (r = ||u||, n = ||u + h||, c = u'h,"
        " k = ||h||^2, |c| <= r ||h||): the derivative of ||u|| is u/||u||",
        ["r > 0", "n >= 0", "n**2 == r**2 + 2*c + k", "k >= 0", "c**2 <= r**2*k"],
        "r*n >= r**2 + c and 2*r*n <= 2*r**2 + 2*c + k",
    )


def tangent_view() -> Step:
    """|w| lies above its tangents."""
    return real(
        "tangent-view",
        "|w + h| >= |w| + h w/|w| for w != 0 and every h",
        ["w != 0"],
        "abs(w)*abs(w + h) >= w**2 + w*h",
    )


def quadratic_part() -> Step:
    """Second-order expansion of the two squares, exact."""
    return matrix_identity(
        "quadratic-part",
        "f = ||X'w-o||^2 + lambda1 ||Xu-w||^2: f(w+h, u+k) - f(w, u) = v'h + g'k + ||X'h||^2 + lambda1"
        " ||Xk-h||^2 with v = 2X(X'w-o) - 2 lambda1 (Xu-w), g = 2 lambda1 X'(Xu-w)",
        f"{squares('w + h', 'u + k')} - {squares('w', 'u')}",
        "(2*X*(X.T*w - o) - 2*l1*(X*u - w)).T*h + 2*l1*(X.T*(X*u - w)).T*k"
        " + (X.T*h).T*(X.T*h) + l1*(X*k - h).T*(X*k - h)",
    )


def squares(w: str, u: str) -> str:
    """The text of ||X'w - o||^2 + lambda1 ||Xu - w||^2."""
    return f"((X.T*({w}) - o).T*(X.T*({w}) - o) + l1*(X*({u}) - ({w})).T*(X*({u}) - ({w})))"
