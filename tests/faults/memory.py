"""Peak memory of every command on the readers' samples, whole, hostile and damaged at random:
`python -m tests.faults.memory [FILES] [SEED] [COMMAND ...]`; 1 where one needs more than two
gigabytes.
"""

import os
import random
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.faults.hostile import hostile_files
from tests.faults.mutations import mutated
from tests.faults.samples import PUSH

LARGEST_BYTES, LONGEST_SECONDS = 2 * 10**9, 120.0
PUSHES = (f"{PUSH}.h5", f"{PUSH}.json", "poses.csv")
THETA0 = "plywood_rect1_theta0_2000.csv"
DATA = (*PUSHES, THETA0, "pairs.csv", "log.tsv")
DATA += ("log.xlsx", "log.parquet", "log.db3", "log.mcap", "log.bag")
OUTLINES = ("tee.svg", "tee.dxf", "tee.stl", "tee.urdf", "tee.csv")
PROTOCOLS = ("protocol.toml", "collection.toml")
_SWEPT = "sweep isotropic --over noise_deg=1:2:2 --quantities rotation --workers 1"
# By what is done: the command, the file's place in it, and the samples that it is given.
COMMANDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "identify": ("identify {}", DATA),
    "compare": ("compare plywood --data {}", DATA),
    "audit": ("audit {}", DATA),
    "probe": ("probe plywood --data {}", DATA),
    "fit": ("fit {}", DATA),
    "watch": ("watch {}", DATA),
    "replay": ("replay isotropic --data {}", PUSHES),
    "staircase": ("staircase plywood --data {}", DATA),
    "report": ("report plywood --data {}", DATA),
    "explore": ("explore plywood --no-browser --data {}", DATA),
    "portrait": ("portrait --material {}", ("material.toml",)),
    "pressure": ("portrait plywood --set footprint={}", ("support.csv",)),
    "fingerprint": ("fingerprint --material {}", ("material.toml",)),
    "simulate": ("simulate plywood --cycles 20 --out made --protocol {}", PROTOCOLS),
    "cycle": ("cycle plywood --theta0-deg 10 --protocol {}", PROTOCOLS),
    "dynamics": ("dynamics plywood --theta0-deg 10 --protocol {}", ("collection.toml",)),
    "experiment": ("experiment plywood --batches 2 --cycles 3 --protocol {}", ("collection.toml",)),
    "sweep": (f"{_SWEPT} --protocol {{}}", ("collection.toml",)),
    # What was begun is in the store, and gone on with.
    "sweep on": (f"{_SWEPT} --out .", ("sweep_isotropic.sqlite",)),
    "reset": ("reset plywood --protocol {}", ("protocol.toml",)),
    "plan": ("plan {} --pushes 2", ("collection.toml",)),
    "check": ("check {}", ("collection.toml",)),
    "init": ("init made.toml --outline {}", OUTLINES),
    # Captions of pictures that are there already.
    "figures": ("figures table-friction --out .", ("figures.json",)),
    "staircases": ("figures staircases --data .", (THETA0,)),
}
_SAMPLES = "from pathlib import Path; from tests.faults.samples import write_samples; "


def peak_bytes(words: list[str], folder: Path) -> tuple[int, int]:
    """The most memory a command had at one time, and its exit code; -9 where it took too long."""
    line = ["timeout", "-s", "KILL", f"{LONGEST_SECONDS:.0f}", sys.executable, "-m", "cyclemap"]
    environment = os.environ | {"PYTHONPATH": str(Path.cwd()), "OPENBLAS_NUM_THREADS": "1"}
    process = subprocess.Popen(
        [*line, *words],
        cwd=folder,
        env=environment,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return usage.ru_maxrss * 1024, process.returncode


def peaks(command: str, folder: Path, files: int, chance: random.Random) -> tuple[int, list[int]]:
    """The highest peak of a command over whole and damaged files of its kinds, and its exit
    codes.
    """
    words, kinds = COMMANDS[command]
    highest, codes = 0, list[int]()
    for kind in kinds:
        sample = folder / kind
        if not sample.exists():  # what reads it is not installed
            continue
        healthy = sample.read_bytes()
        contents = [healthy, *hostile_files(kind, healthy)]
        contents += [mutated(healthy, chance) for _ in range(files)]
        for content in contents:
            with tempfile.TemporaryDirectory() as place:
                # Protocols name files that stand beside them.
                shutil.copytree(folder, place, dirs_exist_ok=True)
                (Path(place) / kind).write_bytes(content)
                peak, code = peak_bytes(words.format(kind).split(), Path(place))
            highest = max(highest, peak)
            codes.append(code)
    return highest, codes


def main(files: int, seed: int, commands: list[str]) -> int:
    """A row a command, as they come."""
    chance, exceeds = random.Random(seed), False
    with tempfile.TemporaryDirectory() as place:
        # In another process: a child's peak is never told as less than its parent's memory.
        write = f"{_SAMPLES}write_samples(Path({place!r}))"
        subprocess.run([sys.executable, "-c", write], check=True)
        for command in commands or COMMANDS:
            peak, codes = peaks(command, Path(place), files, chance)
            ended = {code: codes.count(code) for code in sorted(set(codes))}
            print(f"{command:<12}{peak / 1e6:>8.0f} MB, exit codes {ended}", flush=True)
            exceeds |= peak > LARGEST_BYTES
    return int(exceeds)


if __name__ == "__main__":
    numbers = [int(word) for word in sys.argv[1:3]]
    sys.exit(main(*(numbers + [3, 0][len(numbers) :]), sys.argv[3:]))
