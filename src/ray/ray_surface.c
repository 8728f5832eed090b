/* SPDX-License-Identifier: MIT */
/* What a ray finds where it meets a triangle. */
#include "layers_shared.h"
#include "ray/ray_internal.h"

static void interpolate_uv(const struct ray_part *part, uint32_t triangle, double u, double v, double out[2][2]) {
    const struct scene_primitive *p = part->primitive;
    const uint32_t *c = p->indices + 3 * (size_t)triangle;
    for (int set = 0; set < 2; set++) {
        out[set][0] = out[set][1] = 0;
        if (!p->uv[set]) continue;
        const vec2 *uv = p->uv[set];
        out[set][0] = (double)uv[c[0]].x * (1 - u - v) + (double)uv[c[1]].x * u + (double)uv[c[2]].x * v;
        out[set][1] = (double)uv[c[0]].y * (1 - u - v) + (double)uv[c[1]].y * u + (double)uv[c[2]].y * v;
    }
}

static dvec3 carry(const dvec3 columns[3], dvec3 v) { return dvec3_combine(columns[0], columns[1], columns[2], v); }

/* Where a ray meets the plane of a triangle, as weights of corners 1 and 2 (Möller & Trumbore 1997); false where it is seen edge-on. */
static bool meet(const dvec3 p[3], dvec3 origin, dvec3 direction, double *u, double *v) {
    dvec3 e1 = dvec3_sub(p[1], p[0]), e2 = dvec3_sub(p[2], p[0]), h = dvec3_cross(direction, e2);
    double determinant = dvec3_dot(e1, h);
    if (determinant == 0) return false;
    dvec3 from = dvec3_sub(origin, p[0]), q = dvec3_cross(from, e1);
    *u = dvec3_dot(from, h) / determinant;
    *v = dvec3_dot(direction, q) / determinant;
    return isfinite(*u) && isfinite(*v);
}

void ray_corners(const struct ray_part *part, const struct ray_instance *in, uint32_t triangle, dvec3 out[3]) {
    const uint32_t *corners = part->primitive->indices + 3 * (size_t)triangle;
    for (int k = 0; k < 3; k++) out[k] = dvec3_add(carry(in->axes, dvec3_from(part->positions[corners[k]])), in->origin);
}

/* How texture coordinates change to the neighbours of a pixel. */
static void find_footprint(const struct ray_part *part, uint32_t triangle, const dvec3 corners[3],
                           const struct ray_neighbours *neighbours, struct ray_uv *uv) {
    double(*const steps[2])[2] = {uv->along, uv->across};
    for (int k = 0; k < 2; k++) {
        double u, v;
        if (!meet(corners, neighbours->origin[k], neighbours->direction[k], &u, &v)) continue;
        interpolate_uv(part, triangle, u, v, steps[k]);
        for (int i = 0; i < 4; i++) steps[k][i / 2][i % 2] -= uv->at[i / 2][i % 2];
    }
}

static void vertex_color(const struct ray_part *part, uint32_t triangle, double u, double v, double out[4]) {
    const struct scene_primitive *p = part->primitive;
    const uint32_t *c = p->indices + 3 * (size_t)triangle;
    for (int i = 0; i < 4; i++) out[i] = 1;
    if (!p->colors) return;
    const double weights[3] = {1 - u - v, u, v};
    for (int i = 0; i < 4; i++) out[i] = 0;
    for (int k = 0; k < 3; k++) {
        const float *color = &p->colors[c[k]].x;
        for (int i = 0; i < 4; i++) out[i] += weights[k] * clamp01((double)color[i]);
    }
}

double ray_coverage(const struct ray_part *part, const struct ray_instance *in, uint32_t triangle, double u, double v,
                    const struct ray_neighbours *neighbours) {
    const struct scene_material *m = part->material;
    if (m->alpha_mode == FNL_ALPHA_OPAQUE) return 1;
    struct ray_uv uv = {0};
    double texel[4], color[4];
    interpolate_uv(part, triangle, u, v, uv.at);
    if (neighbours) {
        dvec3 corners[3];
        ray_corners(part, in, triangle, corners);
        find_footprint(part, triangle, corners, neighbours, &uv);
    }
    ray_texture_sample(part->scene->scene, part->scene->images, m, SCENE_TEXTURE_BASE_COLOR, &uv, texel);
    vertex_color(part, triangle, u, v, color);
    double alpha = (double)m->base_color.w * color[3] * texel[3];
    return m->alpha_mode == FNL_ALPHA_BLEND ? clamp01(alpha) : alpha < (double)scene_material_cutoff(m) ? 0 : 1;
}

