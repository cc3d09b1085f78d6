"""The numeric functions of open chains, and the work that every public function does around its
kernel."""
