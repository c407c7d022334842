"""Writes a recorded session as MCAP, for Foxglove, PlotJuggler and others.

`python mcap_export.py press press.mcap` reads the folder of `chaincell run`, `serve --out` or `cosim --out`
of one tool; pose, force and energy of each tick are a message in JSON. Needs `pip install mcap`.
"""

import csv
import json
import sys
from pathlib import Path

from mcap.writer import Writer

TICK_NS = 1_000_000
session = Path(sys.argv[1])
with (session / "path.csv").open() as path, (session / "force.csv").open() as force, open(sys.argv[2], "wb") as out:
    poses, forces = csv.DictReader(path), csv.DictReader(force)
    names = list(dict.fromkeys([*(poses.fieldnames or []), *(forces.fieldnames or [])]))
    schema = {"type": "object", "properties": {name: {"type": "number"} for name in names}}
    writer = Writer(out)
    writer.start(library="chaincell")
    kind = writer.register_schema("chaincell.Tick", "jsonschema", json.dumps(schema).encode())
    channel = writer.register_channel("/tool", "json", kind)
    pose_of = {row["tick"]: row for row in poses}
    for row in forces:
        tick = {name: float(value) for name, value in {**pose_of[row["tick"]], **row}.items()}
        time_ns = int(row["tick"]) * TICK_NS
        writer.add_message(channel, time_ns, json.dumps(tick).encode(), time_ns, int(row["tick"]))
    writer.finish()
