"""Errors to plant: one small change of the source at a time, found on the syntax tree, applied to the text."""

from __future__ import annotations

import ast
import collections
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

SIGNS = {ast.Add: ("+", "-"), ast.Sub: ("-", "+")}
FACTORS = {ast.Mult: ("*", "/"), ast.Div: ("/", "*")}
LOGIC = {ast.BitAnd: ("&", "|"), ast.BitOr: ("|", "&")}
COMPARISONS = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", ">"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", "<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
}
PARTNERS = (
    ("sin", "cos"),
    ("min", "max"),
    ("minimum", "maximum"),
    ("argmin", "argmax"),
    ("floor", "ceil"),
    ("any", "all"),
    ("sa", "ca"),
    ("sn", "cs"),
    ("st", "ct"),
    ("zX", "zZ"),
    ("a_rate", "c_rate"),
    ("slip_x", "slip_y"),
    ("theta_rate", "load_rate"),
    ("M_N", "M_f"),
    ("k_ZX", "k_ZY"),
    ("k_YZ", "k_ZZ"),
    ("beta", "lam"),
    ("eta", "beta"),
)
"""Names that are easily taken for each other: each is put in the other's place."""
SWAP = dict(PARTNERS) | {b: a for a, b in PARTNERS if b not in dict(PARTNERS)}
UNSEEN = {"strict", "frozen", "kw_only", "eq", "flush", "stacklevel", "maxsize"}
"""Arguments that no result depends on; what stands for them is left alone."""
PERIODS = ("k", "j")
"""Names of the neighbour: a factor or divisor k is also dropped."""


@dataclass(frozen=True, order=True)
class Mutant:
    """Replace `old` by `new` at `start` of the text of `file` (relative to src/squama)."""

    file: str
    line: int
    start: int
    old: str
    new: str
    text: str
    """The line, stripped; with `change` it names the mutant as long as the line stays as it is."""
    nth: int = 1

    @property
    def change(self) -> str:
        """What is changed, numbered where the line, or lines that read the same, hold the change more than once."""
        number = "" if self.nth == 1 else f" #{self.nth}"
        return f"{self.old} -> {self.new or 'nothing'}{number}"

    def apply(self, source: str) -> str:
        """Return the source with the error in it."""
        assert source.startswith(self.old, self.start), self
        return source[: self.start] + self.new + source[self.start + len(self.old) :]


