"""Explorer and report: one page that carries the engine with it, and computes in the browser."""
