"""One healthy file of every kind that something reads."""

import json
import struct
from importlib.util import find_spec
from pathlib import Path

# What a push is of is told by its file's name.
PUSH = "motion_surface=plywood_shape=rect1_a=0_v=20_i=0.000_s=0.700_t=0.000_rep=0000"
_CORNERS = [(0, 0), (80, 0), (80, 80), (0, 80)]


def write_samples(folder: Path) -> None:
    """Write them all."""
    from cyclemap.collection import CollectionLoop
    from cyclemap.evidence import simulate_collection
    from cyclemap.mechanics import SidePush, load_material
    from cyclemap.mechanics.material_text import material_toml
    from cyclemap.protocol import write_protocol, write_schedule
    from cyclemap.protocol.collection_file import collection_text
    from cyclemap.resets import CycleAction, ResetStrategy
    from cyclemap.sweeps import PortraitNumbers, SweepPlan, run_sweep

    loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    for suffix in (".h5", ".json"):
        made = simulate_collection(loop, folder / f"made{suffix}", 1, suffix=suffix)
        next(made.folder.rglob(f"motion_*{suffix}")).rename(folder / f"{PUSH}{suffix}")
    poses = "".join(f"{n},0.1,0.2,{n / 7:.4f},0.3,0.4,1.5\n" for n in range(20))
    (folder / "poses.csv").write_text(f"rep,x0,y0,theta0,x1,y1,theta1\n{poses}")
    rows = "".join(f"{n},{3 * n},{3 * n % 360},{3 if n < 99 else ''},\n" for n in range(100))
    (folder / "plywood_rect1_theta0_2000.csv").write_text(
        f"rep,theta0_accum_deg,theta0_mod360_deg,dtheta_to_next_deg,flag\n{rows}"
    )
    (folder / "pairs.csv").write_text(
        "theta0_deg,theta_next_deg\n" + "".join(f"{n},{n + 2.5}\n" for n in range(50))
    )
    (folder / "support.csv").write_text(
        "x_mm,y_mm,weight\n40,40,1\n-40,40,1\n-40,-40,1.5\n40,-40,0.5\n"
    )
    (folder / "material.toml").write_text(material_toml(load_material("plywood-measured")))
    coin = ResetStrategy(tuple(CycleAction(push=SidePush(side)) for side in (1, 2)))
    write_protocol(folder / "protocol.toml", loop, coin)
    write_schedule(folder / "schedule.csv", loop, coin, 20)
    (folder / "collection.toml").write_text(collection_text(loop))
    plan = SweepPlan.grid(
        "isotropic",
        {"noise_deg": (1.0, 2.0)},
        numbers=PortraitNumbers(("rotation",)),
    )
    run_sweep(plan, folder / "sweep_isotropic.sqlite", workers=1)
    line = {
        "name": "x",
        "title": "t",
        "source": "s",
        "caption": "c",
        "file": "x.png",
        "measured": None,
    }
    (folder / "figures.json").write_text(json.dumps({"figures": [line]}))
    _write_outlines(folder)
    # What these are read with need not be installed; without them their kinds are left out.
    for write, needs in (
        (_write_tables, ("openpyxl", "pyarrow")),
        (_write_bags, ("rosbags",)),
        (_write_dxf, ("ezdxf",)),
    ):
        if all(find_spec(name) for name in needs):
            write(folder)


def _write_tables(folder: Path) -> None:
    """An object that turns by 3° from push to push, in the tables of other houses."""
    import pandas

    frame = pandas.DataFrame({"push": range(30), "yaw_before_deg": [3.0 * n for n in range(30)]})
    frame = frame.assign(
        yaw_after_deg=frame["yaw_before_deg"] + 2.0, x_before_mm=0.0, x_after_mm=40.0
    )
    frame = frame.assign(y_before_mm=0.0, y_after_mm=1.5)
    frame.to_csv(folder / "log.tsv", sep="\t", index=False)
    frame.to_excel(folder / "log.xlsx", index=False)
    frame.to_parquet(folder / "log.parquet")


def _write_bags(folder: Path) -> None:
    """Its poses ten times a second, in bags of ROS 1 and 2."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin, Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    kind = "geometry_msgs/msg/PoseStamped"
    with (
        Writer1(folder / "log.bag") as old,
        Writer2(folder / "made.db3", version=9) as stored,
        Writer2(folder / "made.mcap", version=9, storage_plugin=StoragePlugin.MCAP) as new,
    ):
        for writer, version in (
            (old, Stores.ROS1_NOETIC),
            (stored, Stores.LATEST),
            (new, Stores.LATEST),
        ):
            store = get_typestore(version)
            made, topic = store.types, writer.add_connection("/box", kind, typestore=store)
            for tick in range(120):
                cycle, within = divmod(tick, 20)
                x = 0.004 * min(within, 10)
                stamp = made["builtin_interfaces/msg/Time"](tick // 10, tick % 10 * 10**8)
                number = {"seq": tick} if version is Stores.ROS1_NOETIC else {}
                header = made["std_msgs/msg/Header"](stamp=stamp, frame_id="world", **number)
                pose = made["geometry_msgs/msg/Pose"](
                    made["geometry_msgs/msg/Point"](x, 0.0, 0.0),
                    made["geometry_msgs/msg/Quaternion"](0.0, 0.0, 0.02 * cycle, 1.0),
                )
                message = made[kind](header, pose)
                raw = (
                    store.serialize_ros1(message, kind)
                    if version is Stores.ROS1_NOETIC
                    else store.serialize_cdr(message, kind)
                )
                writer.write(topic, 10**8 * tick + 1, raw)
    for suffix in (".db3", ".mcap"):
        next((folder / f"made{suffix}").glob(f"*{suffix}")).rename(folder / f"log{suffix}")


def _write_outlines(folder: Path) -> None:
    """A square of 80 mm, drawn and modelled."""
    points = " ".join(f"{x},{y}" for x, y in _CORNERS)
    (folder / "tee.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="8cm" height="8cm" viewBox="0 0 80 80">'
        f'<g transform="translate(0,80) scale(1,-1)"><polygon points="{points}"/></g><path d="M0 '
        '0L9 0L9 9Z"/></svg>'
    )
    bottom = [[(*_CORNERS[a], z) for a in part] for z in (0, 9) for part in ((0, 1, 2), (0, 2, 3))]
    flat = b"".join(
        struct.pack("<12fH", 0, 0, 0, *(n for corner in one for n in corner), 0) for one in bottom
    )
    (folder / "tee.stl").write_bytes(b"\0" * 80 + struct.pack("<I", len(bottom)) + flat)
    (folder / "tee.urdf").write_text(
        '<robot name="t"><link name="base"/><link name="box"><collision><origin rpy="0 0 0.3" '
        'xyz="0.1 0 0"/><geometry><box size="0.1 0.2 0.05"/></geometry></collision></link></robot>'
    )
    (folder / "tee.csv").write_text("x_mm;y_mm\n" + "".join(f"{x};{y}\n" for x, y in _CORNERS))


def _write_dxf(folder: Path) -> None:
    import ezdxf

    drawing = ezdxf.new(units=4)
    drawing.modelspace().add_lwpolyline(_CORNERS, close=True)
    drawing.saveas(folder / "tee.dxf")
