#version 460
#include "prelude.glsl"
#include "edge.glsl"
#include "samples.glsl"
#include "scene/primary_hit.glsl"
#include "restir/path_reservoir.glsl"
#include "restir/resampling.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

// Streaming RIS along the pixel's path trees: every vertex offers the path that ends there by a light sample, and the one that ends where
// scattering meets an emitter. A path is its vertices and labels, whichever technique made it; both techniques' densities stand in
// one balance heuristic [shaders/README: One balance heuristic over both endings].

/// The path traced so far. `path` is a reservoir whose labels, prefix and (once k is known) anchor are those of the prefix.
struct Tree {
    PathReservoir path;
    uint k;  ///< 0: no edge of the prefix can reconnect
    vec3 f;  ///< product of the bounces, each in its measure, and of absorption
    float inverse_pdf;  ///< in that measure
    Hit hit;  ///< of the vertex the path stands at
    float arrival;  ///< length of the edge it arrived by, m
    float arrival_geometry;
};

/// What the offers have come to.
PathReservoir kept;
float weight_sum;

/// P(l) Q_l(wi): density of scatter with label l, 1/sr; the mixture with the guide for the smooth label. Delta labels: 0.
float label_density(Vertex v, uint label, vec3 local, vec3 wi)
{
    ShadingPoint p = v.point;
    float density = bsdf_pdf(p.bsdf, p.lobe_probabilities, p.wo, local, label_lobes(p.bsdf, label));
    if (label == LABEL_SMOOTH && v.guided)
        density += guide_correction(v, wi, density);
    return density;
}

/// P_n(label): how a light sample's path draws the label of its last bounce, in proportion to the labels' luminances.
vec3 label_shares(LabelValues values)
{
    float sharp = luminance(values.sharp_value);
    bool reflects = values.sharp_label == LABEL_SHARP_REFLECT;
    vec3 shares = vec3(luminance(values.smooth_value), reflects ? sharp : 0.0, reflects ? 0.0 : sharp);
    return shares / max(shares.x + shares.y + shares.z, 1e-30);
}

/// Weigh a whole path against those before it, and keep it or not.
void offer(PathReservoir path, float weight, float u)
{
    if (weight > 0.0 && !isinf(weight) && resample(weight_sum, weight, u))
        kept = path;
}

/// A direction with its label: what the tree takes along an edge.
struct Bounce {
    uint label;
    bool delta;
    vec3 local;
    vec3 wi;
    vec3 value;  ///< f |cos|; of a delta its throughput
    vec3 shares;  ///< label_shares
    float density;  ///< P(l) Q_l; of a delta P(l)
    /// What an inner bounce's value is divided by in f: the density of a rough sharp lobe's own draw; else 1. The product of many undivided
    /// ones would be beyond float32 [shaders/README: Measures].
    float replay_pdf;
};

/// f |cos| of a label's rough lobes in a world direction.
vec3 label_value_along(Vertex v, uint label, vec3 wi)
{
    vec3 local = to_local(v.point.local_frame, wi);
    vec3 f = bsdf_eval(v.point.bsdf, v.point.wo, local, label_lobes(v.point.bsdf, label));
    return is_consistent(v.point, local, wi) ? f * abs(local.z) : vec3(0.0);
}

/// Bounce u of a path: its label, whether it is a delta, and the direction of a smooth one.
void note_bounce_in_path(inout PathReservoir path, uint u, Bounce s)
{
    path.labels = set_path_label(path.labels, u, s.label);
    if (s.delta)
        set_delta_bounce(path, u);
    uint slot = prefix_slot(path.labels, u);
    if (s.label == LABEL_SMOOTH && slot < PATH_PREFIX)
        path.prefix[slot] = pack_direction(s.wi);
}

/// The tree's vertex becomes x_k, which the path leaves in direction wi.
void reconnect_at_vertex(inout PathReservoir path, Tree tree, vec3 wi)
{
    path.anchor = uvec2(tree.hit.instance, tree.hit.triangle);
    path.place = tree.hit.barycentrics;
    path.direction = pack_direction(wi);
    path.geometry = tree.arrival_geometry;
    path.suffix = vec3(1.0);
}

