"""Writing files whole or not at all, and never over what is read."""

import contextlib
import glob
import hashlib
import json
import os
import socket
from pathlib import Path

from restirpg.harness import UserError

_HOST = socket.gethostname()
_PART = ".part"  # ends the name of a file that is being written
WRITTEN = "written.json"  # of a folder: {file that a program wrote there last time: digest of its content}


def _part_of(file):
    return file.with_name(f".{file.name}.{_HOST}.{os.getpid()}{_PART}")


def write(file, data):
    """Write bytes or text to `file`: under a temporary name, flushed, renamed. Raises UserError."""
    file = Path(file)
    part = _part_of(file)
    try:
        try:
            with open(part, "wb") as stream:
                stream.write(data.encode() if isinstance(data, str) else data)
                stream.flush()
                os.fsync(stream.fileno())
            os.replace(part, file)
        except BaseException:
            part.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise UserError(f"{file}: cannot be written: {error.strerror}") from None


def make_folder(folder, option):
    """Make `folder`, see that files can be written there, and remove what killed processes of this machine left
    unfinished. Raises UserError; `option` chooses another."""
    folder = Path(folder)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = _part_of(folder / "probe")
        probe.touch()
        probe.unlink()
    except OSError as error:
        reason = "not a folder" if isinstance(error, (FileExistsError, NotADirectoryError)) else error.strerror
        raise UserError(f"{folder}: cannot be written to: {reason}; choose another folder with {option}") from None
    for part in folder.glob(f".*{_PART}"):
        host, _, process = part.name.removesuffix(_PART).rpartition(".")
        if host.endswith(f".{_HOST}") and process.isdigit() and not Path(f"/proc/{process}").exists():
            with contextlib.suppress(OSError):
                part.unlink()


def _digest(file):
    with open(file, "rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def remove_earlier(folder, written):
    """Remove what the program wrote below `folder` the last time and not now, and note what it wrote now.

    written: files relative to `folder`. A file that has been changed since, or that no program noted, stays. Raises
    UserError.
    """
    folder = Path(folder)
    try:
        earlier = dict(json.loads((folder / WRITTEN).read_text()))
    except (OSError, ValueError, TypeError):
        earlier = {}
    for name in earlier.keys() - set(written):
        file = folder / name
        with contextlib.suppress(OSError):
            if file.resolve().is_relative_to(folder.resolve()) and _digest(file) == earlier[name]:
                file.unlink()
    write(folder / WRITTEN, json.dumps({name: _digest(folder / name) for name in written}, indent=1) + "\n")


def prepare(file, inputs, option):
    """Refuse a file to be written where it is one of `inputs`, or where it cannot be. Raises UserError."""
    file = Path(file)
    refuse_inputs_among(inputs, file.parent, [glob.escape(file.name)], option)
    make_folder(file.parent, option)


def refuse_inputs_among(inputs, folder, patterns, option="--out"):
    """Raise UserError when one of the files to be read is one to be written: `patterns` are relative to `folder`,
    which `option` chooses."""
    folder = Path(folder).resolve()
    for name in filter(None, inputs):
        file = Path(name).resolve()
        place = file.relative_to(folder) if file.is_relative_to(folder) else Path()
        if any(place.match(pattern) and len(place.parts) == len(Path(pattern).parts) for pattern in patterns):
            raise UserError(f"{name}: it would be written over; choose another place with {option}")
