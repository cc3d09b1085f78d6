"""Numbers of a model as inputs of its kernels: gathered by name in one last argument p."""

from __future__ import annotations

from collections.abc import Callable, Container, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats
from freebody.elementary import Scalar, cos, sin
from freebody.errors import FreebodyError, MissingValueError, ModelError
from freebody.lazy import cached_property
from freebody.model.families import of_member
from freebody.model.model import Model
from freebody.model.named_numbers import ModelParameter, Name, Parameters, found, known, written
from freebody.model.parameter_formulas import FollowingParameter
from freebody.model.parameters import Parameter, Quantity, each_parameter
from freebody.model.quantity_reader import QuantityReader, exact_sin_cos
from freebody.model.tree import Tree, lower
from freebody.targets import Kernel, KernelError
from freebody.targets.call_errors import BatchError


@dataclass(frozen=True)
class Placeholder(Parameter):
    """A parameter in a model that marks the place of a number given to the kernel."""

    index: int = 0


class InputReader(QuantityReader):
    """A reader of a model's quantities: placeholders become scalars, everything else numbers."""

    def __init__(self, scalars: Sequence[Scalar]):
        self.scalars = scalars

    def quantity(self, q: Quantity) -> Scalar:
        return self.scalars[q.index] if isinstance(q, Placeholder) else super().quantity(q)

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        read = self.quantity(angle)
        return exact_sin_cos(read) if isinstance(read, float) else (sin(read), cos(read))


@dataclass(frozen=True)
class KernelInputs:
    """The numbers of a model that a kernel takes as entries of its last argument p: their names in
    the order of `fb.parameters`, the model's own values, and the model."""

    names: tuple[str, ...]
    values: Array
    """(..., k): NaN where a symbol has no value; of a family its shape stands in front."""
    model: Model

    @cached_property
    def opened(self) -> Model:
        """The model with placeholders for the numbers that the kernel takes."""
        places = {name: Placeholder(f"p{k}", None, k) for k, name in enumerate(self.names)}
        return written(self.model, places)

    def tree(self, scalars: Sequence[Scalar]) -> Tree:
        """The model's tree with scalars for the numbers that the kernel takes; refuses further
        symbols that the tree needs."""
        opened = self.opened
        try:
            return lower(opened, InputReader(scalars))
        except ModelError:
            left = {
                x.name
                for x in each_parameter(opened)
                if x.value is None and not isinstance(x, Placeholder | FollowingParameter)
            }
            if left:
                raise MissingValueError(
                    f"what is not an input of a kernel of {opened.name!r}", left
                ) from None
            raise

    @cached_property
    def at(self) -> dict[str, int]:
        """The index of each named entry of p."""
        return {name: k for k, name in enumerate(self.names)}

    @cached_property
    def missing(self) -> tuple[str, ...]:
        """The names of entries of p that have no value in the model."""
        lacking = (np.isnan(self.values[..., k]).any() for k in range(len(self.names)))
        return tuple(name for name, lacks in zip(self.names, lacking, strict=True) if lacks)

    def place(self, key: Name) -> int:
        """The index in p of a number by name; refuses numbers that are no input of the kernel."""
        name = found(known(self.model), key, self.model)
        if name not in self.at:
            raise FreebodyError(
                f"fb.kernel: {name!r} is not an input of this kernel; name it in inputs=. Its "
                f"inputs: {', '.join(self.names)}."
            )
        return self.at[name]

    def require(self, given: Container[int]) -> None:
        """Raise MissingValueError where an entry of p is not given and has no value in the
        model."""
        missing = {name for name in self.missing if self.at[name] not in given}
        if missing:
            raise MissingValueError(f"the inputs of a kernel of {self.model.name!r}", missing)


def inputs_of(function: str, model: Model, wanted: Sequence[Name]) -> KernelInputs:
    """The kernel inputs that names and patterns select, and all numbers in which members of a
    family differ."""
    records = Parameters(model)
    meant = {record.name for pattern in wanted for record in records.matching(pattern)}
    for record in records:
        if record.name in meant:
            _require_input(function, record)
    chosen = [
        record for record in records if record.name in meant or _differs_among_members(record)
    ]
    if model.family and not chosen:  # only limits differ: one number tells the family's shape
        chosen = [next(record for record in records if not record.limit)]
    names = tuple(record.name for record in chosen)
    columns = [np.nan if record.value is None else record.value for record in chosen]
    shape = (*model.family, len(names))
    values = (
        np.stack([np.broadcast_to(x, model.family) for x in columns], axis=-1)
        if columns
        else np.zeros(shape)
    )
    values.flags.writeable = False
    return KernelInputs(names, values, model)


def _require_input(function: str, record: ModelParameter) -> None:
    """Refuse a number that no kernel reads, or that follows from others by a formula."""
    if record.limit:
        raise FreebodyError(
            f"{function}: {record.name!r} is a limit, which no kernel reads; bind it instead."
        )
    if record.formula:
        raise FreebodyError(
            f"{function}: {record.name!r} follows from {record.formula}; name what it follows "
            f"from, or set it free first: bind({record.name}={record.name!r}), --parameter "
            f"{record.name}={record.name}."
        )