double ray_transmission(const struct ray_part *part, uint32_t triangle, double u, double v) {
    const struct scene_material *m = part->material;
    struct ray_uv uv = {0};
    double strength[4], metal[4];
    if (!scene_material_transmissive(m)) return 0;
    interpolate_uv(part, triangle, u, v, uv.at);
    ray_texture_sample(part->scene->scene, part->scene->images, m, SCENE_TEXTURE_TRANSMISSION, &uv, strength);
    ray_texture_sample(part->scene->scene, part->scene->images, m, SCENE_TEXTURE_METALLIC_ROUGHNESS, &uv, metal);
    return (double)m->transmission.strength * strength[0] * (1 - clamp01((double)m->metallic * metal[2]));
}

double ray_scene_coverage(const struct ray_scene *s, const struct ray_hit *hit) {
    return ray_coverage(&s->parts.data[hit->part], NULL, hit->triangle, hit->u, hit->v, NULL);
}

double ray_glow(const struct ray_part *part, uint32_t triangle) {
    const struct scene_material *m = part->material;
    const double corners[3][2] = {{0, 0}, {1, 0}, {0, 1}};
    struct ray_uv uv = {0};
    double at[3][2][2], color[4], texel[4];
    if (dvec3_max(dvec3_from(m->emissive)) <= 0 && !m->unlit) return 0;
    for (int k = 0; k < 3; k++) interpolate_uv(part, triangle, corners[k][0], corners[k][1], at[k]);
    for (int i = 0; i < 4; i++) { /* the texture's mean over about as much as the triangle has of it */
        const int set = i / 2, axis = i % 2;
        uv.at[set][axis] = (at[0][set][axis] + at[1][set][axis] + at[2][set][axis]) / 3;
        uv.along[set][axis] = at[1][set][axis] - at[0][set][axis];
        uv.across[set][axis] = at[2][set][axis] - at[0][set][axis];
    }
    ray_texture_sample(part->scene->scene, part->scene->images, m, m->unlit ? SCENE_TEXTURE_BASE_COLOR : SCENE_TEXTURE_EMISSIVE, &uv, texel);
    if (!m->unlit) return dvec3_luminance(dvec3_mul(dvec3_from(m->emissive), dvec3_make(texel[0], texel[1], texel[2])));
    vertex_color(part, triangle, 1.0 / 3, 1.0 / 3, color);
    return dvec3_luminance(dvec3_make((double)m->base_color.x * color[0] * texel[0], (double)m->base_color.y * color[1] * texel[1],
                                      (double)m->base_color.z * color[2] * texel[2]));
}

/* The means of the corners' unit vectors in the world, as vertices have them. */
static dvec3 interpolate_normal(const struct ray_part *part, const struct ray_instance *in, const uint32_t *corners,
                                const double weights[3]) {
    dvec3 sum = {0, 0, 0};
    for (int k = 0; k < 3; k++)
        sum =
            dvec3_add_scaled(sum, dvec3_normalize(carry(in->cofactors, dvec3_from(part->normals[corners[k]]))), weights[k]);
    return sum;
}

/* Of unit vectors; `hand` turns the normal and it into the bitangent. */
static dvec3 interpolate_tangent(const struct ray_part *part, const struct ray_instance *in, const uint32_t *corners,
                                 const double weights[3], double *hand) {
    dvec3 tangent = {0, 0, 0};
    for (int k = 0; k < 3; k++) {
        vec4 t = part->tangents[corners[k]];
        dvec3 own = dvec3_normalize(carry(in->axes, dvec3_make((double)t.x, (double)t.y, (double)t.z)));
        tangent = dvec3_add_scaled(tangent, own, weights[k]);
    }
    *hand = (double)part->tangents[corners[0]].w * in->mirror;
    return tangent;
}

static dvec3 bend_normal(dvec3 tangent, double hand, dvec3 normal, const struct scene_material *m, enum scene_texture_slot slot, double scale,
                         const double texel[4]) {
    float turn[4];
    scene_texture_turn_of(m, slot, turn);
    const double x = (texel[0] * 2 - 1) * scale, y = (texel[1] * 2 - 1) * scale;
    dvec3 mapped = {(double)turn[0] * x + (double)turn[1] * y, (double)turn[2] * x + (double)turn[3] * y, texel[2] * 2 - 1};
    return dvec3_combine(tangent, dvec3_scale(dvec3_cross(normal, tangent), hand), normal, mapped);
}

