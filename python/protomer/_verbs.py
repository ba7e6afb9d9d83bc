"""The verbs of protomer as functions, made from the program's table of flags. Their types are in `_verbs.pyi`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from inspect import Parameter, Signature
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from . import _protomer, results
from ._call import call, salts
from .results import *  # noqa: F403
from .results import Result

# Names that only the annotations of the functions use.
_ANNOTATIONS = (Callable, Sequence, Path, Literal, NDArray, np)
if TYPE_CHECKING:
    from distributed import Client  # noqa: F401

    from ._assembly import Assembly  # noqa: F401
    from ._body import Body  # noqa: F401


def _group(group: dict[str, Any]) -> Any:
    if not group["has_methods"]:
        (function,) = group["functions"]
        return _function(function, function["name"])
    name = "_" + group["name"].capitalize()
    methods = {method["name"]: staticmethod(_function(method, f"{name}.{method['name']}")) for method in group["functions"]}
    return type(name, (), {"__doc__": group["about"], "__module__": __name__, **methods})()


def _function(description: dict[str, Any], qualified_name: str) -> Callable[..., Result]:
    """A function with the parameters, the docstring and the result of a verb."""
    parameters: list[dict[str, Any]] = description["parameters"]
    result: type[Result] = getattr(results, description["result"])
    verb: list[str] = description["verb"]
    names = {parameter["name"] for parameter in parameters}
    places = [parameter["name"] for parameter in parameters if parameter["section"] == "place"]
    flags = {parameter["flag"]: parameter["name"] for parameter in parameters if parameter["section"] == "flag"}
    repeated = [parameter["flag"] for parameter in parameters if parameter["is_repeated"]]
    further = names & {"progress", "client", "parts"}
    signature = Signature([*map(_parameter, parameters)], return_annotation=description["result"])

    def function(*positional: Any, **keywords: Any) -> Result:
        try:
            bound = signature.bind(*positional, **keywords)
        except TypeError as error:
            raise TypeError(f"{function.__qualname__}(): {error}") from None
        bound.apply_defaults()
        given = bound.arguments
        values = {flag: given[name] for flag, name in flags.items()}
        if "salt_molar" in names:
            salt = salts(" ".join(verb), given["salt"], given["salt_molar"], required=description["requires_salt"])
            values["--salt"] = salt
        placed = [given[name] for name in places]
        return call(result, verb, placed, values, repeated=repeated, **{name: given[name] for name in further})

    function.__name__ = description["name"]
    function.__qualname__ = qualified_name
    function.__doc__ = description["doc"]
    function.__signature__ = signature  # type: ignore[attr-defined]
    function.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()} | {"return": description["result"]}
    return function


def _parameter(parameter: dict[str, Any]) -> Parameter:
    kind = Parameter.POSITIONAL_OR_KEYWORD if parameter["section"] == "place" else Parameter.KEYWORD_ONLY
    annotation = parameter["annotation"]
    if parameter["is_switch"]:
        return Parameter(parameter["name"], kind, default=False, annotation="bool")
    if parameter["required"]:
        return Parameter(parameter["name"], kind, annotation=annotation)
    return Parameter(parameter["name"], kind, default=None, annotation=f"{annotation} | None")


_functions = {group["name"]: _group(group) for group in _protomer.verbs()}
globals().update(_functions)
__all__ = [*_functions]