/// The path that leaves the tree's vertex x_u by `bounce` and ends on the light at `point`, at the end of edge e. `radiance`: of the
/// light, times the absorption on the way. f is that of the path as a shift would rebuild it: the stored direction, or the light's.
PathReservoir end_path(Tree tree, Vertex v, uint u, Bounce bounce, LightPoint point, LightEdge e, vec3 radiance)
{
    PathReservoir path = tree.path;
    note_bounce_in_path(path, u, bounce);
    uint k = tree.k;
    bool interior = k == 0u && u >= 2u && is_connectable(path_label(path.labels, u - 1u), bounce.label, tree.arrival);
    if (k == 0u && !bounce.delta)
        bounce.value = label_value_along(v, bounce.label, interior ? unpack_direction(pack_direction(bounce.wi)) : e.wi);
    vec3 end = bounce.value * radiance;
    path.f = tree.f * end;
    if (k > 0u) {
        path.suffix *= end;
    } else if (interior) {
        k = u;
        reconnect_at_vertex(path, tree, bounce.wi);
        path.suffix = radiance;
    } else {
        k = bounce.delta ? 0u : u + 1u;  // nothing connects through a delta
        set_anchor(path, point);
        path.geometry = bounce.delta ? 1.0 : e.jacobian;
    }
    set_path_shape(path, u + 1u, k);
    return path;
}

/// Offer the path that one light sample ends.
void offer_light_sample(Tree tree, Vertex v, uint u, RandomKey key, RandomKey choices)
{
    LightPoint point;
    ShadingPoint p = v.point;
    if (bsdf_rough_lobes(p.bsdf, LOBE_ALL) == 0u || !sample_light_point(random4(key, u, RANDOM_LIGHT), point))
        return;
    LightEdge e = edge_to_light(point, p.position, false);
    vec3 local = to_local(p.local_frame, e.wi);
    if (e.radiance == vec3(0.0) || e.jacobian <= 0.0 || e.light_pdf <= 0.0 || !is_consistent(p, local, e.wi))
        return;
    LabelValues values = label_values(p.bsdf, p.wo, local);
    vec3 shares = label_shares(values);
    vec4 numbers = random4(choices, u, 0u);
    uint label = numbers.x < shares.x ? LABEL_SMOOTH : numbers.x < shares.x + shares.y ? LABEL_SHARP_REFLECT : LABEL_SHARP_TRANSMIT;
    if (shares[label] <= 0.0 || !is_lit(ray_end(p), e))
        return;
    Bounce bounce = Bounce(label, false, local, e.wi, value_of_label(values, label), shares, 0.0, 1.0);
    float density = e.light_pdf / e.jacobian * shares[label] + (e.delta ? 0.0 : label_density(v, label, local, e.wi));
    vec3 light = e.radiance * edge_transmittance(p, e);
    PathReservoir path = end_path(tree, v, u, bounce, point, e, light);
    path.shape |= PATH_LIGHT_SAMPLED;
    offer(path, luminance(path.f) * tree.inverse_pdf / density, numbers.y);
    note_light(u, bounce.value * light / density);
}

/// Draw the label, then the direction: by BSDF or guide within the smooth label, by the lobe alone within a sharp one. density 0: none.
Bounce scatter_labelled(Vertex v, RandomKey key, uint u)
{
    ShadingPoint p = v.point;
    vec4 numbers = random4(key, u, RANDOM_DIRECTION);
    uint lobe = bsdf_select_lobe(p.lobe_probabilities, LOBE_ALL, numbers.z);
    Bounce s = Bounce(label_of_lobe(p.bsdf, lobe), false, vec3(0.0), vec3(0.0), vec3(0.0), vec3(0.0), 0.0, 1.0);
    if (lobe == 0u)
        return s;
    bool guided = s.label == LABEL_SMOOTH && v.guided && random1(key, u, RANDOM_TECHNIQUE) >= v.alpha;
    if (guided) {
        s.wi = sample_guided(v, vec3(numbers.xy, random1(key, u, RANDOM_GUIDE_LOBE)));
        if (s.wi == vec3(0.0))
            return s;
    } else {
        BsdfSample drawn = bsdf_sample_lobe(p.bsdf, p.wo, lobe, numbers.xy);
        if (drawn.pdf <= 0.0)
            return s;
        s.local = drawn.wi;
        s.wi = to_world(p.local_frame, drawn.wi);
        s.delta = drawn.delta;
        s.value = drawn.weight;
        s.density = s.delta ? probability_of_lobe(p.lobe_probabilities, lobe) : 0.0;
        s.replay_pdf = s.label == LABEL_SMOOTH ? 1.0 : drawn.pdf;
    }
    if (s.delta)
        return s;
    if (s.label == LABEL_SMOOTH) {
        s.wi = unpack_direction(pack_direction(s.wi));
        s.local = to_local(p.local_frame, s.wi);
    }
    LabelValues values = label_values(p.bsdf, p.wo, s.local);
    s.value = value_of_label(values, s.label);
    s.shares = label_shares(values);
    s.density = label_density(v, s.label, s.local, s.wi);
    return s;
}