def _differs_among_members(record: ModelParameter) -> bool:
    """Whether a number that kernels read differs among the members of a family."""
    return isinstance(record.value, np.ndarray) and not (record.limit or record.formula)


class InputKernel:
    """A kernel with numbers of the model as inputs: its last argument is p (..., k).

    Called with p, with p={name: value}, where other numbers are the model's, or without, with the
    model's own numbers.

    Attributes
    ----------
    model
        Whose numbers these are.
    kernel
        The compiled function, which takes p as its last argument.
    parameters
        Names of the entries of p.
    values
        p of the model itself, of a family (*family, k).
    named
        These names and values.
    """

    def __init__(self, kernel: Kernel, named: KernelInputs):
        self.kernel, self.program, self.named = kernel, kernel.program, named
        self.parameters, self.values, self.model = named.names, named.values, named.model
        self._count = len(kernel.program.inputs)
        self._held = self.values if self.values.ndim == 1 and not named.missing else None
        self._refuse_beyond_range()

    def _refuse_beyond_range(self) -> None:
        """Refuse a number of the model that overflows to infinity in the kernel's precision, since
        it would make all results NaN."""
        with np.errstate(over="ignore"):
            beyond = np.isinf(self.values.astype(self.kernel.dtype))
        if beyond.any():
            *member, k = map(int, np.argwhere(beyond)[0])
            raise KernelError(
                f"{self.program.name}: {self.parameters[k]!r} is {self.values[*member, k]:g}"
                f"{of_member(tuple(member))}, which is beyond the range of {self.kernel.dtype}."
            )

    def __call__(
        self,
        *arrays: ArrayLike,
        p: Any = None,
        out: Any = None,
        threads: int | None = None,
        **options: Any,
    ) -> Any:
        """The output, or the tuple of outputs; see `Kernel`. A named p is an array, or {name: value
        or array}.

        options: what else the kernel takes where it runs, such as a GPU's `stream`.
        """
        if p is not None or len(arrays) < self._count:
            arrays = (*arrays, p if type(p) is np.ndarray else self.numbers(p))
        if out is None and threads is None and not options:
            return self.kernel(*arrays)
        return self.kernel(*arrays, out=out, threads=threads, **options)

    def numbers(self, given: Any = None) -> Any:
        """The argument p (..., k) of a call: an array as given; from {name: value} with the model's
        own values for the rest; without either all the model's own."""
        if given is None and not self.named.missing:
            return self.values
        if type(given) is dict and self._held is not None:
            numbers = self._of_floats(given)
            if numbers is not None:
                return numbers
        if given is not None and not isinstance(given, Mapping):
            return given
        columns: dict[str, Array] = {}
        for key, value in (given or {}).items():
            name = self.parameters[self.named.place(key)]
            columns[name] = as_floats("fb.kernel", f"p[{name!r}]", value)
        self.named.require({self.named.at[name] for name in columns})
        return self._with_columns(columns) if columns else self.values

    def _with_columns(self, columns: dict[str, Array]) -> Array:
        """The argument p with given values of some entries, by name, and the model's own values for
        the rest."""
        try:
            shape = np.broadcast_shapes(
                self.values.shape[:-1], *(x.shape for x in columns.values())
            )
        except ValueError:
            shapes = {repr(name): value.shape for name, value in columns.items()}
            family = {"model.family": self.model.family} if self.model.family else {}
            raise BatchError("fb.kernel", shapes | family, "values of p") from None
        numbers = np.array(np.broadcast_to(self.values, (*shape, len(self.parameters))))
        for name, value in columns.items():
            numbers[..., self.named.at[name]] = value
        return numbers

    def _of_floats(self, given: dict[Name, Any]) -> Array | None:
        """The argument p from full names with a float each, quickly, since a call takes
        microseconds; None for any other input."""
        numbers = self.values.copy()
        for name, value in given.items():
            at = self.named.at.get(name) if isinstance(name, str) else None
            if at is None or not isinstance(value, float):
                return None
            numbers[at] = value
        return numbers

    def __repr__(self) -> str:
        return f"InputKernel({self.kernel!r}; p: {', '.join(self.parameters)})"

    def __reduce__(self) -> tuple[Any, ...]:
        """A recipe for pickling: another process compiles the kernel itself, or finds it in the
        cache."""
        return input_kernel, (self.kernel, self.parameters, self.values, self.model)


class _QuickInputKernel(InputKernel):
    """An input kernel whose calls with plain arrays, p among them, run its C function directly,
    found by Python in the type's call slot."""

    __slots__ = ("__call__",)

    def __init__(self, plain: InputKernel, call: Callable[..., Any]):
        self.__dict__.update(plain.__dict__)
        self.__call__ = call


def input_kernel(
    kernel: Kernel, names: tuple[str, ...], values: Array, model: Model
) -> InputKernel:
    """A kernel whose last input is p, to be called in all the ways of an `InputKernel`."""
    plain = InputKernel(kernel, KernelInputs(names, values, model))
    call = kernel.quick(plain.__call__, plain._held)
    return plain if call is None else _QuickInputKernel(plain, call)
