// SPDX-License-Identifier: MIT
// GPU_LIGHTING_CUBEMAP: the walls of the room that holds the point, as its probe saw them, and rays for what is in there.
#ifndef LIGHTING_VISIBILITY_ROOMS_GLSL
#define LIGHTING_VISIBILITY_ROOMS_GLSL

// The fraction, per color, of a light outside the point's room that the walls let in. `away`: distance in meters; 1 for a directional light. `scope`: the
// other items that may occlude the light; all items if the point is in no room or the light is in the same room.
vec3 cubemap_visibility(lighting_block l, uint light, shadowed_point p, vec3 to_light, float away, bool endless, out ray_scope scope) {
    scope = ray_everything();
    if (p.probe >= p.probes.count) return vec3(1.0);
    gpu_probe probe = p.probes.probes.at[p.probe];
    vec3 along = probe_turn(probe, to_light);
    if (!endless && probe_holds(probe, p.place + along * away)) return vec3(1.0);
    float spread = 0.0;
    if ((p.probes.flags & PROBES_PHYSICAL) != 0u) {
        bool parallel = endless || l.scope.lights.lights.at[light].shape.kind == GPU_SHAPE_BOX;
        spread = 2.0 * source_size(l, light, parallel) / (parallel ? 1.0 : max(away, 1e-6));
    }
    bool inside = (p.probes.flags & PROBES_INSIDE) != 0u;
    float room = inside ? box_exit(p.place, along, max(probe.half_size - probe.wall, vec3(0.0))) : 0.0;
    scope = ray_scope(RAY_SOME, room, p.probes.moving);
    return probe_light(p.probes, probe, probe_look(probe, p.probes.flags, p.place, along, spread, p.pixel));
}

// Whether a ray is to be sent for what is left of a light.
bool cubemap_sends_rays(shadowed_point p, ray_scope scope, vec3 open) {
    if (scope.kind == RAY_EVERYTHING) return true;
    return max_component(open) > 0.0 && (scope.high > 0.0 || (p.probes.flags & PROBES_MOVERS) != 0u);
}

// The fraction of a light, per color, that reaches the point past the walls of its room and the items inside. In the boxes of two probes, the results of
// both are blended by weight, so that nothing jumps where a box ends.
vec3 rooms_visibility(lighting_block l, uint light, shadowed_point p, vec3 to_light, float away, float margin, bool endless) {
    bool two = p.other < p.probes.count;
    vec3 sum = vec3(0.0);
    for (uint side = 0u; side < 2u; side++) {
        ray_scope scope;
        vec3 open = cubemap_visibility(l, light, p, to_light, away, endless, scope);
        if (cubemap_sends_rays(p, scope, open)) open *= rays_visibility(l, scope, light, p.position, p.normal, to_light, away, margin, p.slack);
        if (!two) return open;
        sum += (side == 0u ? p.part : 1.0 - p.part) * open;
        p.probe = p.other;
        p.place = probe_place(p.probes.probes.at[p.probe], p.position);
    }
    return sum;
}

#endif
