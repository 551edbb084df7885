"""The order of tests, and what is said of a failure for want of memory."""

from pathlib import Path

import pytest

# Files that take longest, the longest first: started last, one would keep a processor busy while the others wait.
LONGEST = (
    "test_fuzz.py",
    "test_restir_di.py",
    "test_path_shift.py",
    "test_reproduce.py",
    "test_guiding_grid.py",
    "test_unbiased_recorder.py",
    "test_compare.py",
    "test_tutorial.py",
    "test_kept_results.py",
    "test_shared_inputs.py",
    "test_flat_energy.py",
    "test_guided_restir.py",
    "test_restir_pt.py",
    "test_format.py",
)


def pytest_collection_modifyitems(items):
    items.sort(key=lambda item: LONGEST.index(item.path.name) if item.path.name in LONGEST else len(LONGEST))


def memory_left():
    """What this process takes, and what the machine has left: lines of text."""
    status = Path("/proc/self/status").read_text().splitlines()
    machine = Path("/proc/meminfo").read_text().splitlines()
    maps = len(Path("/proc/self/maps").read_text().splitlines())
    limits = Path("/proc/self/limits").read_text().splitlines()
    lines = [line for line in status if line.startswith(("VmPeak", "VmSize", "VmHWM", "VmRSS", "Threads"))]
    lines += [line for line in machine if line.startswith(("MemTotal", "MemAvailable", "Commit"))]
    lines += [f"maps: {maps}", *(line for line in limits if line.startswith("Max address space"))]
    return "\n".join(lines)


@pytest.hookimpl(hookwrapper=True)
def pytest_runtest_makereport(call):
    outcome = yield
    if call.excinfo and call.excinfo.errisinstance(MemoryError):
        outcome.get_result().sections.append(("Memory after the failure", memory_left()))
