"""Build the site, and serve it.

python docs/build.py             into build/site/html; every warning is an error
python docs/build.py --serve     the same, and serve it on this machine until Ctrl-C
"""

from __future__ import annotations

import argparse
import importlib.util
import subprocess
import sys
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

ROOT = Path(__file__).parents[1]
SITE = ROOT / "build" / "site"
NEEDED = ("sphinx", "myst_nb", "furo", "jupytext", "matplotlib")


def missing() -> list[str]:
    """The packages of the extra "docs" that are not installed."""
    return [name for name in NEEDED if importlib.util.find_spec(name) is None]


def build() -> int:
    """Write the sources of all pages into one folder, and run Sphinx on it. Returns its exit code."""
    sys.path[:0] = [str(ROOT), str(ROOT / "formulations")]  # this checkout, whatever is installed
    from site_pages import stage

    stage(ROOT, SITE / "source")
    command = [sys.executable, "-m", "sphinx", "--fail-on-warning", "--keep-going", "--quiet", "-b", "html"]
    command += ["-c", str(ROOT / "docs"), "-d", str(SITE / "doctrees"), str(SITE / "source"), str(SITE / "html")]
    return subprocess.run(command, cwd=ROOT, check=False).returncode


def serve(port: int) -> None:
    """Serve the site on this machine until Ctrl-C."""
    handler = partial(SimpleHTTPRequestHandler, directory=str(SITE / "html"))
    with ThreadingHTTPServer(("127.0.0.1", port), handler) as server:
        print(f"http://127.0.0.1:{server.server_port}  (Ctrl-C ends it)")
        try:
            server.serve_forever()
        except KeyboardInterrupt:
            print()


def main() -> int:
    """Run the command line. Returns the exit code."""
    parser = argparse.ArgumentParser(description="Build the site into build/site/html.")
    parser.add_argument("--serve", action="store_true", help="serve it on this machine until Ctrl-C")
    parser.add_argument("--port", type=int, default=8000, help="port of --serve (default: 8000)")
    options = parser.parse_args()
    if absent := missing():
        print(
            f'the site needs the extra "docs" ({", ".join(absent)}): python -m pip install ".[docs]"', file=sys.stderr
        )
        return 2
    failed = build()
    print("the site has warnings, see above" if failed else f"the site is {SITE / 'html' / 'index.html'}")
    if options.serve and not failed:
        serve(options.port)
    return failed


if __name__ == "__main__":
    sys.exit(main())
