"""Check a theorem file: every fault and every doubt, each at its line."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any, TypeGuard

import sympy as sp

from lmic.authoring.execution import DECLARED, Execution, Failure, Unwritten, execute, word_of, written_rows
from lmic.compiler.lower import check_formulas, lowered
from lmic.compiler.terms import objective, split
from lmic.errors import DefinitionError, LibraryError, LmicError, Place
from lmic.faults import collect
from lmic.language.declarations import Given, ScalarUnknown, SymbolicSize
from lmic.language.lmi import LMI
from lmic.language.nodes import Leaf
from lmic.language.parameters import Parameter
from lmic.language.theorem import Theorem
from lmic.library import Located


@dataclass(frozen=True)
class Finding:
    """A fault, or a doubt that keeps nothing from working, at its file and line (None: no line says it).

    ``kind`` is the name of the error that compiling raises for it, or "unused".
    """

    fault: bool
    kind: str
    file: Path
    line: int | None
    place: Place
    reason: str

    def __str__(self) -> str:
        where = f"{self.file}:{self.line}" if self.line else str(self.file)
        place = f"{self.place}: " if str(self.place) else ""
        return f"{where}: {place}{self.reason}"


@dataclass(frozen=True)
class CheckedLMI:
    """An LMI as written, the sizes of its block rows, and the blocks that hold a fault (from 1)."""

    lmi: LMI
    partition: tuple[sp.Expr, ...]
    faulty: frozenset[tuple[int, int]]


@dataclass(frozen=True)
class Checkup:
    """What was found, the LMIs, and the theorem, where the file states one."""

    findings: list[Finding]
    lmis: Mapping[str, CheckedLMI]
    theorem: Theorem | None

    @property
    def sound(self) -> bool:
        """Whether there is no fault; unused declarations are none."""
        return not any(finding.fault for finding in self.findings)


def check(located: Located) -> Checkup:
    """Check the theorem of a file; raises LibraryError only where there is no such file or variant."""
    examination = _Examination(execute(located.path), located.name)
    theorem, stated = examination.statement()
    if theorem and located.variant and located.variant not in theorem.variants:
        has = ", ".join(theorem.variants) or "none"
        raise LibraryError(f"{located.path.stem} has no variant '{located.variant}'; it has {has}")
    lmis = {name: examination.lmi(name, lmi) for name, lmi in stated.items()}
    examination.failures()
    if theorem:
        examination.formulas(theorem)
        examination.unused(theorem)
        examination.unstated(theorem)
    findings = sorted(examination.findings, key=lambda finding: finding.line or 0)
    return Checkup(findings, lmis, theorem)


class _Examination:
    """One file under examination; ``findings`` grows with each part that is looked at."""

    def __init__(self, execution: Execution, name: str) -> None:
        self.execution, self.name = execution, name
        self.findings: list[Finding] = []
        self.told: set[int] = set()

    def statement(self) -> tuple[Theorem | None, Mapping[str, LMI]]:
        """The theorem and its LMIs; where it contradicts itself or is missing, the LMIs as far as they go."""
        found = self.execution.namespace.get("theorem")
        if isinstance(found, Theorem):
            return found, found.lmis
        for failure in self.execution.failures:
            error = failure.error
            if isinstance(error, DefinitionError) and isinstance(error.theorem, Theorem):
                return error.theorem, error.theorem.lmis
        if not self.execution.failures:
            self._add(DefinitionError("there is no theorem in the file; end it with theorem = Theorem(...)"), None)
        lmis: dict[str, LMI] = {}
        for lmi, call in self.execution.calls:
            if isinstance(lmi, LMI):
                same = sum(name.startswith(f"line {call.lineno}") for name in lmis)
                lmis[f"line {call.lineno}" + (f", number {same + 1}" if same else "")] = lmi
        return None, lmis

    def lmi(self, name: str, lmi: LMI) -> CheckedLMI:
        """Look at one LMI: its shape, its symmetry, its blocks, and whether they are affine."""
        call = self.execution.call_of(lmi)
        faults, symbolic = collect(lowered(lmi, Place(self.name, name)))
        for (i, j), block in symbolic.blocks.items():
            faults += collect(split(block, symbolic.place.at((i + 1, j + 1))))[0]
        for fault in faults:
            at = fault.place.block
            entry = lmi.rows[at[0] - 1][at[1] - 1] if at else None
            if not isinstance(entry, Unwritten):
                self._add(fault, _block_line(call, at))
            elif entry.failure:
                self._add_failure(entry.failure, fault.place)
        return CheckedLMI(lmi, symbolic.partition, frozenset(f.place.block for f in faults if f.place.block))

    def failures(self) -> None:
        """What the file raised, and is not told of a block already."""
        for failure in self.execution.failures:
            error = failure.error
            if isinstance(error, DefinitionError) and error.faults:
                call = next((node for node in ast.walk(failure.node or ast.Pass()) if _is_theorem(node)), None)
                for fault in error.faults:
                    self._add(fault, _part_line(call, fault.place.part) or failure.line)
            else:
                self._add_failure(failure, Place())

    def formulas(self, theorem: Theorem) -> None:
        """What is wrong outside the LMIs."""
        call = self.execution.call_of(theorem)
        for fault in [*collect(check_formulas(theorem))[0], *collect(objective(theorem))[0]]:
            self._add(fault, _part_line(call, fault.place.part))

    def unused(self, theorem: Theorem) -> None:
        """Declarations that the theorem does not need; what occurs in something that failed is not counted."""
        nodes = theorem.nodes + theorem.extras
        leaves = [leaf for node in nodes for leaf in node.leaves()]
        sizes = {size for leaf in leaves for extent in leaf.shape for size in extent.free_symbols}
        sizes |= {size for node in nodes for size in node.atoms(SymbolicSize)}
        used = {leaf.name for leaf in leaves} | {symbol.name for symbol in theorem.scalar_symbols | sizes}
        used |= {symbol.name for value in theorem.reports.values() for symbol in sp.sympify(value).free_symbols}
        used |= set(theorem.parameters)
        named = {value.name for name, value in self.execution.namespace.items() if self._is_excused(name, value)}
        for name, (declared, line) in self.execution.declared.items():
            if name not in used | named:
                reason = f"the {_what(declared)} {name} is declared and not used; use it or remove it"
                self.findings.append(Finding(False, "unused", self.execution.path, line, Place(self.name), reason))

    def unstated(self, theorem: Theorem) -> None:
        """LMIs that the theorem does not state, as where a later one has the same name."""
        for lmi, call in self.execution.calls:
            if isinstance(lmi, LMI) and not any(lmi is stated for stated in theorem.lmis.values()):
                reason = "an LMI is written and not stated; give it a name of its own in lmis, or remove it"
                self.findings.append(
                    Finding(False, "unused", self.execution.path, call.lineno, Place(self.name), reason)
                )

    def _is_excused(self, name: str, value: Any) -> bool:
        return name in self.execution.mentioned and isinstance(value, DECLARED)

    def _add_failure(self, failure: Failure, place: Place) -> None:
        """What Python or lmic raised in the file, once."""
        error = failure.error
        if id(failure) in self.told:
            return
        self.told.add(id(failure))
        if isinstance(error, LmicError):
            self._add(type(error)(error.reason, place), failure.line)
        elif isinstance(error, SyntaxError):
            self._add(DefinitionError(f"{error.msg}; correct the Python there", place), failure.line)
        else:
            near = get_close_matches(str(getattr(error, "name", "")), self.execution.namespace, 1)
            mend = f"did you mean {near[0]}?" if near and isinstance(error, NameError) else "correct the line"
            said = " ".join(str(error).split())
            self._add(DefinitionError(f"{type(error).__name__}: {said}; {mend}", place), failure.line)

    def _add(self, fault: LmicError, line: int | None) -> None:
        place = replace(fault.place, theorem=self.name)
        self.findings.append(Finding(True, type(fault).__name__, self.execution.path, line, place, fault.reason))


def _block_line(call: ast.Call | None, block: tuple[int, int] | None) -> int | None:
    """Line of a block in the call of PD or ND, of the call where its matrix is not written out."""
    if call is None:
        return None
    rows = written_rows(call.args[0]) if call.args else []
    return rows[block[0] - 1][block[1] - 1].lineno if rows and block else call.lineno


def _part_line(call: ast.Call | None, part: tuple[str, ...]) -> int | None:
    """Line of an argument of Theorem(...), or of the deepest word of the part that is written in it."""
    if call is None:
        return None
    argument = next((keyword.value for keyword in call.keywords if part and keyword.arg == part[0]), None)
    if argument is None:
        return call.lineno
    line = argument.lineno
    for word in part[1:]:
        for node in ast.walk(argument):
            if isinstance(node, ast.Constant) and node.value == word:
                line = node.lineno
            elif isinstance(node, ast.keyword) and node.arg == word:
                line = node.value.lineno
    return line


def _is_theorem(node: ast.AST) -> TypeGuard[ast.Call]:
    return isinstance(node, ast.Call) and word_of(node) == "Theorem"


def _what(declared: Any) -> str:
    """What a declaration declares."""
    if isinstance(declared, Leaf):
        return "data" if declared.role == "data" else "unknown"
    kinds = {ScalarUnknown: "scalar unknown", Given: "given scalar", Parameter: "parameter", SymbolicSize: "dimension"}
    return next(name for kind, name in kinds.items() if isinstance(declared, kind))
