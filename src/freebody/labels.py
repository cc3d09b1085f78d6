"""Vectors whose entries carry names: dicts, pandas Series and DataFrames, xarray DataArrays and
Datasets.

A labelled vector is put into the order of the model's names, never read by position. Nothing here
imports pandas or xarray: what is labelled tells so by its attributes. Labels that only count (0, 1,
2, …), as pandas gives where nobody named anything, are none. Labels of a batch axis stay the
caller's; inputs with different times are refused.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, cast

import numpy as np

from freebody.errors import FreebodyError, UnknownNameError, no_real_numbers


def aligned(
    function: str, argument: str, value: Any, names: Sequence[str], dims: Sequence[str] = ()
) -> Any:
    """`value` without labels, its last axis in the order of `names`; what carries none comes back
    as it is.

    dims: names of the dimension of a DataArray that may stand for the vector, the most telling
    first. Raises UnknownNameError for a label that is no name, FreebodyError for one that is
    missing or there twice.
    """
    where = f"{function}: {argument}"
    if type(value) is np.ndarray or isinstance(value, (str, bytes)):
        return value
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        value = cast("NamedTuple", value)._asdict()
    if isinstance(value, (list, tuple)):
        if not any(map(is_labelled, value)):
            return value
        rows = [aligned(function, argument, row, names, dims) for row in value]
        return np.stack([np.asarray(row) for row in rows])
    if isinstance(value, Mapping):
        return _from_mapping(where, value, names)
    if _is_frame(value):
        return _taken(where, np.asarray(value), list(value.columns), names)
    if _is_series(value):
        return _taken(where, np.asarray(value), list(value.index), names)
    if _is_data_array(value):
        return _from_data_array(where, value, names, dims)
    return value


def is_labelled(value: Any) -> bool:
    """Whether a value carries names, so that its entries must be found by name and not by
    position."""
    if isinstance(value, (Mapping, np.ndarray, str, bytes)):
        return isinstance(value, Mapping)
    if _is_frame(value):
        return not _counts(list(value.columns)) or not _counts_or_measures(list(value.index))
    if _is_series(value):
        return not _counts_or_measures(list(value.index))
    if _is_data_array(value):
        return bool(_named_dims(value))
    return isinstance(value, (list, tuple)) and (
        hasattr(value, "_asdict") or any(map(is_labelled, _heads(value)))
    )


def labels_of(value: Any) -> list[Any]:
    """The labels of a labelled vector's entries; empty where there are none."""
    if isinstance(value, tuple) and hasattr(value, "_fields"):
        return list(cast("NamedTuple", value)._fields)
    if isinstance(value, Mapping):
        return list(value)
    if not is_labelled(value):
        return []
    if isinstance(value, (list, tuple)):
        return [label for row in value for label in labels_of(row)]
    table: Any = value
    if _is_frame(table):
        return list(table.columns)
    if _is_series(table):
        return list(table.index)
    return [label for d in _named_dims(table) for label in table.coords[d].values.tolist()]


def row_times(value: Any) -> np.ndarray | None:
    """The times (s), or other numbers with fractions, that label the rows of a table; None where
    there are none.

    Whole numbers count rows, unless they are called t or time.
    """
    if isinstance(value, Mapping):
        found = (row_times(value[name]) for name in value)
        return next((times for times in found if times is not None), None)
    if _is_frame(value) or _is_series(value):
        labels = {value.index.name: np.asarray(value.index)}
    elif _is_data_array(value):
        labels = {d: np.asarray(value.coords[d].values) for d in value.dims if d in value.coords}
    else:
        return None
    for name, given in labels.items():
        if given.dtype.kind == "m":
            return given.astype("timedelta64[ns]").astype(float) * 1e-9
        if given.dtype.kind == "f" or (given.dtype.kind in "iu" and name in ("t", "time")):
            return given.astype(float)
    return None


def refuse_other_times(function: str, given: Mapping[str, Any]) -> None:
    """Refuse inputs whose rows are labelled with different times, since combining them by position
    would mix them up."""
    first: tuple[str, np.ndarray] | None = None
    for name, value in given.items():
        times = None if type(value) is np.ndarray else row_times(value)
        if times is None:
            continue
        if first is None:
            first = name, times
        elif not np.array_equal(first[1], times):
            raise FreebodyError(
                f"{function}: the rows of {name} are labelled with other times than those of "
                f"{first[0]}; align them first."
            )


def refuse_labelled(where: str, value: Any) -> None:
    """Refuse labelled and masked values where only the position of an entry gives it its
    meaning."""
    if type(value) is np.ndarray:
        return
    refuse_masked(where, value)
    if is_labelled(value):
        raise FreebodyError(
            f"{where} is a {type(value).__name__} with labels, and this is read by position; "
            "give a plain array, such as x.to_numpy(), in the order that is meant."
        )


