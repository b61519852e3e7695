"""The sets that parameters range over."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lmic.errors import DomainError


class Domain(ABC):
    """A polytope of parameter values; ``components`` name its coordinates."""

    kind: str
    components: tuple[str, ...]

    @property
    @abstractmethod
    def vertices(self) -> NDArray[Any]:
        """Vertices, shape (V, components)."""

    @abstractmethod
    def sample(self, count: int, generator: np.random.Generator) -> NDArray[Any]:
        """Random points, shape (count, components)."""


@dataclass(frozen=True)
class SimplexDomain(Domain):
    """The unit simplex; its components are nonnegative and sum to one."""

    components: tuple[str, ...]
    kind = "simplex"

    def __post_init__(self) -> None:
        if not self.components:
            raise DomainError("a simplex has no vertex; give at least one")

    @classmethod
    def named(cls, parameter: str, vertices: int) -> SimplexDomain:
        return cls(tuple(f"{parameter}{i + 1}" for i in range(vertices)))

    @property
    def vertices(self) -> NDArray[Any]:
        return np.eye(len(self.components))

    def sample(self, count: int, generator: np.random.Generator) -> NDArray[Any]:
        return generator.dirichlet(np.ones(len(self.components)), size=count)

    def __str__(self) -> str:
        return f"unit simplex with {len(self.components)} vertices"


@dataclass(frozen=True)
class BoxDomain(Domain):
    """Every component in its own interval, with exact ends."""

    components: tuple[str, ...]
    lower: tuple[Fraction, ...]
    upper: tuple[Fraction, ...]
    kind = "box"

    def __post_init__(self) -> None:
        for name, low, high in zip(self.components, self.lower, self.upper, strict=True):
            if low > high:
                raise DomainError(f"the interval of {name} is empty: [{low}, {high}]; give its lower end first")

    @property
    def vertices(self) -> NDArray[Any]:
        ends = [(float(a), float(b)) for a, b in zip(self.lower, self.upper, strict=True)]
        return np.array(list(product(*ends)))

    def sample(self, count: int, generator: np.random.Generator) -> NDArray[Any]:
        low, high = np.array(self.lower, dtype=float), np.array(self.upper, dtype=float)
        return low + generator.random((count, len(low))) * (high - low)

    def __str__(self) -> str:
        sides = zip(self.components, self.lower, self.upper, strict=True)
        return " x ".join(f"{name} in [{float(a):g}, {float(b):g}]" for name, a, b in sides)
