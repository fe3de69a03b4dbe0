"""Losses of the literature with their weights, as terms; the weights are those of r**2/2 unless told."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from verification.reweighted.terms.term import Term

HALF = "r**2/2"


@dataclass(frozen=True)
class Loss:
    """A known loss.

    Attributes
    ----------
    name, loss, weight : str
    widths : mapping of str to str
        With usual values.
    source : str
        Author and year, or the software that has it.
    square : {"r**2/2", "r**2"}
    signed : bool
    majorises : bool
        Whether the weighted square is known to lie above it.
    """

    name: str
    loss: str
    weight: str
    widths: Mapping[str, str] = field(default_factory=dict)
    source: str = ""
    square: str = HALF
    signed: bool = False
    majorises: bool = True

    @property
    def term(self) -> Term:
        """The same as a term."""
        return Term(self.loss, self.weight, self.square, self.widths, self.signed, self.name)


LOSSES = (
    Loss("l2", "r**2/2", "1", source="Gauss 1809"),
    Loss("l1", "r", "1/r", source="Schlossmacher 1973"),
    Loss("norm, by r**2", "r", "1/(2*r)", source="Weiszfeld 1937", square="r**2"),
    Loss(
        "huber",
        "r**2/2 if r <= c else c*r - c**2/2",
        "1 if r <= c else c/r",
        {"c": "1.345"},
        "Huber 1964",
    ),
    Loss(
        "pseudo-huber",
        "c**2*(sqrt(1 + (r/c)**2) - 1)",
        "1/sqrt(1 + (r/c)**2)",
        {"c": "1"},
        "Charbonnier et al. 1997",
    ),
    Loss("fair", "c**2*(r/c - log(1 + r/c))", "1/(1 + r/c)", {"c": "1.3998"}, "Fair 1974"),
    Loss("cauchy", "c**2*log(1 + (r/c)**2)/2", "1/(1 + (r/c)**2)", {"c": "2.3849"}, "Black and Anandan 1996"),
    Loss(
        "geman-mcclure",
        "c**2*r**2/(c**2 + r**2)/2",
        "c**4/(c**2 + r**2)**2",
        {"c": "1"},
        "Geman and McClure 1985",
    ),
    Loss(
        "welsch", "c**2*(1 - exp(-(r/c)**2))/2", "exp(-(r/c)**2)", {"c": "2.9846"}, "Dennis and Welsch 1978"
    ),
    Loss(
        "tukey",
        "c**2*(1 - (1 - (r/c)**2)**3)/6 if r <= c else c**2/6",
        "(1 - (r/c)**2)**2 if r <= c else 0",
        {"c": "4.6851"},
        "Beaton and Tukey 1974",
    ),
    Loss(
        "andrew",
        "c**2*(1 - cos(r/c)) if r <= c*pi else 2*c**2",
        "c*sin(r/c)/r if r <= c*pi else 0",
        {"c": "1.339"},
        "Andrews 1974",
    ),
    Loss(
        "hampel",
        "r**2/2 if r <= a else (a*r - a**2/2 if r <= b else (a*(b + d - a)/2 - a*(d - r)**2/(2*(d - b))"
        " if r <= d else a*(b + d - a)/2))",
        "1 if r <= a else (a/r if r <= b else (a*(d - r)/((d - b)*r) if r <= d else 0))",
        {"a": "2", "b": "4", "d": "8"},
        "Hampel 1974",
    ),
    Loss("ramsay", "(1 - exp(-a*r)*(1 + a*r))/a**2", "exp(-a*r)", {"a": "0.3"}, "Ramsay 1977"),
    Loss("log-sum", "log(1 + r/c)", "1/(r*(c + r))", {"c": "0.1"}, "Candes, Wakin and Boyd 2008"),
    Loss("log of squares", "log(r**2 + c**2)/2", "1/(r**2 + c**2)", {"c": "0.1"}, "Chartrand and Yin 2008"),
    Loss("lp, p = 1/2", "r**(1/2)", "1/(2*r**(3/2))", source="Chartrand and Yin 2008"),
    Loss("lp, p = 3/2", "r**(3/2)", "3/(2*r**(1/2))", source="Merle and Spath 1974"),
    Loss("smoothed l1", "sqrt(r**2 + c**2)", "1/sqrt(r**2 + c**2)", {"c": "0.001"}, "Daubechies et al. 2010"),
    Loss(
        "barron, alpha = -2",
        "2*(r/c)**2/((r/c)**2 + 4)",
        "1/(c**2*((r/c)**2/4 + 1)**2)",
        {"c": "1"},
        "Barron 2019",
    ),
    Loss("barron, alpha = 0", "log((r/c)**2/2 + 1)", "2/(r**2 + 2*c**2)", {"c": "1"}, "Barron 2019"),
    Loss(
        "barron, alpha = 1",
        "sqrt((r/c)**2 + 1) - 1",
        "1/(c**2*sqrt((r/c)**2 + 1))",
        {"c": "1"},
        "Barron 2019",
    ),
    Loss(
        "student t, 4 degrees",
        "5*log(1 + (r/c)**2/4)/2",
        "5/(4*c**2 + r**2)",
        {"c": "1"},
        "Lange, Little and Taylor 1989",
    ),
    Loss(
        "switchable constraints",
        "r**2/2 if r**2 <= p else 3*p/2 - 2*p**2/(p + r**2)",
        "1 if r**2 <= p else 4*p**2/(p + r**2)**2",
        {"p": "1"},
        "Agarwal et al. 2013",
    ),
    Loss(
        "truncated l2",
        "r**2/2 if r <= c else c**2/2",
        "1 if r <= c else 0",
        {"c": "2"},
        "Blake and Zisserman 1987",
    ),
    Loss("capped l1", "r if r <= c else c", "1/r if r <= c else 0", {"c": "2"}, "Zhang 2010"),
    Loss(
        "minimax concave",
        "c*r - r**2/4 if r <= 2*c else c**2",
        "c/r - 1/2 if r <= 2*c else 0",
        {"c": "1"},
        "Zhang 2010",
    ),
    Loss("arctan", "c**2*atan((r/c)**2)/2", "1/(1 + (r/c)**4)", {"c": "1"}, "SciPy"),
    Loss("l1 and l2", "r + r**2/2", "1/r + 1", source="Zou and Hastie 2005"),
    Loss(
        "quantile, q = 0.3",
        "0.3*r if r >= 0 else -0.7*r",
        "0.3/r if r >= 0 else -0.7/r",
        source="Koenker and Bassett 1978",
        signed=True,
        majorises=False,
    ),
    Loss(
        "expectile, q = 0.3",
        "0.3*r**2 if r >= 0 else 0.7*r**2",
        "0.3 if r >= 0 else 0.7",
        source="Newey and Powell 1987",
        square="r**2",
        signed=True,
        majorises=False,
    ),
    Loss(
        "dead zone",
        "0 if r <= c else (r - c)**2/2",
        "0 if r <= c else 1 - c/r",
        {"c": "1"},
        "GTSAM",
        majorises=False,
    ),
)
"""In no order that means anything; those that do not majorise come last."""