def refuse_masked(where: str, value: Any) -> None:
    """Refuse values with masked entries: these are missing, and the numbers under the mask mean
    nothing."""
    rows = value if isinstance(value, (list, tuple)) else [value]
    if any(isinstance(row, np.ma.MaskedArray) and np.ma.is_masked(row) for row in rows):
        raise FreebodyError(
            f"{where} has masked entries, which are missing; give numbers in their place, or leave "
            f"the samples out."
        )


def _heads(value: Sequence[Any]) -> list[Any]:
    """One entry of each type that occurs in a list."""
    return list({type(entry): entry for entry in value}.values())


def _is_frame(value: Any) -> bool:
    return hasattr(value, "columns") and hasattr(value, "to_numpy")


def _is_series(value: Any) -> bool:
    return hasattr(value, "index") and hasattr(value, "to_numpy") and not callable(value.index)


def _is_data_array(value: Any) -> bool:
    return hasattr(value, "dims") and hasattr(value, "coords")


def _counts(labels: list[Any]) -> bool:
    return labels == list(range(len(labels)))


def _counts_or_measures(labels: list[Any]) -> bool:
    return not any(isinstance(label, (str, tuple)) for label in labels)


def _taken(where: str, array: Any, labels: list[Any], names: Sequence[str]) -> Any:
    """The array with its last axis, which has the given labels, put into the order of names."""
    if _counts(labels):
        return array
    for label in labels:
        if label not in names:
            raise UnknownNameError("entry", label, where, names)
        if labels.count(label) > 1:
            raise FreebodyError(f"{where} has {label!r} twice; give each entry once.")
    missing = [name for name in names if name not in labels]
    if missing:
        raise FreebodyError(
            f"{where} lacks {', '.join(missing)}; give every entry, 0 where it rests."
        )
    return array[..., [labels.index(name) for name in names]]


def _named_dims(value: Any) -> list[str]:
    """The dimensions of a DataArray whose coordinates are names."""
    return [d for d in value.dims if d in value.coords and value.coords[d].dtype.kind in "UOST"]


def _from_data_array(where: str, value: Any, names: Sequence[str], dims: Sequence[str]) -> Any:
    own = [d for d in dims if d in value.dims][:1] or _named_dims(value)
    if len(own) > 1:
        raise FreebodyError(
            f"{where} has names along {' and '.join(map(repr, own))}; call the vector's dimension "
            f"{' or '.join(map(repr, dims))}."
        )
    if not own:
        return value.values
    (dim,) = own
    array = value.transpose(..., dim).values
    return (
        _taken(where, array, value.coords[dim].values.tolist(), names)
        if dim in value.coords
        else array
    )


def _from_mapping(where: str, given: Mapping[str, Any], names: Sequence[str]) -> Any:
    """A vector from {name: value or batch}; every entry must be there."""
    if hasattr(given, "to_dataarray"):
        # a Dataset: its variables may have their dimensions in any order
        _taken(where, np.empty(len(given)), list(given), names)
        dataset: Any = given
        return dataset[list(names)].to_dataarray("_entry").transpose(..., "_entry").values
    _taken(where, np.empty(len(given)), list(given), names)
    _refuse_other_rows(where, given)
    for name in names:
        refuse_masked(f"{where}[{name!r}]", given[name])
    columns = [np.asarray(given[name]) for name in names]
    for name, column in zip(names, columns, strict=True):
        if column.dtype.kind not in "iufb":
            raise FreebodyError(no_real_numbers(f"{where}[{name!r}]", column))
    try:
        return np.stack(np.broadcast_arrays(*columns), axis=-1)
    except ValueError:
        function, argument = where.split(": ", 1)
        shapes = ", ".join(
            f"{argument}[{name!r}] {x.shape}" for name, x in zip(names, columns, strict=True)
        )
        raise FreebodyError(
            f"{function}: the batch shapes do not broadcast together: {shapes}."
        ) from None


def _refuse_other_rows(where: str, given: Mapping[str, Any]) -> None:
    """Refuse columns whose own labels (times, say) are not the same."""
    seen: dict[str, Any] = {}
    for name, column in given.items():
        if _is_series(column):
            labels: Any = list(column.index)
        elif _is_data_array(column):
            labels = [
                column.dims,
                *(column.coords[d].values.tolist() for d in column.dims if d in column.coords),
            ]
        else:
            continue
        other = next(iter(seen), name)
        if seen.setdefault(other, labels) != labels:
            raise FreebodyError(
                f"{where}: the rows of {name!r} are labelled otherwise than those of {other!r}; "
                f"align them first."
            )
