// Reading glTF 2.0 (.gltf, .glb).
#pragma once

#include "scene/scene.h"

namespace restirpg {

/// Read a .gltf or .glb file: geometry, materials, textures, node hierarchy, cameras, lights, node animation. Skins and
/// morph targets are shown in their rest pose: joints where their nodes stand without animation, default morph weights.
///
/// Core glTF 2.0 and KHR_materials_{emissive_strength, transmission, ior, specular, volume, unlit as a diffuse
/// emitter-free approximation}, KHR_texture_transform, KHR_lights_punctual, KHR_mesh_quantization. Anything else
/// optional is named once in a warning; an unsupported *required* extension, or a file that is damaged or hostile,
/// is one Error that names the file, the place and the mend. Numbers outside of the range that the specification gives
/// them are clamped, with one warning a file. alphaMode BLEND is a mask at 0.5. A scene without a camera gets one that
/// frames it; one without any light, not even one that is switched off, gets a white environment of radiance 1; both
/// with a warning. No triangles is an Error.
///
/// `extras` of the asset may hold "restirpg": {"environment": "sky.hdr" | [r, g, b], "strength": s, "rotation":
/// degrees, "bounces": n}; the path is relative to the file.
///
/// A file that the scene names but that does not lie at or below the scene's folder (symbolic links followed) is an
/// Error, unless `allowOutside`: a scene from elsewhere must not read what its author could not.
Scene loadGltf(const std::filesystem::path& file, bool allowOutside = false);

/// loadGltf, lit by `environment` where it is given (see replaceEnvironment), seen by its camera of this number. Throws
/// WrongValue when there is none.
Scene loadScene(const std::filesystem::path& file, const std::optional<std::string>& environment, uint32_t camera,
                bool allowOutside);

/// Read an equirectangular environment (.exr, .hdr), or parse "r,g,b" as a constant radiance.
Environment loadEnvironment(const std::string& source);

/// Light the scene by loadEnvironment(source) in place of its own environment. The file joins Scene::files.
void replaceEnvironment(Scene& scene, const std::string& source);

}  // namespace restirpg
