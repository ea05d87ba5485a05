"""Plays a scenario in Blender's window: what happens in a test. Runs inside Blender, see driver.py.

Usage: blender --python scenarios.py -- SCENARIO DIRECTORY
"""

from __future__ import annotations

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

import denoise_scenarios
import paper_scenarios
import sculpt_scenarios
import user_scenarios
from driver import play

if __name__ == "__main__":
    name, directory = sys.argv[sys.argv.index("--") + 1 :]
    modules = (paper_scenarios, denoise_scenarios, sculpt_scenarios, user_scenarios)
    (scenario,) = (vars(module)[name] for module in modules if name in vars(module))
    play(scenario, Path(directory))
