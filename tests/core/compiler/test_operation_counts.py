"""No kernel grows unnoticed: operations of a sample are bounded by the counts that are kept in
tests/support/operation_counts.toml."""

from support.operation_counts import bounds, counted


def test_no_kernel_has_more_operations_than_are_kept():
    """A change that means to make one longer renews the file, where its price is seen. Counts
    far below what is kept are renewed too, so that the bounds bind."""
    kept = bounds()
    now = counted()
    assert {r: set(q) for r, q in kept.items()} == {r: set(q) for r, q in now.items()}
    grown = {
        (robot, quantity): (count, kept[robot][quantity])
        for robot, counts in now.items()
        for quantity, count in counts.items()
        if not 0.97 * kept[robot][quantity] <= count <= kept[robot][quantity]
    }
    assert grown == {}, "renew them by python tests/support/operation_counts.py"
