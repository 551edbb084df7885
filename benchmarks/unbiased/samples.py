"""Files of samples that only grow: what was rendered before an interruption stays."""

import fcntl
import json
import os
import time
from pathlib import Path

import numpy as np

from restirpg.harness import UserError, files
from restirpg.harness.jobs import digest
from restirpg.harness.report import commit


class Samples:
    """Equally shaped float32 arrays, one a run, appended to a file in a folder named by a hash of `identity`.

    Everything that a sample depends on belongs into `identity`, a dictionary of JSON values. An array that an
    interruption left unfinished is dropped. One process at a time may write.
    """

    def __init__(self, folder, identity, shape):
        self.shape = tuple(shape)
        self.folder = Path(folder) / digest(json.dumps(identity, sort_keys=True).encode())
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._file = open(self.folder / "samples.f32", "a+b")
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(f"{self.folder}: another process records the same; wait for its end") from None
        except OSError as error:
            raise UserError(f"{folder}: {error.strerror}; choose another --out") from None
        files.write(self.folder / "identity.json", json.dumps(identity, indent=1, sort_keys=True))
        self._bytes = 4 * int(np.prod(self.shape))
        self._file.truncate(len(self) * self._bytes)

    def __len__(self):
        return os.fstat(self._file.fileno()).st_size // self._bytes

    def append(self, sample):
        """Add one run's array; it is on the disk when this returns."""
        self._file.write(np.ascontiguousarray(sample, np.float32).reshape(self.shape).tobytes())
        self._file.flush()
        os.fsync(self._file.fileno())

    def load(self):
        """All of them, float32 (runs, *shape)."""
        self._file.seek(0)
        return np.frombuffer(self._file.read(), np.float32).reshape(-1, *self.shape)

    def note_session(self):
        """Write down which commit renders the runs from here on."""
        sessions = self.sessions()
        sessions.append({"first_run": len(self), "commit": commit(), "date": time.strftime("%Y-%m-%d")})
        files.write(self.folder / "sessions.json", json.dumps(sessions, indent=1))

    def sessions(self):
        """Which commits rendered the runs: [{first_run, commit, date}]."""
        path = self.folder / "sessions.json"
        return json.loads(path.read_text()) if path.is_file() else []
