"""How functions are compiled: parts of others in one go with them, those called from outside kept on the disk."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from types import FunctionType
from typing import Any, TypeVar

import numba
from numba.core.dispatcher import _FunctionCompiler
from numba.core.registry import CPUDispatcher
from numba.core.caching import FunctionCache
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler

from squama.progress import LOG, not_kept


class _Part(JITCodeLibrary):
    """Code that only compiled code calls: optimised, and made machine code, in its outermost caller, not before."""

    def add_llvm_module(self, ll_module: Any) -> None:
        """Take in code as it is."""
        self._final_module.link_in(ll_module)

    def finalize(self) -> None:
        """Leave all to the outermost caller."""
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        """Return this code and all that it calls, each once, callers before what they call."""
        whole, called = None, {}
        _gather(self, called)
        for part in called:
            own = JITCodeLibrary._get_module_for_linking(part)
            if whole is None:
                whole = own.clone()
            else:
                whole.link_in(own, preserve=True)
        return whole

    @property
    def codegen(self) -> Any:
        """What is told of the environment of the machine code, of which there is none."""
        return self

    def set_env(self, *_: Any) -> None:
        """Take note of nothing."""


def _gather(part, called):
    if part in called:
        return
    called[part] = None
    if isinstance(part, _Part):
        for other in part._linking_libraries:
            _gather(other, called)


class _Parts(Compiler):
    """Compiles such code."""

    place: Any = _Part

    def define_pipelines(self) -> Any:
        """Define the usual passes, in that place."""
        self.state.library = self.place(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        passes: Any = super()
        return passes.define_pipelines()


INNER: dict[str, Any] = {
    "pipeline_class": _Parts,
    "error_model": "numpy",
    "no_rewrites": True,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Options of a function that only compiled code calls; 1/0 = inf, without a test."""
_F = TypeVar("_F", bound=Callable[..., Any])


class _Whole(_FunctionCompiler):
    """Compiles a function for the types of arguments, not for the values of constants."""

    def fold_argument_types(self, args, kws):
        pysig, args = super().fold_argument_types(args, kws)
        return pysig, tuple(numba.types.unliteral(a) for a in args)


def making(f: _F, **options: Any) -> _F:
    """Return a function compiled, to be called by compiled code only."""
    found: _F = numba.njit(**{**INNER, "_nrt": True, **options})(f)
    if isinstance(found, CPUDispatcher):
        found._compiler.__class__ = _Whole
    return found


def part(f: _F, **options: Any) -> _F:
    """Return such a function, one that makes no array: nothing is counted that refers to those it is given.

    Counting takes longer than the work itself where it is done on parts of arrays.
    """
    return making(f, _nrt=False, **options)


def inlined(f: _F) -> _F:
    """Return such a function, whose code stands where it is called."""
    return part(f, forceinline=True)


class _Copy(FunctionCache):
    """The copy of compiled code on the disk. Where it cannot be read or written, the code is compiled in memory."""

    def __init__(self, f: FunctionType) -> None:
        parent: Any = super()
        parent.__init__(f)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """Return the copy; None where there is none, or a damaged one, which is discarded."""
        parent: Any = super()
        try:
            return parent.load_overload(sig, target_context)
        except Exception:  # damaged bytes raise errors of many kinds
            with suppress(OSError):
                parent.flush()
            return None

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write the copy; say in one line where and why it cannot be written."""
        parent: Any = super()
        try:
            parent.save_overload(sig, data)
        except (OSError, EOFError) as error:
            not_kept("compiled code", self.cache_path, error)


def kept(f: Callable[..., Any], sources: Sequence[Path], **options: Any) -> Any:
    """Return a function compiled; its copy on the disk is used as long as none of the sources changes.

    Numba itself looks at the file of this function only. Where no folder takes a copy, each process compiles anew.
    """
    assert isinstance(f, FunctionType)
    stamp = hashlib.sha256(b"".join(file.read_bytes() for file in sources)).hexdigest()
    # the files of the copy bear the digest: Numba fails on those of sources from which a module went
    f.__qualname__ = f"{f.__name__}_{stamp[:16]}"
    made = numba.njit(error_model="numpy", nogil=True, **options)(f)
    with suppress(RuntimeError):  # no place on the disk to keep compiled code
        made._cache = _Copy(f)
    return made


def is_ready(f: Any) -> bool:
    """Whether a compiled function is loaded, or likely to be found on the disk."""
    place = f.stats.cache_path
    return bool(f.signatures) or (place is not None and any(Path(place).glob(f"*{f.py_func.__qualname__}-*.nbc")))


_told: set[str] = set()


def tell(f: Any, what: str) -> None:
    """Say once that the code of something is to be compiled, where it is, and whether that recurs in each process."""
    if what in _told or is_ready(f):
        return
    _told.add(what)
    often = "once; some seconds"
    if f.stats.cache_path is None:
        often = "some seconds in each run: no folder for its cache can be written, NUMBA_CACHE_DIR sets one"
    LOG.warning("squama: compiling the code for %s, %s", what, often)
