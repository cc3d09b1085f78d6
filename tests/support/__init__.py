"""What several test files share: mechanisms by chance, wrong input by the thousand, oracles, public
calls."""
