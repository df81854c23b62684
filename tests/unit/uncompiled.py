"""Scripts that look into the contact solver, where its code is not compiled: in a process of their own."""

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any


def said(name: str, *arguments: str) -> Any:
    """Return what a script beside this one writes."""
    run = [sys.executable, str(Path(__file__).with_name(name)), *arguments]
    env = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    return json.loads(subprocess.run(run, env=env, capture_output=True, text=True, check=True).stdout)
