"""The folder that keeps finished jobs."""

import contextlib
import hashlib
import io
import json
import zipfile
from pathlib import Path

import numpy as np

from restirpg.harness import Halt, UserError, files


class Cache:
    """Finished jobs, one .npz file each, named by the job's key. A file is there whole or not at all.

    Its last bytes are a checksum of the others and of the key, so that what is believed is what was stored. Readers
    of .npz files pass over them.
    """

    def __init__(self, folder, say=print):
        """say: is told in a line of each damaged file."""
        self.folder, self._say = Path(folder), say

    def path(self, key):
        """Where the result `key` lies or will lie."""
        return self.folder / f"{key}.npz"

    def load(self, key):
        """The result as a dictionary (arrays, and `meta` from JSON), or None when it is absent or damaged."""
        path = self.path(key)
        try:
            content = path.read_bytes()
        except FileNotFoundError:
            return None
        except OSError as error:
            raise UserError(f"{path}: cannot be read: {error.strerror}; remove it or choose another --cache") from None
        data, checksum = content[:-SIZE], content[-SIZE:]
        if checksum != _checksum(key, data):
            self._say(f"{path}: damaged, it is made again")
            with contextlib.suppress(OSError):
                path.unlink()
            return None
        with np.load(io.BytesIO(data), allow_pickle=False) as file:
            result = {name: file[name] for name in file.files}
        result["meta"] = json.loads(str(result["meta"]))
        return result

    def need(self, key):
        """As load, of a result that was there: raises UserError when it is not any more."""
        result = self.load(key)
        if result is None:
            raise UserError(f"{self.path(key)}: gone or damaged meanwhile; the same command makes it again")
        return result

    def store(self, key, result):
        """Keep `result`: arrays and a JSON-able `meta`. Raises Halt where it cannot be written."""
        data = _npz({**result, "meta": np.array(json.dumps(result["meta"]))})
        try:
            files.write(self.path(key), data + _checksum(key, data))
        except UserError as error:
            raise Halt(str(error)) from None


def _npz(arrays):
    """As np.savez, which leaves its archive to the collector when it is interrupted: that would be said on the
    terminal."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        for name, array in arrays.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as member:
                np.lib.format.write_array(member, np.asanyarray(array), allow_pickle=False)
    return stream.getvalue()


def _checksum(key, data):
    return hashlib.sha256(key.encode() + data).digest()


SIZE = len(_checksum("", b""))
