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
            "the square of a combination of two vectors of any length",
            "(s*u - r*k).T*(s*u - r*k)",
            "s**2*u.T*u - 2*r*s*u.T*k + r**2*k.T*k",
            r="the norm of u",
            s="the norm of k",
        ),
        real(
            "cauchy-schwarz",
            "that square bounds the inner product by the product of the norms",
            ["r > 0", "s > 0", "s**2*r**2 - 2*r*s*c + r**2*s**2 >= 0"],
            "c <= r*s",
            r="||x||",
            s="||y||",
            c="x'y",
        ),
    )


def majorise_view() -> tuple[Step, ...]:
    """|t| <= t^2/(2|v|) + |v|/2."""
    return (
        real(
            "majorise-view",
            "the absolute value lies below its weighted square (times 2|v|), and touches it at v and -v",
            [],
            "2*abs(v)*abs(t) <= t**2 + v**2 and (2*abs(v)*abs(t) == t**2 + v**2) == (abs(t) == abs(v))",
            v="the entry of the iterate",
            t="any other value of it",
        ),
    )


def majorise_modality() -> tuple[Step, ...]:
    """||t|| <= ||t||^2/(2||v||) + ||v||/2."""
    return (
        identity(
            "majorise-square",
            "a weighted square less the norm is itself a square over 2||v||",
            "a**2/(2*b) + b/2 - a",
            "(a - b)**2/(2*b)",
            a="||t||",
            b="||v||",
        ),
        real(
            "majorise-modality",
            "the norm lies below its weighted square (times 2||v||), and touches it where the norms agree",
            [],
            "2*b*a <= a**2 + b**2 and (2*b*a == a**2 + b**2) == (a == b)",
            a="||t||",
            b="||v||",
        ),
    )


def bracket_view() -> Step:
    """A penalty and a linear term that it dominates."""
    return real(
        "bracket-view",
        "an entry's penalty and its linear term together are not negative",
        ["abs(v) <= l"],
        "l*abs(h) + v*h >= 0",
        v="v_j, or (Xa - b)_j of a feasible dual point, or -2(Xo)_j",
        l="lambda2",
        h="w_j, or a change of it",
    )


def bracket_modality() -> Step:
    """The same for a block."""
    return real(
        "bracket-modality",
        "the same for a block",
        ["G <= l", "s >= 0", "c >= -G*s"],
        "l*s + c >= 0",
        G="||g^i||, ||X_i'b|| of a feasible dual point, or the norm of a residual's dual vector",
        l="lambda3, or lambda_k",
        s="||k||, k the block u^i or a change of it, or A_k times a change",
        c="the inner product of that vector and k",
    )


def slope_view() -> Step:
    """Sign of w is the slope of |w|."""
    return real(
        "slope-view",
        "the absolute value is linear near a number that is not 0, with the sign as its slope (times |w|)",
        ["abs(h) < abs(w)"],
        "abs(w)*(abs(w + h) - abs(w)) == w*h",
        w="w_j",
        h="a change of it",
    )


def slope_modality() -> Step:
    """u/||u|| is the slope of ||u||."""
    return real(
        "slope-modality",
        "a norm lies above its tangent, by a remainder of second order at most (times ||u||)",
        ["r > 0", "n >= 0", "n**2 == r**2 + 2*c + k", "c**2 <= r**2*k"],
        "r*n >= r**2 + c and 2*r*n <= 2*r**2 + 2*c + k",
        r="||u||",
        n="||u + h||",
        c="u'h",
        k="||h||^2",
    )


def tangent_view() -> Step:
    """|w| lies above its tangents."""
    return real(
        "tangent-view",
        "the absolute value lies above its tangents (times |w|)",
        [],
        "abs(w)*abs(w + h) >= w**2 + w*h",
        w="w_j",
        h="a change of it",
    )


def quadratic_part() -> Step:
    """Second-order expansion of the two squares, exact."""
    return matrix_identity(
        "quadratic-part",
        "the exact expansion of the two squares of F: v and g times the changes, and two squares",
        f"{squares('w + h', 'u + k')} - {squares('w', 'u')}",
        "(2*X*(X.T*w - o) - 2*l1*(X*u - w)).T*h + 2*l1*(X.T*(X*u - w)).T*k"
        " + (X.T*h).T*(X.T*h) + l1*(X*k - h).T*(X*k - h)",
    )


def squares(w: str, u: str) -> str:
    """The text of ||X'w - o||^2 + lambda1 ||Xu - w||^2."""
    return f"((X.T*({w}) - o).T*(X.T*({w}) - o) + l1*(X*({u}) - ({w})).T*(X*({u}) - ({w})))"
