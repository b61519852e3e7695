"""Run a theorem file so that all its faults come to light, and remember where everything was built.

The file is run one top-level statement after another, and goes on after one that fails; what needs a name
that the failed statement should have set fails as a consequence and is not told. Blocks written out in PD and
ND are evaluated one by one, so that a fault in one leaves the others to be checked.
"""

from __future__ import annotations

import ast
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from lmic.errors import LibraryError
from lmic.language.declarations import NamedScalar, SymbolicSize
from lmic.language.lmi import LMI
from lmic.language.nodes import Leaf
from lmic.language.parameters import Parameter
from lmic.language.theorem import Theorem
from lmic.library import line_of

#: words whose calls build what is looked for later
LMI_WORDS = ("PD", "ND")
DECLARING_WORDS = (
    *("Data", "Matrix", "Symmetric", "Diagonal", "BlockDiagonal", "Scalar", "given", "dims"),
    *("Parameter", "Simplex", "Box"),
)
DECLARED = (Leaf, NamedScalar, SymbolicSize, Parameter)
BUILDING_WORDS = (*LMI_WORDS, *DECLARING_WORDS, "Theorem")


@dataclass(frozen=True)
class Failure:
    """What Python or lmic raised in the file, the line, and the statement or block that it ended."""

    line: int | None
    error: BaseException
    node: ast.AST | None = None


@dataclass(frozen=True)
class Unwritten:
    """Stands for a block whose expression failed; ``failure`` is None where another fault is the cause."""

    failure: Failure | None


@dataclass
class Execution:
    """What a theorem file built, where, and what failed.

    ``namespace`` holds the file's names; ``calls`` the LMIs and theorems with the call that built them;
    ``declared`` the declared matrices, scalars, parameters and dimensions by name, with the line;
    ``mentioned`` the names that occur in what failed and ``lost`` those that it should have set; ``sites`` and
    ``entries`` the calls and blocks by the numbers that the instrumented file knows them by.
    """

    path: Path
    namespace: dict[str, Any] = field(default_factory=dict)
    failures: list[Failure] = field(default_factory=list)
    calls: list[tuple[LMI | Theorem, ast.Call]] = field(default_factory=list)
    declared: dict[str, tuple[Any, int]] = field(default_factory=dict)
    mentioned: set[str] = field(default_factory=set)
    lost: set[str] = field(default_factory=set)
    sites: list[ast.Call] = field(default_factory=list)
    entries: list[ast.expr] = field(default_factory=list)

    def call_of(self, built: Any) -> ast.Call | None:
        """The call that built an LMI or a theorem, where that is in the file."""
        return next((call for found, call in self.calls if found is built), None)

    def fail(self, error: BaseException, node: ast.AST) -> Failure | None:
        """Take note of what a statement or block raised; None where it is the consequence of an earlier failure."""
        self.mentioned |= {name.id for name in ast.walk(node) if isinstance(name, ast.Name)}
        if isinstance(error, NameError) and error.name in self.lost:
            return None
        line = error.lineno if isinstance(error, SyntaxError) else line_of(self.path, error)
        return Failure(line or getattr(node, "lineno", None), error, node)

    # what the instrumented file calls

    def built(self, number: int, value: Any) -> Any:
        """Remember what a call in the file returned."""
        call = self.sites[number]
        if isinstance(value, (LMI, Theorem)):
            self.calls.append((value, call))
        for one in value if isinstance(value, tuple) else (value,):
            if isinstance(one, DECLARED):
                self.declared.setdefault(one.name, (one, call.lineno))
        return value

    def entry(self, number: int, evaluate: Callable[[], Any]) -> Any:
        """A block, or what stands for it where its expression fails."""
        try:
            return evaluate()
        except Exception as error:  # the user's expression may raise anything
            failure = self.fail(error, self.entries[number])
            if failure:
                self.failures.append(failure)
            return Unwritten(failure)

    def matrix(self, number: int, evaluate: Callable[[], Any]) -> Any:
        """What PD and ND are given in one piece: the same."""
        value = self.entry(number, evaluate)
        return [[value]] if isinstance(value, Unwritten) else value


