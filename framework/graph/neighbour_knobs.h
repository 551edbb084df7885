// What ReSTIRDI and ReSTIRReuse declare alike: the inputs of temporal reuse, and the knobs of NeighbourRules.
#pragma once

#include "graph/interface.h"
#include "shaders/restir/neighbour_types.h"
#include "shaders/scene/scene_types.h"

namespace restirpg {

/// The inputs of temporal reuse, wired all or not at all. `port`: the pass's reservoirs in graphs, "reuse.reservoirs".
inline void historyInputs(Interface& io, In<Buffer>& motion, In<Buffer>& previousSurface, In<Buffer>& history,
                          const PortType& reservoir, const std::string& port)
{
    io.optionalInput("motion", motion, motionVectors(),
                     "where the point was in the frame before, minus where it is, in pixels");
    io.ofThisFrame();
    io.optionalInput("previous_surface", previousSurface, perPixel<PrimaryHit>("Surface"),
                     "the surface one frame ago: prev(\"gbuffer.surface\")");
    io.ofFrameBefore();
    io.optionalInput("history", history, reservoir, "the output reservoirs, one frame ago: prev(\"" + port + "\")");
    io.ofFrameBefore();
    io.together({"motion", "previous_surface", "history"});
}

/// How many neighbours there are. `pool`: what one of them is chosen from, "pixels".
inline void neighbourKnobs(Interface& io, NeighbourRules& rules, const std::string& pool)
{
    io.knob("neighbours", rules.neighbours, 1, MAX_NEIGHBOURS, "pixels drawn in one round");
    io.knob("pool", rules.pool, 1, MAX_POOL,
            pool + " that each neighbour is chosen from, by how much its surface is like this pixel's; 1: the one that "
                   "is drawn, as published");
}

/// How far away they are.
inline void diskKnobs(Interface& io, NeighbourRules& rules)
{
    io.knob("radius", rules.radius, 1, 1000,
            "radius of the disk from which neighbours are drawn, in pixels of an image of 1080 lines; it scales with "
            "the image's height, down to least_radius");
    io.knob("least_radius", rules.leastRadius, 1, 1000, "least radius of the disk, in pixels of the rendered image");
}

/// How similar they are.
inline void similarityKnobs(Interface& io, NeighbourRules& rules)
{
    io.knob("normal_threshold", rules.normalThreshold, -1, 1,
            "smallest cosine between the shading normals of pixels that are merged");
    io.knob("depth_threshold", rules.depthThreshold, 0, 1000,
            "largest relative difference of their distances from the camera");
}

}  // namespace restirpg
