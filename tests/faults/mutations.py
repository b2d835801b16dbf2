"""Files damaged at random, given to every reader in a process that may not grow or last."""

import json
import random
import resource
import signal
import sys
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path

from tests.faults.samples import PUSH

# Bytes, and seconds of the processor, that reading one file may take.
LARGEST_BYTES, LONGEST_SECONDS = 10**9, 30

Reader = Callable[[Path], object]


def readers() -> dict[str, tuple[Reader, ...]]:
    """Who reads a file, by its kind: the name of its sample."""
    from cyclemap.cli.run_figures import _read_index
    from cyclemap.evidence import load_pushes, read_theta0_pairs
    from cyclemap.evidence.tables.data_kinds import recognise
    from cyclemap.evidence.tables.own_tables import read_own_table
    from cyclemap.mechanics import load_footprint, load_material
    from cyclemap.protocol import loop_from_file, read_protocol, read_schedule
    from cyclemap.protocol.outline_files import read_outline
    from cyclemap.resets.theta0_feed import theta0_feed
    from cyclemap.sweeps import load_sweep

    def read_all_theta0(path: Path) -> object:
        return theta0_feed(path).look(finished=True)

    return {
        f"{PUSH}.h5": (load_pushes, recognise),
        f"{PUSH}.json": (load_pushes, recognise),
        "poses.csv": (load_pushes, recognise),
        "plywood_rect1_theta0_2000.csv": (read_theta0_pairs, load_pushes, read_all_theta0),
        "pairs.csv": (read_theta0_pairs, load_pushes),
        "support.csv": (load_footprint,),
        "schedule.csv": (read_schedule,),
        "material.toml": (load_material,),
        "protocol.toml": (read_protocol,),
        "sweep_isotropic.sqlite": (load_sweep,),
        "figures.json": (_read_index,),
        "collection.toml": (loop_from_file,),
        **{
            f"log{end}": (read_own_table,)
            for end in (".tsv", ".xlsx", ".parquet", ".db3", ".mcap", ".bag")
        },
        **{f"tee{end}": (read_outline,) for end in (".svg", ".dxf", ".stl", ".urdf", ".csv")},
    }


def mutated(content: bytes, chance: random.Random) -> bytes:
    """A file with bytes flipped, cut off, cut out, doubled, or something vile put in."""
    damaged, vile = (
        bytearray(content),
        [b"9" * 400, b"[" * 5000, b'{"a":' * 5000, b"\x00" * 100, b"nan", b"1e999", b"\xff"],
    )
    for _ in range(chance.choice([1, 1, 2, 8])):
        place = chance.randrange(len(damaged) + 1)
        end = min(len(damaged), place + chance.choice([1, 1, 10, 1000]))
        piece = bytes(damaged[place:end])
        damaged[place:end] = chance.choice(
            [
                bytes(chance.randrange(256) for _ in piece),
                b"",
                2 * piece,
                chance.choice(vile),
                piece[::-1],
                b"-",
                b",",
            ]
        )
    return bytes(damaged)


def read_mutations(folder: Path, count: int, seed: int) -> Counter[str]:
    """Give `count` damaged files to their readers; how they ended,
    faults by a line each on stderr."""
    from cyclemap.errors import CycleMapError

    chance, outcomes = random.Random(seed), Counter[str]()
    by_kind = {kind: who for kind, who in readers().items() if (folder / kind).exists()}
    healthy = {kind: (folder / kind).read_bytes() for kind in by_kind}
    place = folder / "damaged"
    place.mkdir(exist_ok=True)
    too_much = False
    for number in range(count):
        kind = list(by_kind)[number % len(by_kind)]
        path = place / kind
        content = mutated(healthy[kind], chance)
        path.write_bytes(content)
        for reader in by_kind[kind]:
            begun = time.process_time()
            try:
                reader(path)
                outcomes["read"] += 1
            except CycleMapError as error:
                outcomes["refused" if str(error) else "refused without a word"] += 1
            except Exception:
                outcomes["traceback"] += 1
                (place / f"fault{number}_{kind}").write_bytes(content)
                print(f"{kind} {number}: {traceback.format_exc(limit=-3)}", file=sys.stderr)
            if time.process_time() - begun > LONGEST_SECONDS:
                outcomes["hang"] += 1
                print(
                    f"{kind} {number}: takes {time.process_time() - begun:.0f} s", file=sys.stderr
                )
            if not too_much and peak_bytes() > LARGEST_BYTES:
                too_much = True
                print(f"{kind} {number}: takes the memory to {peak_bytes()} bytes", file=sys.stderr)
        if path.read_bytes() != content:
            outcomes["changed by reading"] += 1
        for rest in place.glob(f"{kind}-*"):
            rest.unlink()
    return outcomes


def peak_bytes() -> int:
    """The most memory that this process has had."""
    status = Path("/proc/self/status")
    if status.is_file():  # what getrusage tells may be that of the process that started this one
        told = next(line for line in status.read_text().splitlines() if line.startswith("VmHWM"))
        return int(told.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def main(folder: Path, count: int, seed: int) -> int:
    """Run in a process of its own: memory and time are limited as hard as the system can."""
    signal.alarm(LONGEST_SECONDS * count)
    warnings.simplefilter("ignore")
    outcomes = read_mutations(folder, count, seed)
    print(json.dumps({**outcomes, "files": count, "peak_bytes": peak_bytes()}))
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])))
