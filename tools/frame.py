"""A frame of a scene at the size of its path-traced reference, its statistics, and its error."""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

HEMICUBE = Path(__file__).resolve().parent.parent / "target/release/hemicube"


def frame(scene, reference, *options):
    """Statistics of `hemicube render SCENE` with `options`, and the figures of its indirect light against REFERENCE's b1."""
    found = re.search(r"(\d+)x(\d+)\.exr$", str(reference))
    if not found:
        sys.exit(f"{reference}: the name must end in WIDTHxHEIGHT.exr")
    width, height = found.groups()
    with tempfile.TemporaryDirectory() as folder:
        picture, stats = Path(folder) / "out.exr", Path(folder) / "stats.json"
        subprocess.run([HEMICUBE, "render", scene, "-q", "-o", picture, "--layers", "irradiance", "--stats", stats,
                        "--width", width, "--height", height, *options], check=True, stdout=subprocess.DEVNULL)
        compared = subprocess.run([HEMICUBE, "compare", picture, reference, "--layer", "irradiance=b1", "--mask", "mask",
                                   "--no-flip", "--json", "-"], check=True, capture_output=True, text=True)
        return json.loads(stats.read_text()), json.loads(compared.stdout)["layers"][0]
