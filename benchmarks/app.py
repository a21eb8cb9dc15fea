"""All figures of the application beside those asked: Play, Live and Map, one after the other.

``python benchmarks/app.py`` on a machine that does nothing else. Kernels should be in the disk
cache: what is compiled in the first run is only read in the second.
"""

import subprocess
import sys
from pathlib import Path


def main() -> None:
    for view in ("play", "live", "map"):
        print(f"\n== {view}", flush=True)
        script = Path(__file__).parent / "app" / f"{view}.py"
        subprocess.run([sys.executable, script], check=True)


if __name__ == "__main__":
    main()