class _Finder(ast.NodeVisitor):
    """Collects (start, old, new) of every change in code that is executed."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.lines = [0]
        for line in source.splitlines(keepends=True):
            self.lines.append(self.lines[-1] + len(line))
        self.found: list[tuple[int, str, str]] = []
        self.names: set[str] = set()
        self.fields: set[str] = set()

    def place(self, line: int, column: int) -> int:
        return self.lines[line - 1] + column

    def start(self, node: ast.expr) -> int:
        return self.place(node.lineno, node.col_offset)

    def end(self, node: ast.expr) -> int:
        assert node.end_lineno is not None
        assert node.end_col_offset is not None
        return self.place(node.end_lineno, node.end_col_offset)

    def swap(self, left: int, right: int, old: str, new: str) -> None:
        """Replace an operator that stands between two places."""
        at = self.source.find(old, left, right)
        if at >= 0:
            self.found.append((at, old, new))

    # what is not executed, or only read by people
    def visit_Expr(self, node: ast.Expr) -> None:
        if not isinstance(node.value, ast.Constant):
            self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_Module(self, node: ast.Module) -> None:
        self.fields = {n.attr for n in ast.walk(node) if isinstance(n, ast.Attribute)}
        self.generic_visit(node)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        inside = list(ast.walk(node))
        outer, self.names = self.names, {n.id for n in inside if isinstance(n, ast.Name)} | self.names
        self.names |= {n.arg for n in inside if isinstance(n, ast.arg)}
        for default in (*node.args.defaults, *(d for d in node.args.kw_defaults if d is not None)):
            self.visit(default)
        for statement in node.body:
            self.visit(statement)
        self.names = outer

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass

    def visit_Import(self, node: ast.Import) -> None:
        pass

    def visit_keyword(self, node: ast.keyword) -> None:
        if node.arg not in UNSEEN:
            self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        pass

    def visit_BinOp(self, node: ast.BinOp) -> None:
        left, right = self.end(node.left), self.start(node.right)
        for table in (SIGNS, FACTORS, LOGIC):
            if type(node.op) in table:
                self.swap(left, right, *table[type(node.op)])
        name = getattr(node.right, "id", None) or getattr(node.right, "attr", None)
        if name in PERIODS and type(node.op) in FACTORS:
            self.found.append((left, self.source[left : self.end(node.right)], ""))
        self.generic_visit(node)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        for table in (SIGNS, FACTORS, LOGIC):
            if type(node.op) in table:
                old, new = table[type(node.op)]
                self.swap(self.end(node.target), self.start(node.value), f"{old}=", f"{new}=")
        self.generic_visit(node)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        sign = {ast.USub: "-", ast.Invert: "~", ast.Not: "not "}.get(type(node.op))
        if sign:
            self.found.append((self.start(node), sign, ""))
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        left: ast.expr = node.left
        for op, right in zip(node.ops, node.comparators, strict=True):
            if type(op) in COMPARISONS:
                self.swap(self.end(left), self.start(right), *COMPARISONS[type(op)])
            left = right
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        old, new = ("and", "or") if isinstance(node.op, ast.And) else ("or", "and")
        for left, right in zip(node.values, node.values[1:], strict=False):
            self.swap(self.end(left), self.start(right), old, new)
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool):
            self.found.append((self.start(node), str(node.value), str(not node.value)))
        elif isinstance(node.value, int | float):
            old = self.source[self.start(node) : self.end(node)]
            new = {"0": "1", "0.0": "1.0", "1": "2", "1.0": "2.0", "2": "1", "2.0": "1.0"}.get(old, f"({old} * 2 + 1)")
            if isinstance(node.value, float) and new.startswith("("):
                new = f"({old} * 1.1)"
            self.found.append((self.start(node), old, new))

    def visit_Call(self, node: ast.Call) -> None:
        if isinstance(node.func, ast.Name) and node.func.id == "abs":
            self.found.append((self.start(node), "abs", ""))
        self.generic_visit(node)

    def visit_Name(self, node: ast.Name) -> None:
        # a name that is not there would be found by any test
        if isinstance(node.ctx, ast.Load) and SWAP.get(node.id) in self.names:
            self.found.append((self.start(node), node.id, SWAP[node.id]))

    def visit_Attribute(self, node: ast.Attribute) -> None:
        if isinstance(node.ctx, ast.Load) and SWAP.get(node.attr) in self.fields:
            self.found.append((self.end(node) - len(node.attr), node.attr, SWAP[node.attr]))
        self.generic_visit(node)


def mutants(root: Path, file: str) -> Iterator[Mutant]:
    """Every error of a file, in the order of the text."""
    source = (root / file).read_text(encoding="utf-8")
    finder = _Finder(source)
    finder.visit(ast.parse(source))
    lines, seen = source.splitlines(), collections.Counter[tuple[str, str, str]]()
    for start, old, new in sorted(set(finder.found)):
        line = source.count("\n", 0, start) + 1
        text = lines[line - 1].strip()
        seen[text, old, new] += 1
        yield Mutant(file, line, start, old, new, text, seen[text, old, new])


def by_hand(root: Path, file: str, old: str, new: str) -> Mutant:
    """Return a written error; the old text stands once in the file."""
    source = (root / file).read_text(encoding="utf-8")
    if source.count(old) != 1:
        message = f"{file}: {old!r} stands there {source.count(old)} times, not once: correct tests/mutants/known.py"
        raise SystemExit(message)
    start = source.index(old)
    line = source.count("\n", 0, start) + 1
    return Mutant(file, line, start, old, new, source.splitlines()[line - 1].strip())
