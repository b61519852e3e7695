"""The certificates that the library keeps of its cases, proven anew before anything is said of them."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from lmic.certify.certificate import Certificate, Standing
from lmic.certify.certificate_file import read_certificate
from lmic.certify.document import decimal, decimal_above, decimal_below
from lmic.certify.verify import verify
from lmic.errors import CertificateError
from lmic.library import root
from lmic.papers.cases import Case
from lmic.plants.plant import exact_number

#: digits of a proven end in a table, rounded outwards
SHOWN = 9


@dataclass(frozen=True)
class Enclosure:
    """What is proven of a case's value; an end that is not proven is None.

    ``about_theorem`` says that the lower end bounds the theorem and not only its relaxation; with a
    ``radius`` it holds for unknowns that are all up to that in size.
    """

    standing: Standing
    lower: Fraction | None
    upper: Fraction | None
    about_theorem: bool
    radius: Fraction | None = None

    def __str__(self) -> str:
        lower = None if self.lower is None else decimal(decimal_below(self.lower, SHOWN))
        upper = None if self.upper is None else decimal(decimal_above(self.upper, SHOWN))
        within = f", the lower end for unknowns up to {float(self.radius):.0e}" if lower and self.radius else ""
        if lower and upper:
            return f"[{lower}, {upper}]{within}"
        return f"≥ {lower}{within}" if lower else f"≤ {upper}"


def folder() -> Path:
    """Where the certificates stand: beside the theorems."""
    return root().parent / "certificates"


def stored(case: Case) -> Enclosure | None:
    """The proven enclosure of a case, None if the library keeps no certificate of it.

    Raises CertificateError where the certificate belongs to another problem or does not hold.
    """
    path = folder() / f"{case.id}.json"
    if not path.is_file():
        return None
    certificate = read_certificate(path)
    asked = {name: exact_number(value) for name, value in case.given.items()}
    same = certificate.theorem == case.theorem and certificate.library_plant == case.library_plant
    if not same or any(certificate.scalars.get(name) != value for name, value in asked.items()):
        raise CertificateError(f"{path} certifies another problem than the case {case.id}; make it anew")
    return proven(certificate, case)


def proven(certificate: Certificate, case: Case) -> Enclosure:
    """The enclosure of the case's report, after the certificate is proven; raises CertificateError where it fails."""
    verdict = verify(certificate)
    if not verdict.theorem:
        raise CertificateError(f"the certificate of {case.id} does not hold: {verdict.reason}; make it anew")
    lower, upper = certificate.ends(case.report, verdict.theorem)
    radius = certificate.lower.radius if certificate.lower else None
    return Enclosure(verdict.standing, lower, upper, verdict.about_theorem, radius)
