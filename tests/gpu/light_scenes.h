// Small scenes for the light tests, built in memory.
#pragma once

#include "render/scene_gpu.h"

namespace restirpg::test {

/// Emissive triangles, one-sided, double-sided, textured and alpha-masked, in a plain, a sheared and a mirrored
/// instance around the origin; no other light.
Scene triangleLightScene();

/// Large double-sided triangles whose textures light a few places of them only: filtered and not, with every wrap mode.
Scene signScene();

/// A scene without a light: one small black triangle far away, since a scene must have geometry.
Scene darkScene();

/// A sky with a gradient, a bright patch near the horizon and a black half; 64 x 32 texels, turned by 0.7 radians.
Environment sunnySky();

/// One point, one spot (45 degrees, inner 20 degrees), one directional light.
void addPunctualLights(Scene& scene);

/// A scene on the device, with the frame constants that kernels read.
struct UploadedScene {
    explicit UploadedScene(Scene source);

    Scene scene;
    SceneGpu gpu;
    Buffer frame;
};

}  // namespace restirpg::test
