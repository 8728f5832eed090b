// SPDX-License-Identifier: MIT
// The page of a shadow map that is looked up for a light at a point.
#ifndef SHADOW_LOOKUP_GLSL
#define SHADOW_LOOKUP_GLSL

#include "lighting/visibility.glsl"

// What a look-up finds.
struct finding {
    bool found;
    uint row;
    shadow_page page;
    uint place;  // in the atlas
    float texel; // over the width of a pixel
    vec2 inside; // texels from the page's least corner, without its border
    bool asked;  // it is the page that the pixel asks for, not a coarser one that stands in for it
};

// The page of a row that holds a point, from page.level on.
bool look_up_row(shadowed_point p, gpu_shape shape, inout finding f) {
    vec4 clip = shadow_face_clip(shape, f.page.face, p.position - shape.position);
    vec2 ndc = clip.xy / clip.w;
    uint asked = f.page.level;
    if (!shadow_find_from(p.maps, f.row, ndc, f.page, f.place)) return false;
    f.asked = f.page.level == asked;
    f.texel = shadow_across(shape, clip.w, p.pixel) / shadow_width(f.page.level);
    f.inside = shadow_page_texel(f.page, ndc) - float(SHADOW_BORDER);
    return true;
}

// The page from which map_visibility() and sun_map_visibility() answer.
finding look_up(lighting_block l, uint light, shadowed_point p) {
    finding f;
    f.found = f.asked = false;
    gpu_shape shape = l.scope.lights.lights.at[light].shape;
    if (!LIGHTING_MAPS || !shadow_has_map(shape)) return f;
    if (light < l.scope.lights.directional_count) {
        f.page.face = 0u;
        int grid = shadow_sun_grid(p.maps.suns.at[light], p.pixel);
        bool first = true;
        shadow_oblong oblong;
        view_block v = l.scope.view;
        bool is_oblong = shadow_oblong_at(p.maps, v, light, p.position, p.pixel, oblong, f.row) && p.maps.biases.at[f.row] != SHADOW_TRACED;
        if (is_oblong) grid--;
        for (; !f.found && (is_oblong || shadow_sun_find(p.maps, light, p.position, grid, f.row)); grid++) {
            is_oblong = false;
            f.page.level = p.maps.biases.at[f.row];
            f.found = look_up_row(p, p.maps.shapes.at[f.row], f);
            f.asked = f.asked && first;
            first = false;
        }
        return f;
    }
    f.row = light + p.maps.first_row;
    uint bias = p.maps.biases.at[f.row];
    if (bias == SHADOW_TRACED) return f;
    vec3 ray = p.position - shape.position;
    f.page.face = shadow_face_of(shape.kind, ray);
    float along = shadow_face_clip(shape, f.page.face, ray).w;
    f.page.level = min(shadow_level_for(shadow_across(shape, along, p.pixel), p.maps.widest) + bias, SHADOW_LEVELS - 1u);
    f.found = look_up_row(p, shape, f);
    return f;
}

#endif
