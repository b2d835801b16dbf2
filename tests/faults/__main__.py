"""Damage at full size: 5,000 files over every reader and 150 kills; `python -m tests.faults --help`
for less.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.faults.kills import COMMANDS, kill_and_go_on
from tests.faults.mutations import LARGEST_BYTES
from tests.faults.samples import write_samples

GOOD = {"read", "refused", "killed", "done before", "went on", "files", "peak_bytes"}


def damaged_files(folder: Path, count: int, seed: int) -> dict[str, int]:
    """Read damaged files in another process, which a reader may take down: the counts of how they
    ended.
    """
    write_samples(folder)
    command = [sys.executable, "-m", "tests.faults.mutations", str(folder), str(count), str(seed)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(done.stderr, end="", file=sys.stderr)
    found: dict[str, int] = (
        json.loads(done.stdout) if done.returncode == 0 else {"crash": done.returncode}
    )
    return found | ({"too much memory": 1} if found.get("peak_bytes", 0) > LARGEST_BYTES else {})


def faults(found: dict[str, int]) -> dict[str, int]:
    """What should not have happened."""
    return {name: count for name, count in found.items() if name not in GOOD and count}


def main() -> int:
    """Run both, print what happened, and tell by the exit code whether all was well."""
    parser = argparse.ArgumentParser(prog="python -m tests.faults", description=__doc__)
    parser.add_argument("--files", type=int, default=5000)
    parser.add_argument("--kills", type=int, default=150)
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        found = damaged_files(Path(place), asked.files, asked.seed)
        print(f"damaged files: {found}", flush=True)
        bad = faults(found)
        for command in COMMANDS:
            folder = Path(place) / command
            folder.mkdir()
            outcome = kill_and_go_on(
                command, folder, asked.kills // len(COMMANDS), asked.seed, print
            )
            print(f"{command}: {dict(outcome)}", flush=True)
            bad |= faults(outcome)
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
