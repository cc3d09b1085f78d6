"""Lines of LLVM text that read and write fields at offsets."""

from __future__ import annotations


class TextLines(list[str]):
    """Lines of LLVM text, with what recurs."""

    def field(self, name: str, kind: str, base: str, offset: int) -> str:
        """Load what lies at an offset."""
        self.append(f"  %{name}.at = getelementptr i8, ptr {base}, i64 {offset}")
        self.append(f"  %{name} = load {kind}, ptr %{name}.at, align {4 if kind == 'i32' else 8}")
        return f"%{name}"

    def entry(self, name: str, base: str, index: int) -> str:
        """Load a pointer, or a size, of an array of them."""
        return self.field(name, "ptr", base, 8 * index)

    def put(self, kind: str, value: str | int, base: str, offset: int) -> None:
        """Store something at an offset."""
        name = f"%put{len(self)}"
        self.append(f"  {name} = getelementptr i8, ptr {base}, i64 {offset}")
        self.append(f"  store {kind} {value}, ptr {name}, align {4 if kind == 'i32' else 8}")

    def equal(self, name: str, kind: str, value: str, other: str | int) -> str:
        """Whether two numbers are equal."""
        self.append(f"  %{name} = icmp eq {kind} {value}, {other}")
        return f"%{name}"

    def all(self, name: str, flags: list[str]) -> str:
        """Whether all are true."""
        known = "true"
        for k, flag in enumerate(flags):
            self.append(f"  %{name}.{k} = and i1 {known}, {flag}")
            known = f"%{name}.{k}"
        return known