/// Offer the path whose scattered edge has met a light.
void offer_found_light(Tree tree, Vertex v, uint u, Bounce s, Arrival a, RandomKey choices)
{
    LightPoint point = point_in_environment(s.wi);
    if (a.found)
        point = point_on_triangle(a.hit.instance, a.hit.triangle, a.hit.barycentrics);
    LightEdge e = edge_to_light(point, v.point.position, false);
    float density = s.density;
    if (!s.delta && e.jacobian > 0.0 && params.nextEventEstimation != 0u)
        density += e.light_pdf / e.jacobian * s.shares[s.label];
    PathReservoir path = end_path(tree, v, u, s, point, e, a.emission * a.absorption);
    offer(path, luminance(path.f) * tree.inverse_pdf / density, random4(choices, u, 0u).z);
    note_light(u + 1u, a.emission * (s.density / density));
}

/// Note the bounce in the path, and the reconnection if this edge's end is the first that can.
void extend_path(inout Tree tree, uint u, Bounce s)
{
    note_bounce_in_path(tree.path, u, s);
    if (tree.k > 0u)
        return;
    if (u >= 2u && is_connectable(path_label(tree.path.labels, u - 1u), s.label, tree.arrival)) {
        tree.k = u;
        reconnect_at_vertex(tree.path, tree, s.wi);
    }
}

/// Take the bounce at x_u, and the edge to the surface where it arrived, into the tree.
void advance(inout Tree tree, uint u, Bounce s, Arrival a)
{
    vec3 value = s.value / s.replay_pdf;
    if (tree.k > 0u)
        tree.path.suffix *= value;
    extend_path(tree, u, s);
    if (tree.k > 0u)
        tree.path.suffix *= a.absorption;
    tree.f *= value * a.absorption;
    tree.inverse_pdf *= s.replay_pdf / s.density;
    tree.hit = a.hit;
    tree.arrival = a.distance;
    tree.arrival_geometry = edge_geometry(a.vertex.point.normal, s.wi, a.distance);
}

void trace_tree(Hit hit, uvec2 at, uint number)
{
    RandomKey key = tree_key(random_key(picture_pixel(at), frame.c.frame, frame.c.seed), number);
    RandomKey choices = RandomKey(key.pixel, key.frame, key.seed ^ RANDOM_STREAM_RESAMPLING);
    Vertex v = primary_vertex(hit, at);
    vec3 seen = transmittance_to_camera(v.point, frame.c.camera.position);
    Tree tree = Tree(empty_path_reservoir(1.0), 0u, seen, 1.0, hit, 0.0, 0.0);
    tree.path.pixel = key.pixel;
    tree.path.frame = key.frame;

    for (uint u = 1u; u <= params.bounces + 1u; ++u) {
        if (u > 1u && params.nextEventEstimation != 0u)  // direct light at x_1 is ReSTIR DI's, but for what delta lobes find [shaders/README: Who owns which light]
            offer_light_sample(tree, v, u, key, choices);
        Bounce s = scatter_labelled(v, key, u);
        if (s.density <= 0.0 || s.value == vec3(0.0) || !is_consistent(v.point, s.local, s.wi))
            return;

        Arrival a = follow(v, s.wi, at, u);
        note_bounce(u, v, s.label, s.wi, s.value, s.density, a);
        bool owned = u > 1u || s.delta;
        if (owned && a.emission != vec3(0.0))
            offer_found_light(tree, v, u, s, a, choices);
        if (!a.found)
            return;
        advance(tree, u, s, a);
        v = a.vertex;
    }
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    kept = empty_path_reservoir(1.0);
    weight_sum = 0.0;
    Hit hit = primary_hit(params.surface, pixel);
    [[dont_unroll]] for (uint i = 0u; i < params.trees; ++i) {
        begin_samples();
        if (hit.instance != INVALID_INDEX)
            trace_tree(hit, at, i);
        write_samples(pixel * params.trees + i);
    }
    kept.confidence = 1.0;
    kept.ucw = weight_sum > 0.0 ? weight_sum / (float(params.trees) * luminance(kept.f)) : 0.0;
    if (params.candidates != 0ul)
        PathReservoirArray(params.candidates).at[pixel] = kept;
}
