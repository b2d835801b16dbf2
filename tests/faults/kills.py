"""Commands killed at random moments, and run again: what they leave is what an undisturbed one
leaves.
"""

import os
import random
import signal
import sqlite3
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

LONGEST_SECONDS = (
    120.0  # and ten times what an undisturbed run takes: other work may have slowed the machine
)
COMMANDS = {
    "simulate": ("simulate", "plywood", "--cycles", "60", "--pose-noise-mm", "0.1"),
    "sweep": (
        "sweep",
        "plywood",
        "--over",
        "hitch_x_mm=-12:-9:3",
        "--quantities",
        "rotation",
        "--workers",
        "1",
    ),
    "figures": ("figures", "setup-and-cycle", "table-friction", "limit-ellipse-and-patch"),
}


def start(command: str, folder: Path) -> subprocess.Popen[str]:
    """Begin a command that writes to `folder`."""
    line = [sys.executable, "-m", "cyclemap", *COMMANDS[command], "--out", str(folder)]
    quiet = os.environ | {"CYCLEMAP_DATA": str(folder.parent)}
    return subprocess.Popen(
        line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=quiet
    )


def finish(
    command: str, folder: Path, longest: float = 5 * LONGEST_SECONDS
) -> tuple[int, str, float]:
    """Run a command to its end: its exit code, its complaints, its seconds."""
    begun, process = time.monotonic(), start(command, folder)
    try:
        _, told = process.communicate(timeout=longest)
    except subprocess.TimeoutExpired:
        process.kill()
        return -1, "hangs", longest
    return process.returncode, told, time.monotonic() - begun


def left(command: str, folder: Path) -> dict[str, object]:
    """What a command has left: files by name, rows of a store."""
    found: dict[str, object] = {}
    for path in sorted(folder.rglob("*")):
        if path.suffix == ".sqlite":
            connection = sqlite3.connect(path)
            found[path.name] = connection.execute("SELECT * FROM points ORDER BY number").fetchall()
            connection.close()
        elif path.is_file() and not path.name.endswith(("-wal", "-shm")):
            found[str(path.relative_to(folder))] = path.read_bytes()
    return found


def kill_and_go_on(
    command: str, folder: Path, kills: int, seed: int, said: Callable[[str], None]
) -> Counter[str]:
    """Kill a command `kills` times in all, in runs of up to three kills that go on with one
    another.
    """
    chance, outcomes = random.Random(seed), Counter[str]()
    code, told, seconds = finish(command, folder / "undisturbed")
    if code:
        said(f"{command}: {told}")
        return Counter(traceback=1)
    wanted, run = left(command, folder / "undisturbed"), 0
    while outcomes["killed"] < kills:
        place, run = folder / f"killed {run}", run + 1
        for _ in range(min(3, kills - outcomes["killed"])):
            process = start(command, place)
            time.sleep(chance.uniform(0.1, 0.8) * seconds)
            process.send_signal(signal.SIGKILL)
            was_killed = process.wait() == -signal.SIGKILL
            process.communicate()
            outcomes["killed" if was_killed else "done before"] += 1
            if not was_killed:
                break
        code, told, _ = finish(command, place, max(LONGEST_SECONDS, 10.0 * seconds))
        hidden = [name for name in left(command, place) if name.endswith(".part")]
        if code or "Traceback" in told:
            outcomes["hang" if code == -1 else "traceback"] += 1
            said(f"{command} in {place}: {told}")
        elif {
            name: part for name, part in left(command, place).items() if name not in hidden
        } != wanted:
            outcomes["changed"] += 1
            said(f"{command} in {place}: left other files than an undisturbed run")
        else:
            outcomes["went on"] += 1
    return outcomes
