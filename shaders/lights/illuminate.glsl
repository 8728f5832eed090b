// SPDX-License-Identifier: MIT
// What a light gives to a point: KHR_lights_punctual to the letter, and the same falloff for the shapes that it lacks. Lights are read
// piece by piece: most that a list names are out of range of the very point, and then their position and range are all that is fetched.
//
// One function, light_strength(), decides whether a light's volume holds a point and how strongly; lists that ask for themselves call
// light_reaches() and get the answer that shading gets, to the bit.
#ifndef LIGHTS_ILLUMINATE_GLSL
#define LIGHTS_ILLUMINATE_GLSL

#extension GL_EXT_buffer_reference_uvec2 : require

#include "lights/iterate.glsl"
#include "lights/profile.glsl"
#include "shadows/maps.glsl"
#include "shadows/soft_rays.glsl"

// Which part of the light is left at `part` of the way from the axis to the edge (0 .. 1).
float light_edge(float part, float scale) {
    precise float rest = clamp((1.0 - part) * scale, 0.0, 1.0);
    return rest;
}

// Capsules, wedges and boxes. `ray` leads from the point to the light's position.
float light_shape_strength(light_list_block l, uint light, uint kind, vec3 ray, out vec3 to_light) {
    precise float strength = 0.0;
    vec3 direction = l.list.lights.at[light].shape.direction;
    vec3 size = l.list.lights.at[light].shape.size;
    to_light = -direction;
    if (kind == GPU_SHAPE_CAPSULE) {
        precise float along = clamp(-dot(ray, direction), -size.x, size.x);
        precise vec3 nearest = ray + direction * along;
        precise float distance2 = max(dot(nearest, nearest), 1e-8);
        precise float ratio2 = distance2 / (size.y * size.y);
        if (ratio2 >= 1.0) return 0.0;
        to_light = nearest * inversesqrt(distance2);
        strength = (1.0 - ratio2 * ratio2) / distance2;
        return strength;
    }
    vec3 side = l.list.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 at = vec3(-dot(ray, side), -dot(ray, up), -dot(ray, direction));
    float scale = l.list.lights.at[light].shape.spot_scale;
    if (kind == GPU_SHAPE_WEDGE) {
        if (at.z <= 0.0) return 0.0;
        precise vec2 limit = max(size.xy * at.z, vec2(1e-20));
        precise float edge = light_edge(abs(at.x) / limit.x, scale) * light_edge(abs(at.y) / limit.y, scale);
        float range = l.list.lights.at[light].shape.range;
        precise float distance2 = max(dot(ray, ray), 1e-8);
        precise float ratio2 = distance2 / (range * range);
        to_light = ray * inversesqrt(distance2);
        strength = (1.0 - ratio2 * ratio2) / distance2 * (edge * edge);
        return strength;
    }
    precise vec3 part = abs(at) / size;
    precise float edge = light_edge(part.x, scale) * light_edge(part.y, scale) * light_edge(part.z, scale);
    strength = edge * edge;
    return strength;
}

// Square metres.
float light_rectangle_area(light_list_block l, uint light) {
    precise float area = 4.0 * l.list.lights.at[light].shape.spot_scale * abs(l.list.lights.at[light].shape.spot_offset);
    return area;
}

// The steradians of a rectangle, roughly: of a distant one in full, and never 0 in its volume.
float light_rectangle_share(light_list_block l, uint light, vec3 position) {
    precise vec3 ray = l.list.lights.at[light].shape.position - position;
    precise float area = light_rectangle_area(l, light), distance2 = max(dot(ray, ray), 1e-8);
    precise float along = max(abs(dot(ray, l.list.lights.at[light].shape.direction)), 1e-12);
    precise float share = area * along * inversesqrt(distance2) / (distance2 + area * (1.0 / PI));
    return share;
}

// The falloff of capsules, from the nearest point of the rectangle. Times illuminate()'s share, which layers of shading divide by again (lights/area.glsl).
float light_rectangle_strength(light_list_block l, uint light, vec3 position, vec3 ray, out vec3 to_light) {
    vec3 direction = l.list.lights.at[light].shape.direction, side = l.list.lights.at[light].shape.side;
    precise vec3 up = cross(side, direction);
    precise vec3 at = vec3(-dot(ray, side), -dot(ray, up), -dot(ray, direction));
    float across = l.list.lights.at[light].shape.spot_scale, height = l.list.lights.at[light].shape.spot_offset;
    float range = l.list.lights.at[light].shape.size.z;
    to_light = vec3(0.0);
    if (height > 0.0 ? !(at.z > 0.0) : at.z == 0.0) return 0.0; // behind, or in its plane
    precise vec2 beside = max(abs(at.xy) - vec2(across, abs(height)), vec2(0.0));
    precise float distance2 = dot(beside, beside) + at.z * at.z;
    precise float ratio2 = distance2 / (range * range);
    if (ratio2 >= 1.0) return 0.0;
    to_light = ray * inversesqrt(max(dot(ray, ray), 1e-20));
    precise float strength = (1.0 - ratio2 * ratio2) * light_rectangle_share(l, light, position) / light_rectangle_area(l, light);
    return strength;
}

