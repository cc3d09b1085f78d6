"""Reading users' equations, exact comparison with the correct ones, and naming their mistakes."""
