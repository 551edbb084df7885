"""Whether the files that pictures depend on have changed: graph files and the modules beside them, kernels and
shaders."""

import time
from pathlib import Path

import restirpg

_SECONDS = 1.0  # between two looks
_KERNELS = {".glsl", ".comp", ".h"}


class Watch:
    """Looks at the times of the files now and then."""

    def __init__(self, graph_files):
        self._folders = [(Path(file).resolve().parent, {".py", ".json"}, "*") for file in graph_files]
        self._folders += [(Path(path), _KERNELS, "**/*") for path in restirpg.code_paths() if Path(path).is_dir()]
        self._looked, self._found = time.monotonic(), self._look()

    def _look(self):
        found = {}
        for folder, suffixes, pattern in self._folders:
            for file in folder.glob(pattern):
                try:
                    if file.suffix in suffixes:
                        found[file] = file.stat().st_mtime_ns
                except OSError:  # it has just gone
                    pass
        return found

    def changed(self):
        """Names of the files that changed since the last look; none until a second has passed."""
        if time.monotonic() - self._looked < _SECONDS:
            return []
        before, self._found = self._found, self._look()
        self._looked = time.monotonic()
        names = before.keys() | self._found.keys()
        return sorted(str(file) for file in names if before.get(file) != self._found.get(file))