static dvec3 rgb(const double texel[4]) { return dvec3_make(texel[0], texel[1], texel[2]); }

static void shade_material(const struct ray_scene *s, const struct ray_part *part, const struct ray_uv *uv,
                           const double color[4], struct ray_surface *out) {
    const struct scene_material *m = part->material;
    double texel[4];
#define SAMPLE(slot) ray_texture_sample(s->scene, s->images, m, SCENE_TEXTURE_##slot, uv, texel)
    SAMPLE(BASE_COLOR);
    const dvec3 factor = {(double)m->base_color.x, (double)m->base_color.y, (double)m->base_color.z};
    out->base_color = dvec3_mul(dvec3_mul(factor, rgb(color)), rgb(texel));
    out->alpha = m->alpha_mode == FNL_ALPHA_BLEND ? clamp01((double)m->base_color.w * color[3] * texel[3]) : 1;
    SAMPLE(METALLIC_ROUGHNESS);
    out->metallic = clamp01((double)m->metallic * texel[2]);
    out->roughness = clamp01((double)m->roughness * texel[1]);
    SAMPLE(OCCLUSION);
    out->occlusion = 1 + (double)m->occlusion_strength * (texel[0] - 1);
    SAMPLE(EMISSIVE);
    out->emissive = dvec3_mul(dvec3_from(m->emissive), rgb(texel));
    SAMPLE(SPECULAR);
    out->f90 = (double)m->specular * texel[3];
    SAMPLE(SPECULAR_COLOR);
#undef SAMPLE
    dvec3 f0 = dvec3_scale(dvec3_mul(dvec3_from(m->specular_color), rgb(texel)), ray_ior_reflectance((double)m->ior));
    out->f0 = dvec3_scale(dvec3_make(fmin(f0.x, 1), fmin(f0.y, 1), fmin(f0.z, 1)), out->f90);
    if (!m->unlit) return;
    out->emissive = out->base_color;
    out->base_color = out->f0 = (dvec3){0, 0, 0};
    out->metallic = out->f90 = 0;
}

/* `normal` and `tangent` as vertices have them; the surface's own normal is known. */
static void find_layers(const struct ray_scene *s, const struct scene_material *m, const struct ray_uv *uv, dvec3 normal, dvec3 tangent, double hand,
                        double sign, struct ray_surface *out) {
    struct ray_layers *l = &out->layers;
    double texel[4];
    ray_layers_numbers(m, l);
#define SAMPLE(slot) ray_texture_sample(s->scene, s->images, m, SCENE_TEXTURE_##slot, uv, texel)
#define TIMES_r(number) number *= texel[0]
#define TIMES_g(number) number *= texel[1]
#define TIMES_a(number) number *= texel[3]
#define TIMES_rgb(number) number = dvec3_mul(number, rgb(texel))
#define TEXTURED(member, texture, channels)                                                                                          \
    ray_texture_sample(s->scene, s->images, m, (enum scene_texture_slot)(SCENE_TEXTURE_CORE_COUNT + (texture)), uv, texel); \
    TIMES_##channels(l->member);
    LAYERS_TEXTURED(TEXTURED)
    LAYERS_TEXTURED_THROUGH(TEXTURED)
#undef TEXTURED
    l->clearcoat_normal = dvec3_scale(dvec3_normalize(normal), sign);
    if (ray_texture_exists(s->images, m, SCENE_TEXTURE_CLEARCOAT_NORMAL)) {
        SAMPLE(CLEARCOAT_NORMAL);
        dvec3 bent = bend_normal(tangent, hand, normal, m, SCENE_TEXTURE_CLEARCOAT_NORMAL, l->clearcoat_normal_scale, texel);
        if (dvec3_length(bent) > 1e-10) l->clearcoat_normal = dvec3_scale(dvec3_normalize(bent), sign);
    }
    SAMPLE(IRIDESCENCE_THICKNESS);
    l->film_thickness = l->film_thinnest + (double)(m->iridescence.thickness_maximum - m->iridescence.thickness_minimum) * texel[1];
    const double attenuated[3] = {fmax(l->attenuation_color.x, 1e-6), fmax(l->attenuation_color.y, 1e-6), fmax(l->attenuation_color.z, 1e-6)};
    l->absorption = dvec3_make(-log(attenuated[0]) / l->attenuation_distance, -log(attenuated[1]) / l->attenuation_distance,
                               -log(attenuated[2]) / l->attenuation_distance);
    l->ior = m->ior > 0 ? (double)m->ior : 1.5;
    double along[2] = {1, 0}, c = cos(l->anisotropy_rotation), turn = sin(l->anisotropy_rotation);
    if (ray_texture_exists(s->images, m, SCENE_TEXTURE_ANISOTROPY)) {
        SAMPLE(ANISOTROPY);
        for (int i = 0; i < 2; i++) along[i] = texel[i] * 2 - 1;
        l->anisotropy *= texel[2];
    }
#undef SAMPLE
    float axes[4];
    scene_texture_turn_of(m, SCENE_TEXTURE_ANISOTROPY, axes);
    const double x = c * along[0] - turn * along[1], y = c * along[1] + turn * along[0];
    dvec3 turned = dvec3_combine(tangent, dvec3_scale(dvec3_cross(normal, tangent), hand), normal,
                                 dvec3_make((double)axes[0] * x + (double)axes[1] * y, (double)axes[2] * x + (double)axes[3] * y, 0));
    turned = dvec3_add_scaled(turned, out->normal, -dvec3_dot(out->normal, turned));
    if (dvec3_length(turned) > 1e-10)
        l->tangent = dvec3_normalize(turned);
    else
        l->anisotropy = 0;
    out->layered = true;
}

