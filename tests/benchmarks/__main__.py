"""Run the benchmarks: `python -m tests.benchmarks` from the repository's root, on one core, nothing else running."""

from tests.benchmarks.cycles import main

main()
