// Reading glTF 2.0 (.gltf, .glb).
#pragma once

#include "scene/scene.h"

namespace restirpg {

/// Read a .gltf or .glb file: geometry, materials, textures, node hierarchy, cameras, lights, node animation.
///
/// Core glTF 2.0 and KHR_materials_{emissive_strength, transmission, ior, specular, volume, unlit as a diffuse
/// emitter-free approximation}, KHR_texture_transform, KHR_lights_punctual, KHR_mesh_quantization. Anything else
/// optional is named once in a warning; an unsupported *required* extension, or a file that is damaged or hostile,
/// is one Error that names the file, the place and the mend. A scene without a camera gets one that frames it; one
/// without any light gets a white environment of radiance 1; both with a warning. No triangles is an Error.
///
/// `extras` of the asset may hold "restirpg": {"environment": "sky.hdr" | [r, g, b], "strength": s, "rotation":
/// degrees, "bounces": n}; the path is relative to the file.
Scene loadGltf(const std::filesystem::path& file);

/// Read an equirectangular environment (.exr, .hdr), or parse "r,g,b" as a constant radiance.
Environment loadEnvironment(const std::string& source);

}  // namespace restirpg