// Whether the light's hull holds a point; `ray` leads from the point to the light's position.
bool light_hull_holds(light_list_block l, uint light, uint count, vec3 ray) {
    plane_array planes = l.list.planes;
    uint first = l.list.lights.at[light].shape.hull_first;
    for (uint i = 0u; i < count; i++) {
        precise float from_light = -dot(planes.at[first + i].xyz, ray);
        if (from_light >= planes.at[first + i].w) return false;
    }
    return true;
}

// Illuminance at right angles to the ray that a light of colour 1 gives, in lux; `to_light` is unit. Exactly zero where the light's
// volume does not hold the position. `light` is an index into the light array, not of a directional light. Of a rectangle it is about that, from its
// middle: light_lobes_of() makes it right.
float light_strength(light_list_block l, uint light, vec3 position, out vec3 to_light) {
    precise vec3 ray = l.list.lights.at[light].shape.position - position;
    precise float distance2 = max(dot(ray, ray), 1e-8);
    float range = l.list.lights.at[light].shape.range;
    precise float ratio2 = distance2 / (range * range);
    to_light = vec3(0.0);
    if (ratio2 >= 1.0) return 0.0;
    uint kind = l.list.lights.at[light].shape.kind;
    precise float attenuation;
    if (LIST_SIMPLE || kind <= GPU_SHAPE_CONE) {
        precise float inverse_distance = inversesqrt(distance2);
        to_light = ray * inverse_distance;
        attenuation = (1.0 - ratio2 * ratio2) / distance2;
        if (kind == GPU_SHAPE_CONE) {
            precise float angular = clamp(dot(l.list.lights.at[light].shape.direction, -to_light) * l.list.lights.at[light].shape.spot_scale +
                                              l.list.lights.at[light].shape.spot_offset, 0.0, 1.0);
            attenuation *= angular * angular;
        }
        if (LIST_PROFILES) attenuation *= light_profile(l, light, to_light);
    } else {
        if (LIST_RECTANGLES && kind == GPU_SHAPE_RECTANGLE) attenuation = light_rectangle_strength(l, light, position, ray, to_light);
        else attenuation = light_shape_strength(l, light, kind, ray, to_light);
    }
    uint hull_count = LIST_SIMPLE ? 0u : l.list.lights.at[light].shape.hull_count;
    if (hull_count != 0u && !light_hull_holds(l, light, hull_count, ray)) return 0.0;
    return attenuation;
}

// The same with the light's colour.
vec3 illuminate(light_list_block l, uint light, vec3 position, out vec3 to_light) {
    precise float strength = light_strength(l, light, position, to_light);
    if (strength == 0.0) return vec3(0.0);
    precise vec3 result = l.list.lights.at[light].color * strength;
    return result;
}

// Metres from a position to where light comes from: the light, the nearest point of a capsule, the face of a box.
float light_distance(light_list_block l, uint light, vec3 position, vec3 to_light) {
    vec3 ray = l.list.lights.at[light].shape.position - position;
    uint kind = l.list.lights.at[light].shape.kind;
    if (LIST_SIMPLE || kind <= GPU_SHAPE_CONE || kind == GPU_SHAPE_WEDGE || LIST_RECTANGLES && kind == GPU_SHAPE_RECTANGLE) return length(ray);
    vec3 direction = l.list.lights.at[light].shape.direction, size = l.list.lights.at[light].shape.size;
    if (kind == GPU_SHAPE_BOX) return size.z - dot(ray, direction);
    return length(ray + direction * clamp(-dot(ray, direction), -size.x, size.x));
}

bool light_casts(light_list_block l, uint light) { return l.list.lights.at[light].source >= 0.0; }

// How far from their surfaces the positions may be that pixels are shaded at, metres: some ten roundings of floats (6e-8) as large as the distances from the
// world's origin and from the eye, twice over. Depths of orthographic views are all as coarse as the
// farthest. With several samples a pixel, positions are interpolated somewhere in it, and may be a pixel's width beside the triangle.
float shadow_slack(light_list_block l, vec3 position) {
    view_block v = l.list.view;
    float seen_from = length(v.view.eye - position), slack = 2e-6 * (length(position) + seen_from);
    slack += v.view.orthographic * 1.2e-7 * abs(v.view.depth_decode.y);
    return v.view.samples > 1u ? slack + pixel_width(v, seen_from) : slack;
}

