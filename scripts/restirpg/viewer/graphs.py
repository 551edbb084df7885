"""What the viewer asks of a graph's description (restirpg.graph documents its schema)."""

import functools

import restirpg
from restirpg.harness import guiding
from restirpg.harness.render import frame_port


@functools.cache
def described(pass_type):
    """restirpg.describe_pass, asked once a type."""
    return restirpg.describe_pass(pass_type)


def panel(description, values):
    """The knobs of every pass with their declarations: what the page makes its panel from. `values`: of
    Renderer.knobs()."""
    passes = []
    for entry in description["passes"]:
        declared = described(entry["type"])
        known = values.get(entry["name"], {})
        knobs = [{**knob, "value": known.get(knob["name"], knob["default"])} for knob in declared["knobs"]]
        passes.append({"name": entry["name"], "type": entry["type"], "meaning": declared["meaning"], "knobs": knobs})
    return passes


def image_ports(description):
    """{"pass.output": number of channels} of all ports that are float images."""
    ports = {}
    for entry in description["passes"]:
        for output in described(entry["type"])["outputs"]:
            channels = 2 if output["type"] == "Motion" else output["channels"]
            if channels:
                ports[f"{entry['name']}.{output['name']}"] = channels
    return ports


def has_image_port(description, port):
    """Whether the description has that port, "pass.output". One that cannot be read has none: the renderer says what is
    wrong with it, and where."""
    try:
        return port in image_ports(description)
    except (restirpg.Error, LookupError, TypeError):
        return False


def is_guided(description):
    """Whether paths are guided by lobes in the hash grid: mixtures or chains, see guide.py."""
    types = {entry["type"] for entry in description["passes"]}
    return {"GuidingSplat", "GuidingFit", "ReSTIRReuse"} <= types or {"GuidingChain", "PathTracerGuided"} <= types


def with_learnt_paths(description):
    """guiding.with_learnt_paths, with None for a description that cannot be read, too: the renderer says what is wrong with
    it, and where."""
    try:
        return guiding.with_learnt_paths(description)
    except (LookupError, TypeError, AttributeError):
        return None


def with_output(description, port):
    """The description with the port among its outputs, so that it is made and can be read."""
    name, _, output = port.partition(".")
    shown = {"name": "shown_in_the_viewer", "pass": name, "output": output}
    return {**description, "outputs": [*description["outputs"], shown]}


def frame_output(description):
    """The port of the last frame alone, where the graph's picture is a mean of frames; else None. So it is for a description
    that cannot be read: the renderer says what is wrong with it, and where."""
    try:
        picture = description["outputs"][0]["name"]
        port = frame_port(description, picture)
    except (LookupError, TypeError):
        return None
    return port if port != picture else None


def with_knobs(description, changed):
    """The description with other values of knobs, {"pass.knob": value}."""
    passes = []
    for entry in description["passes"]:
        own = {
            name.partition(".")[2]: value for name, value in changed.items() if name.partition(".")[0] == entry["name"]
        }
        passes.append({**entry, "knobs": {**entry.get("knobs", {}), **own}})
    return {**description, "passes": passes}


def as_arguments(changed):
    """Changed knobs as options of `restirpg render`, a list of words."""

    def text(value):
        return str(value).lower() if isinstance(value, bool) else str(value)

    return [word for name, value in sorted(changed.items()) for word in ("--set", f"{name}={text(value)}")]
