"""A picture given as the reference: what its header says that it shows, against what is compared with it.

The renderer writes these attributes (Renderer::provenance), and report.py those of origin(). Of what a header does not
say nothing is known, and nothing is said.
"""

import json
from pathlib import Path

from restirpg.harness import UserError, mean_knobs, render

HASH = "restirpg.sceneHash"
KNOBS = "restirpg.knobs"
SIZE = "restirpg.size"  # of the whole picture
CAMERA = "restirpg.camera"  # its number
ENVIRONMENT = "restirpg.environment"  # in place of the scene's own
ENVIRONMENT_HASH = "restirpg.environmentHash"  # of its file
#: What makes a picture another than the mean of the scene's own view and time, where the header has it.
CHANGES = {
    "restirpg.pose": "its camera was moved",
    "restirpg.sceneEdits": "its scene was edited",
    "restirpg.movedNodes": "nodes of its scene were moved",
    "restirpg.time": "it shows another time of the animation",
    "restirpg.fps": "the scene's animation was played for it",
    "restirpg.denoised": "it was denoised",
    "restirpg.history": "its history was kept over moves of the camera",
}


def _window(size):
    """All of a picture of that size, as the renderer writes both."""
    return "0,0," + size.replace("x", ",")


def check(file, hash, size):
    """An EXR's header, {attribute: text}; raises UserError where it names another scene, or other pixels than the whole
    picture of that size."""
    header = render.read_exr_header(file)
    if header.get(HASH, hash) != hash:
        raise UserError(
            f"{file}: this reference is of another scene, or of another version of it "
            f"({header.get('restirpg.scene', 'unnamed')}, hash {header[HASH]}; here it is {hash}); "
            "give one that was rendered of this scene, or leave out --reference"
        )
    width, height = size
    whole = f"{width}x{height}"
    own = header.get(SIZE, whole)
    window = header.get("restirpg.window", _window(own))
    if (own, window) != (whole, _window(whole)):
        raise UserError(
            f"{file}: this reference is of other pixels ({window} of a picture of {own}; here it is {_window(whole)} of "
            f"{whole}); give a whole picture of that --size, or leave out --reference"
        )
    return header


def _environment(text):
    """As a header names it: a file without its folders, or three numbers."""
    try:
        return ",".join(f"{float(number):g}" for number in (text or "").split(","))
    except ValueError:
        return Path(text or "").name


def other_environment(header, name, hash):
    """What is to be said where the header has another environment than that of `name`, and of `hash` where it is a
    file; else None. Both are as restirpg.Scene has them."""
    own, here = [
        (_environment(header.get(ENVIRONMENT, "")), header.get(ENVIRONMENT_HASH, "")),
        (_environment(name), hash),
    ]
    # Two files of one name may differ, and one file may have two names: where both have a hash, that decides.
    if HASH not in header or (own[1] == here[1] if own[1] and here[1] else own[0] == here[0]):
        return None
    theirs, ours = (f"{name} (hash {hash})" if hash else name or "that of the scene" for name, hash in (own, here))
    return f"its environment is {theirs}, for the methods it is {ours}"


def _view(settings):
    """{attribute: its value} of what is asked for besides scene and environment; a header leaves out what is the
    default."""
    return {
        CAMERA: str(settings.camera or 0),
        "restirpg.energyCompensation": json.dumps(bool(settings.energy_compensation)),
    }


#: What gives methods the reference's knob.
ADVICE = {"bounces": "--bounces {}", "jitter": "@gbuffer.jitter={}"}
WORDS = {
    CAMERA: ("its camera is number", "0"),
    "restirpg.energyCompensation": ("its energy compensation is", "false"),
}


def origin(scene, facts, settings):
    """Attributes that tell what the harness's own pictures of a scene file, of those scenes.Facts, show."""
    view = {name: value for name, value in _view(settings).items() if value != WORDS[name][1]}
    environment = {ENVIRONMENT: _environment(settings.environment), ENVIRONMENT_HASH: facts.environment_hash}
    view |= {name: value for name, value in environment.items() if value}
    return {
        HASH: facts.scene_hash,
        "restirpg.scene": Path(scene).name,
        SIZE: "{}x{}".format(*settings.size),
        **view,
    }


def warnings_of(file, header, settings, environment_hash, means):
    """Lines about what the reference shows otherwise than the methods do.

    environment_hash: of scenes.Facts. means: {method's label: its mean_of()}.
    """
    if HASH not in header:
        return []
    told = [words for name, words in CHANGES.items() if name in header]
    told += filter(None, [other_environment(header, settings.environment, environment_hash)])
    for name, wanted in _view(settings).items():
        words, default = WORDS[name]
        own = header.get(name, default)
        if own != wanted:
            told.append(f"{words} {own}, for the methods it is {wanted}")
    lines = [f"{file}: {words}: the difference counts as error" for words in told]
    known = mean_of_header(header)
    for label, own in means.items():
        for knob, words in mean_knobs.differences(own, known, file).items():
            advice = ADVICE[knob].format(json.dumps(known[knob]))
            lines.append(f"{label}: {words}: the difference counts as error; {advice} sets it")
    return lines


def mean_of_header(header):
    """mean_of(), as far as a header says it; the knobs of another program's file may be anything."""
    try:
        return mean_knobs.mean_of(json.loads(header.get(KNOBS, "{}")))
    except (ValueError, TypeError, AttributeError):
        return {}