// What shadow_visibility() needs of a point. Nothing where lists have no shadows.
shadowed_point shadowed_point_of(light_list_block l, vec3 position, vec3 normal) {
    shadowed_point p;
    if (!LIST_SHADOWED) return p;
    p.position = position;
    p.normal = normal;
    p.slack = shadow_slack(l, position);
    if (LIST_MAPS || LIST_CUBEMAP) {
        view_block v = l.list.view;
        p.pixel = pixel_width(v, length(v.view.eye - position));
    }
    if (LIST_MAPS) p.maps = shadow_maps_block(l.list.shadow_maps).maps;
    if (LIST_CUBEMAP) {
        p.probes = probes_block(l.list.probes).probes;
        p.probe = probe_find(p.probes, 0u, position);
        p.other = p.probes.count;
        if (p.probe < p.probes.count) {
            p.place = probe_place(p.probes.probes.at[p.probe], position);
            p.other = probe_find(p.probes, p.probe + 1u, position);
        }
        if (p.other < p.probes.count) {
            gpu_probe other = p.probes.probes.at[p.other];
            float first = probe_weight(p.probes.probes.at[p.probe], p.place), second = probe_weight(other, probe_place(other, position));
            p.part = first / (first + second);
        }
    }
    return p;
}

// What the walls of the point's room let in of a light outside, `away` metres off (1: one that is parallel), and which items else may hide it: all
// where the point is in no room or the light is in the room too.
vec3 cubemap_visibility(light_list_block l, uint light, shadowed_point p, vec3 to_light, float away, bool endless, out ray_scope scope) {
    scope = ray_everything();
    if (p.probe >= p.probes.count) return vec3(1.0);
    gpu_probe probe = p.probes.probes.at[p.probe];
    vec3 along = probe_turn(probe, to_light);
    if (!endless && probe_holds(probe, p.place + along * away)) return vec3(1.0);
    float spread = 0.0;
    if ((p.probes.flags & PROBES_PHYSICAL) != 0u) {
        bool parallel = endless || l.list.lights.at[light].shape.kind == GPU_SHAPE_BOX;
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

// The part of a light, by its colours, that comes to the point through the walls of its room and what is in there. In the boxes of two probes: that of each
// by its part, so that nothing jumps where one ends.
vec3 rooms_visibility(light_list_block l, uint light, shadowed_point p, vec3 to_light, float away, float margin, bool endless) {
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

// Whether some of a light comes from before the surface, as far as the direction to its middle tells.
bool light_may_face(light_list_block l, uint light, vec3 normal, vec3 to_light) {
    return dot(normal, to_light) > 0.0 || LIST_RECTANGLES && l.list.lights.at[light].shape.kind == GPU_SHAPE_RECTANGLE;
}

// The part, 0 .. 1, of a light that no surface stops on its way to the point; `to_light` and `light` as illuminate() has them. 0 also for light that
// comes from behind the surface, which reflects none of it. Its colours differ only with LIST_CUBEMAP.
vec3 shadow_visibility(light_list_block l, uint light, shadowed_point p, vec3 to_light) {
    if (!LIST_SHADOWED || !light_casts(l, light)) return vec3(1.0);
    if (!light_may_face(l, light, p.normal, to_light)) return vec3(0.0);
    if (LIST_MAPS) {
        float open = map_visibility(l, light, p);
        if (!LIST_RAYS || open >= 0.0) return vec3(abs(open)); // nothing is known of what no pixel asked for: light
    }
    float high = light_distance(l, light, p.position, to_light);
    if (LIST_CUBEMAP) {
        float margin = max(p.slack, 1e-6 * length(l.list.lights.at[light].shape.position));
        return rooms_visibility(l, light, p, to_light, high, margin, false);
    }
    float margin = max(p.slack, 1e-6 * length(l.list.lights.at[light].shape.position)); // a lamp on a surface shines
    return vec3(rays_visibility(l, ray_everything(), light, p.position, p.normal, to_light, high, margin, p.slack));
}

// The same of a directional light.
vec3 sun_visibility(light_list_block l, uint light, shadowed_point p) {
    if (!light_casts(l, light)) return vec3(1.0);
    vec3 to_light = -l.list.lights.at[light].shape.direction;
    if (!(dot(p.normal, to_light) > 0.0)) return vec3(0.0);
    if (LIST_MAPS) {
        float open = sun_map_visibility(l, light, p);
        if (!LIST_RAYS || open >= 0.0) return vec3(abs(open));
    }
    if (LIST_CUBEMAP) return rooms_visibility(l, light, p, to_light, 1.0, 0.0, true);
    return vec3(rays_visibility(l, ray_everything(), light, p.position, p.normal, to_light, 1.0, 0.0, p.slack));
}

// What a directional light gives, in lux.
vec3 sun_illuminance(light_list_block l, uint light, shadowed_point p) {
    vec3 color = l.list.lights.at[light].color;
    return LIST_SHADOWED ? color * sun_visibility(l, light, p) : color;
}

// Whether the light's volume holds the position: true wherever illuminate() is not zero. Broken positions are held by all lights.
bool light_reaches(light_list_block l, uint light, vec3 position) {
    vec3 to_light;
    float strength = light_strength(l, light, position, to_light);
    return !(strength <= 0.0) && any(greaterThan(l.list.lights.at[light].color, vec3(0.0)));
}

#endif
