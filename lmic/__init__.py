"""lmic: a symbolic-to-numeric compiler for parameter-dependent linear matrix inequalities.

    >>> import lmic
    >>> theorem = lmic.theorem("peixoto2025.corollary1")
    >>> problem = lmic.compile(theorem, lmic.read_plant("example1.toml"), {"eps": 150})
    >>> result = lmic.run(problem)

The names below load when they are first used, so that importing lmic costs nothing.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.1.0"

if TYPE_CHECKING:
    from lmic.certify.certificate_file import read_certificate as read_certificate
    from lmic.certify.verify import verify as verify
    from lmic.diagnosis.diagnose import Diagnosis as Diagnosis
    from lmic.diagnosis.diagnose import diagnose as diagnose
    from lmic.interchange.formats import read_problem as read_problem
    from lmic.interchange.formats import write_problem as write_problem
    from lmic.interchange.models import cvxpy_problem as cvxpy_problem
    from lmic.interchange.models import picos_problem as picos_problem
    from lmic.library import theorem as theorem
    from lmic.pages.result import report as report
    from lmic.pipeline import compile as compile
    from lmic.pipeline import finish as finish
    from lmic.pipeline import prepare as prepare
    from lmic.pipeline import run as run
    from lmic.plants.files import read_plant as read_plant
    from lmic.plants.plant import Plant as Plant
    from lmic.relax.grid import Grid as Grid
    from lmic.relax.relax import Relaxation as Relaxation
    from lmic.result_file import read_result as read_result
    from lmic.result_file import write_result as write_result
    from lmic.solve.registry import solvers as solvers
    from lmic.sweeps.search import bisect as bisect
    from lmic.sweeps.search import line_search as line_search
    from lmic.sweeps.sweep import sweep as sweep
    from lmic.sweeps.swept import Swept as Swept

_HOME = {
    "Diagnosis": "lmic.diagnosis.diagnose",
    "Grid": "lmic.relax.grid",
    "Plant": "lmic.plants.plant",
    "Relaxation": "lmic.relax.relax",
    "Swept": "lmic.sweeps.swept",
    "bisect": "lmic.sweeps.search",
    "compile": "lmic.pipeline",
    "cvxpy_problem": "lmic.interchange.models",
    "diagnose": "lmic.diagnosis.diagnose",
    "finish": "lmic.pipeline",
    "line_search": "lmic.sweeps.search",
    "picos_problem": "lmic.interchange.models",
    "prepare": "lmic.pipeline",
    "read_certificate": "lmic.certify.certificate_file",
    "read_plant": "lmic.plants.files",
    "read_problem": "lmic.interchange.formats",
    "read_result": "lmic.result_file",
    "report": "lmic.pages.result",
    "run": "lmic.pipeline",
    "solvers": "lmic.solve.registry",
    "sweep": "lmic.sweeps.sweep",
    "theorem": "lmic.library",
    "verify": "lmic.certify.verify",
    "write_problem": "lmic.interchange.formats",
    "write_result": "lmic.result_file",
}

__all__ = list(_HOME)


def __getattr__(name: str) -> Any:
    if name not in _HOME:
        raise AttributeError(f"module 'lmic' has no attribute '{name}'")
    return getattr(import_module(_HOME[name]), name)


def __dir__() -> list[str]:
    return sorted([*globals(), *_HOME])