struct ray_surface ray_surface_at(const struct ray_scene *s, const struct ray_hit *hit, dvec3 origin, dvec3 direction,
                                  const struct ray_neighbours *neighbours) {
    const struct ray_part *part = &s->parts.data[hit->part];
    const struct ray_instance *in = &s->instances.data[hit->instance];
    const uint32_t *corners = part->primitive->indices + 3 * (size_t)hit->triangle;
    const struct scene_material *m = part->material;
    struct ray_surface out = {.light_mask = in->light_mask};
    struct ray_uv uv = {0};
    dvec3 p[3];
    double u = hit->u, v = hit->v, color[4], texel[4];
    ray_corners(part, in, hit->triangle, p);
    if (!meet(p, origin, direction, &u, &v)) u = hit->u, v = hit->v;
    const double weights[3] = {1 - u - v, u, v};
    for (int k = 0; k < 3; k++) out.position = dvec3_add_scaled(out.position, p[k], weights[k]);
    interpolate_uv(part, hit->triangle, u, v, uv.at);
    if (neighbours) find_footprint(part, hit->triangle, p, neighbours, &uv);
    vertex_color(part, hit->triangle, u, v, color);
    shade_material(s, part, &uv, color, &out);

    out.offset = ray_rounding(fmax(dvec3_reach(out.position), dvec3_reach(in->origin)));
    double sign = hit->front ? 1 : -1;
    dvec3 face = dvec3_normalize(dvec3_scale(dvec3_cross(dvec3_sub(p[1], p[0]), dvec3_sub(p[2], p[0])), in->mirror));
    dvec3 normal = part->normals ? interpolate_normal(part, in, corners, weights) : face, tangent = {0, 0, 0};
    const dvec3 smooth = normal;
    double hand = 1;
    if (part->normals && part->tangents) tangent = interpolate_tangent(part, in, corners, weights, &hand);
    if (part->normals && part->tangents && ray_texture_exists(s->images, m, SCENE_TEXTURE_NORMAL)) {
        ray_texture_sample(s->scene, s->images, m, SCENE_TEXTURE_NORMAL, &uv, texel);
        dvec3 bent = bend_normal(tangent, hand, normal, m, SCENE_TEXTURE_NORMAL, (double)m->normal_scale, texel);
        if (dvec3_length(bent) > 1e-10) normal = bent;
    }
    out.geometric = dvec3_scale(face, sign);
    out.normal = dvec3_length(normal) > 0 ? dvec3_scale(dvec3_normalize(normal), sign) : out.geometric;
    if (scene_material_layered(m)) {
        find_layers(s, m, &uv, dvec3_length(smooth) > 0 ? smooth : face, tangent, hand, sign, &out);
        out.layers.thickness *= cbrt(fabs(dvec3_dot(in->axes[0], dvec3_cross(in->axes[1], in->axes[2])))); /* measured in the mesh */
        ray_layers_prepare(&s->albedos, &out, dvec3_scale(direction, -1));
        out.emissive = dvec3_scale(out.emissive, out.layers.below_coat);
    }
    if (s->conserving) ray_energy_prepare(&s->albedos, &out, dvec3_scale(direction, -1));
    return out;
}
