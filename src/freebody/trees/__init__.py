"""The numeric functions of open chains, and what every public function does around its kernel."""
