// SPDX-License-Identifier: MIT
// The fraction of a light that reaches a point unoccluded, by any shadow method.
#ifndef LIGHTING_VISIBILITY_GLSL
#define LIGHTING_VISIBILITY_GLSL

#include "lighting/reach.glsl"
#include "shadows/maps.glsl"
#include "shadows/soft_rays.glsl"

// Largest distance between a shaded position and its surface, in meters: some ten float roundings (6e-8) at the scale of the distances from the world's
// origin and from the eye, doubled. In orthographic views all depths are as coarse as the farthest. With several samples per pixel, positions are
// interpolated between samples and are less exact. A larger share of the pixel would let light through where something hides the light close to a surface.
float shadow_slack(lighting_block l, vec3 position) {
    view_block v = l.scope.view;
    float seen_from = length(v.view.eye - position), slack = 2e-6 * (length(position) + seen_from);
    slack += v.view.orthographic * 1.2e-7 * abs(v.view.depth_decode.y);
    return v.view.samples > 1u ? slack + pixel_width(v, seen_from) * (1.0 / 64.0) : slack;
}

// What light_visibility() needs of a point. Nothing where lists have no shadows.
shadowed_point shadowed_point_of(lighting_block l, vec3 position, vec3 normal) {
    shadowed_point p;
    if (!LIGHTING_SHADOWED) return p;
    p.position = position;
    p.normal = normal;
    p.slack = shadow_slack(l, position);
    if (LIGHTING_MAPS || LIGHTING_CUBEMAP) {
        view_block v = l.scope.view;
        p.pixel = pixel_width(v, length(v.view.eye - position));
    }
    if (LIGHTING_MAPS) p.maps = shadow_maps_block(l.scope.shadows.maps).maps;
    if (LIGHTING_CUBEMAP) {
        p.probes = probes_block(l.scope.shadows.rooms).probes;
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

#include "lighting/visibility_rooms.glsl"
#include "lighting/visibility_contact.glsl"

// Whether some of a light comes from before the surface, as far as the direction to its middle tells.
bool light_may_face(light_set_block l, uint light, vec3 normal, vec3 to_light) {
    return dot(normal, to_light) > 0.0 || LIGHTING_AREA_LIGHTS && shape_is_area(l.set.lights.at[light].shape.kind);
}

// The unshadowed fraction of a light, 0 .. 1; also 0 for light from behind the surface, which reflects none of it. `light` and `to_light` are those of
// light_reach(), or of sun_reach() if `is_sun`. The color channels differ only with LIGHTING_CUBEMAP.
vec3 light_visibility(lighting_block l, uint light, shadowed_point p, vec3 to_light, bool is_sun) {
    if (!LIGHTING_SHADOWED || !light_casts(lights_of(l), light)) return vec3(1.0);
    if (!light_may_face(lights_of(l), light, p.normal, to_light)) return vec3(0.0);
    float contact = 1.0;
    if (LIGHTING_CONTACT) {
        contact = contact_visibility(l, light, p, to_light, is_sun);
        if (contact == 0.0 || !LIGHTING_RAYS && !LIGHTING_MAPS) return vec3(contact);
    }
    if (LIGHTING_MAPS) {
        float open = is_sun ? sun_map_visibility(l, light, p) : map_visibility(l, light, p);
        if (!LIGHTING_RAYS || open >= 0.0) return vec3(abs(open) * contact); // nothing is known of what no pixel asked for: light
    }
    float away = 1.0, margin = 0.0;
    if (!is_sun) {
        away = light_distance(lights_of(l), light, p.position, to_light);
        margin = max(p.slack, 1e-6 * length(l.scope.lights.lights.at[light].shape.position)); // a lamp on a surface shines
    }
    if (LIGHTING_CUBEMAP) return rooms_visibility(l, light, p, to_light, away, margin, is_sun) * contact;
    return vec3(rays_visibility(l, ray_everything(), light, p.position, p.normal, to_light, away, margin, p.slack) * contact);
}

#endif
