"""The peers' own Python environment, and hemicube itself."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
WORK = ROOT / "target" / "peers"


def enter() -> None:
    """Goes on in the environment with the same command, which is made on the first run."""
    python = WORK / "venv" / "bin" / "python"
    if Path(sys.prefix).resolve() == python.parents[1].resolve():
        return
    requirements = HERE / "requirements.txt"
    installed = python.parents[1] / "installed.txt"
    if not installed.is_file() or installed.read_text() != requirements.read_text():
        print(f"making a Python environment in {python.parents[1]}", file=sys.stderr)
        subprocess.run([sys.executable, "-m", "venv", python.parents[1]], check=True)
        subprocess.run([python, "-m", "pip", "install", "-q", "-r", requirements], check=True)
        installed.write_text(requirements.read_text())
    os.execv(python, [str(python), *sys.argv])


def hemicube(*words: object) -> None:
    """Runs hemicube, $HEMICUBE or else the one that cargo built; its own message says what went wrong."""
    program = os.environ.get("HEMICUBE", str(ROOT / "target" / "release" / "hemicube"))
    if not Path(program).is_file():
        raise SystemExit(f"no {program}: run cargo build --release, or set HEMICUBE")
    if subprocess.run([program, *map(str, words)]).returncode != 0:
        raise SystemExit(2)


def export(
    scene: Path, folder: Path, size: tuple[int, int], camera: str | None = None, background: str | None = None
) -> None:
    """Has hemicube write the scene as plain arrays."""
    more = ["--camera", camera] if camera else []
    more += ["--background", background] if background else []
    hemicube("export", scene, "-o", folder, "--width", size[0], "--height", size[1], "-q", *more)
