"""Whether a method still belongs to another one, which a subclass may have replaced."""

from __future__ import annotations


def belongs_to(instance: object, method: str, other: str) -> bool:
    """Whether an object has a method, and no subclass of the class that defines it has replaced another one.

    Args:
        instance: the object.
        method: name of the method, such as that of a derivative.
        other: name of the method that it belongs to.
    """
    for cls in type(instance).__mro__:
        if method in vars(cls):
            return callable(getattr(instance, method)) and other not in vars(instance)
        if other in vars(cls):
            return False
    return False
