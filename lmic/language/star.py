"""``star``: the block that symmetry gives."""

from __future__ import annotations

from typing import Any, NoReturn

from lmic.errors import DefinitionError


class Star:
    """Marks a block that symmetry gives; it is no matrix and takes part in no expression."""

    def refuse(self, *operands: Any) -> NoReturn:
        """Raise DefinitionError: this is what every operator does."""
        raise DefinitionError(
            "star is part of an expression; it stands for a whole block, alone, as in PD([[P, A], [star, P]])"
        )

    __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __matmul__ = __rmatmul__ = refuse
    __truediv__ = __neg__ = __call__ = refuse
    T = I = property(refuse)  # noqa: E741

    def __repr__(self) -> str:
        return "star"

    def __reduce__(self) -> str:
        """Pickled by its name, so that there is only one."""
        return "star"


star = Star()
