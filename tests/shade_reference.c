/* SPDX-License-Identifier: MIT */
#include "tests/shade_reference.h"

#include "ray/brdf.h"
#include "ray/light.h"
#include "ray/tone.h"
#include "tests/light_reference.h"

struct reference_surface reference_surface_default(void) {
    return (struct reference_surface){.normal = {0, 0, 1},
                                      .base_color = {1, 1, 1},
                                      .metallic = 1,
                                      .roughness = 1,
                                      .occlusion = 1,
                                      .ior = 1.5,
                                      .specular = 1,
                                      .specular_color = {1, 1, 1}};
}

static dvec3 from(const double v[3]) { return dvec3_make(v[0], v[1], v[2]); }
static void to(dvec3 v, double out[3]) {
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static double dot3(const double v[3]) { return v[0] * v[0] + v[1] * v[1] + v[2] * v[2]; }

enum { RECTANGLE_STEPS = 48 }; /* points on a side that stand for all */

void reference_shade(const struct reference_surface *s, const double to_view[3], const fnl_light_params *lights,
                     uint32_t light_count, fnl_vec3 ambient_sky, fnl_vec3 ambient_ground, double out[3]) {
    struct ray_surface surface = {.position = from(s->position),
                                  .normal = from(s->normal),
                                  .geometric = from(dot3(s->geometric) > 0 ? s->geometric : s->normal),
                                  .base_color = from(s->base_color),
                                  .metallic = s->metallic,
                                  .roughness = s->roughness,
                                  .occlusion = s->occlusion,
                                  .f90 = s->specular};
    for (int i = 0; i < 3; i++)
        (&surface.f0.x)[i] = fmin(ray_ior_reflectance(s->ior) * s->specular_color[i], 1) * s->specular;
    dvec3 sum = dvec3_add(from(s->emissive), ray_ambient(&surface, from(to_view), dvec3_from(ambient_sky), dvec3_from(ambient_ground)));
    for (uint32_t k = 0; k < light_count; k++) {
        const struct ray_light light = ray_light_make(&lights[k], light_reference_range(&lights[k]), NULL);
        double distance;
        dvec3 to_light;
        for (int i = 0; i < RECTANGLE_STEPS * RECTANGLE_STEPS && light.kind == FNL_LIGHT_RECTANGLE; i++) {
            const double u = (i / RECTANGLE_STEPS + 0.5) / RECTANGLE_STEPS, v = (i % RECTANGLE_STEPS + 0.5) / RECTANGLE_STEPS,
                         part = ray_light_sample(&light, surface.position, u, v, &to_light, &distance) / (RECTANGLE_STEPS * RECTANGLE_STEPS);
            if (part > 0) sum = dvec3_add_scaled(sum, dvec3_mul(ray_brdf_cos(&surface, from(to_view), to_light), light.color), part);
        }
        if (light.kind == FNL_LIGHT_RECTANGLE) continue;
        double strength = ray_light_strength(&light, surface.position, &to_light, &distance);
        if (!(strength > 0)) continue;
        sum = dvec3_add_scaled(sum, dvec3_mul(ray_brdf_cos(&surface, from(to_view), to_light), light.color), strength);
    }
    to(sum, out);
}

void reference_tonemap(fnl_tonemap tonemap, const double in[3], double out[3]) { to(ray_tone_map(tonemap, from(in)), out); }

double reference_srgb(double linear) { return ray_srgb(linear); }
