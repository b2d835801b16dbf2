"""Run the benchmarks: `python -m tests.benchmarks` from the repository's root, with nothing else running."""

from tests.benchmarks import circle_maps, cycles

circle_maps.main()
cycles.main()
