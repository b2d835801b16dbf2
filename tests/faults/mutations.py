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

LARGEST_BYTES, LONGEST_SECONDS = 10**9, 30

Reader = Callable[[Path], object]


def readers() -> dict[str, tuple[Reader, ...]]:
    """Who reads a file, by its kind: the name of its sample."""
    from cyclemap.cli.run_figures import _read_index
    from cyclemap.evidence import load_pushes, read_theta0_pairs
    from cyclemap.evidence.data_blocks.data_recognition import recognise
    from cyclemap.mechanics import load_footprint, load_material
    from cyclemap.resets import read_protocol, read_schedule
    from cyclemap.sweeps import load_sweep

    return {
        "push.h5": (load_pushes, recognise),
        "push.json": (load_pushes, recognise),
        "poses.csv": (load_pushes, recognise),
        "staircase.csv": (read_theta0_pairs, load_pushes),
        "pairs.csv": (read_theta0_pairs, load_pushes),
        "support.csv": (load_footprint,),
        "schedule.csv": (read_schedule,),
        "material.toml": (load_material,),
        "protocol.toml": (read_protocol,),
        "sweep.sqlite": (load_sweep,),
        "figures.json": (_read_index,),
    }


def write_samples(folder: Path) -> None:
    """Write one healthy file of every kind."""
    from cyclemap.collection import CollectionLoop
    from cyclemap.evidence import simulate_collection
    from cyclemap.mechanics import SidePush, load_material
    from cyclemap.mechanics.material_text import material_toml
    from cyclemap.resets import CycleAction, ResetStrategy, write_protocol, write_schedule
    from cyclemap.sweeps import PortraitNumbers, SweepPlan, run_sweep

    loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    for suffix in (".h5", ".json"):
        made = simulate_collection(loop, folder / f"made{suffix}", 1, suffix=suffix)
        next(made.folder.rglob(f"motion_*{suffix}")).rename(folder / f"push{suffix}")
    poses = "".join(f"{n},0.1,0.2,{n / 7:.4f},0.3,0.4,1.5\n" for n in range(20))
    (folder / "poses.csv").write_text(f"rep,x0,y0,theta0,x1,y1,theta1\n{poses}")
    rows = "".join(f"{n},{3 * n},{3 * n % 360},{3 if n < 99 else ''},\n" for n in range(100))
    (folder / "staircase.csv").write_text(f"rep,theta0_accum_deg,theta0_mod360_deg,dtheta_to_next_deg,flag\n{rows}")
    (folder / "pairs.csv").write_text("theta0_deg,theta_next_deg\n" + "".join(f"{n},{n + 2.5}\n" for n in range(50)))
    (folder / "support.csv").write_text("x_mm,y_mm,weight\n40,40,1\n-40,40,1\n-40,-40,1.5\n40,-40,0.5\n")
    (folder / "material.toml").write_text(material_toml(load_material("plywood-measured")))
    coin = ResetStrategy(tuple(CycleAction(push=SidePush(side)) for side in (1, 2)))
    write_protocol(folder / "protocol.toml", loop, coin)
    write_schedule(folder / "schedule.csv", loop, coin, 20)
    plan = SweepPlan.grid(
        "isotropic", {"noise_deg": (1.0, 2.0)}, numbers=PortraitNumbers(("rotation",), tolerance=1e-2)
    )
    run_sweep(plan, folder / "sweep.sqlite", workers=1)
    line = {"name": "x", "title": "t", "source": "s", "caption": "c", "file": "x.png", "measured": None}
    (folder / "figures.json").write_text(json.dumps({"figures": [line]}))


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
            [bytes(chance.randrange(256) for _ in piece), b"", 2 * piece, chance.choice(vile), piece[::-1], b"-", b","]
        )
    return bytes(damaged)


def read_mutations(folder: Path, count: int, seed: int) -> Counter[str]:
    """Give `count` damaged files to their readers; how they ended, faults by a line each on stderr."""
    from cyclemap.errors import CycleMapError

    chance, outcomes, by_kind = random.Random(seed), Counter[str](), readers()
    healthy = {kind: (folder / kind).read_bytes() for kind in by_kind}
    place = folder / "damaged"
    place.mkdir(exist_ok=True)
    for number in range(count):
        kind = list(by_kind)[number % len(by_kind)]
        path = place / kind
        content = mutated(healthy[kind], chance)
        path.write_bytes(content)
        for reader in by_kind[kind]:
            begun = time.monotonic()
            try:
                reader(path)
                outcomes["read"] += 1
            except CycleMapError as error:
                outcomes["refused" if str(error) else "refused without a word"] += 1
            except Exception:
                outcomes["traceback"] += 1
                (place / f"fault{number}_{kind}").write_bytes(content)
                print(f"{kind} {number}: {traceback.format_exc(limit=-3)}", file=sys.stderr)
            if time.monotonic() - begun > LONGEST_SECONDS:
                outcomes["hang"] += 1
        if path.read_bytes() != content:
            outcomes["changed by reading"] += 1
        for rest in place.glob(f"{kind}-*"):
            rest.unlink()
    return outcomes


def main(folder: Path, count: int, seed: int) -> int:
    """Run in a process of its own: memory and time are limited as hard as the system can."""
    signal.alarm(LONGEST_SECONDS * max(1, count // 10))
    warnings.simplefilter("ignore")
    outcomes = read_mutations(folder, count, seed)
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    print(json.dumps({**outcomes, "files": count, "peak_bytes": peak}))
    return 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3])))