def execute(path: Path) -> Execution:
    """Run a theorem file; raises LibraryError only where it cannot be read."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise LibraryError(
            f"{path} cannot be read ({error.strerror}); give the path of a theorem file or a name of the library"
        ) from error
    execution = Execution(path)
    try:
        module = ast.parse(content, filename=str(path))
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        execution.failures.append(Failure(getattr(error, "lineno", None), error))
        return execution
    execution.namespace = {
        "__name__": f"lmic_theorem_{path.stem}",
        "__file__": str(path),
        "__doc__": ast.get_docstring(module),
        "__built__": execution.built,
        "__entry__": execution.entry,
        "__matrix__": execution.matrix,
    }
    for statement in module.body:
        _run(statement, execution)
    return execution


def _run(statement: ast.stmt, execution: Execution) -> None:
    """Run one statement; names that it should have set and did not are lost."""
    assigned = {n.id for n in ast.walk(statement) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    try:
        instrumented = ast.fix_missing_locations(_Instrument(execution).visit(statement))
        code = compile(ast.Module([instrumented], []), str(execution.path), "exec", dont_inherit=True)
        exec(code, execution.namespace)
    except (Exception, SystemExit) as error:  # the user's file may raise anything
        failure = execution.fail(error, statement)
        if failure:
            execution.failures.append(failure)
        execution.lost |= assigned - set(execution.namespace)


class _Instrument(ast.NodeTransformer):
    """Has the file tell what its calls return, and evaluates the blocks of an LMI one by one."""

    def __init__(self, execution: Execution) -> None:
        self.execution = execution

    def visit_Call(self, node: ast.Call) -> ast.AST:
        """``PD([[P, A]])`` becomes ``__built__(0, PD([[__entry__(0, lambda: P), __entry__(1, lambda: A)]]))``."""
        self.generic_visit(node)
        word = word_of(node)
        if word not in BUILDING_WORDS:
            return node
        if word in LMI_WORDS and len(node.args) == 1:
            rows = written_rows(node.args[0])
            for row in rows:
                row[:] = [self._later("__entry__", entry) for entry in row]
            node.args[:] = node.args if rows else [self._later("__matrix__", node.args[0])]
        self.execution.sites.append(node)
        return self._tell("__built__", len(self.execution.sites) - 1, node)

    def visit_ClassDef(self, node: ast.ClassDef) -> ast.AST:
        """Left as it is: in a class a lambda does not see the names around it."""
        return node

    def _later(self, function: str, entry: ast.expr) -> ast.expr:
        if any(isinstance(part, (ast.NamedExpr, ast.Await, ast.Yield, ast.YieldFrom)) for part in ast.walk(entry)):
            return entry
        self.execution.entries.append(entry)
        nothing = ast.arguments(posonlyargs=[], args=[], kwonlyargs=[], kw_defaults=[], defaults=[])
        later = ast.copy_location(ast.Lambda(nothing, entry), entry)
        return self._tell(function, len(self.execution.entries) - 1, later)

    def _tell(self, function: str, number: int, value: ast.expr) -> ast.expr:
        name = ast.copy_location(ast.Name(function, ast.Load()), value)
        return ast.copy_location(ast.Call(name, [ast.copy_location(ast.Constant(number), value), value], []), value)


def word_of(call: ast.Call) -> str:
    """The name of the function that is called, without the module before it."""
    return call.func.id if isinstance(call.func, ast.Name) else str(getattr(call.func, "attr", ""))


def written_rows(matrix: ast.expr) -> list[list[ast.expr]]:
    """The entries of a matrix that is written out as a list of lists, else nothing."""
    if not isinstance(matrix, (ast.List, ast.Tuple)):
        return []
    rows = [row.elts for row in matrix.elts if isinstance(row, (ast.List, ast.Tuple))]
    plain = len(rows) == len(matrix.elts) and not any(isinstance(e, ast.Starred) for row in rows for e in row)
    return rows if plain else []
