"""What a value is, for type checkers that know nothing of what is in it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeGuard


def is_mapping(value: Any) -> TypeGuard[Mapping[Any, Any]]:
    """Whether it is a dict, or like one."""
    return isinstance(value, Mapping)


def is_sequence(value: Any) -> TypeGuard[list[Any]]:
    """Whether it is a list or a tuple."""
    return isinstance(value, (list, tuple))


def is_set(value: Any) -> TypeGuard[set[Any]]:
    """Whether it is a set, of whatever kind."""
    return isinstance(value, (set, frozenset))
