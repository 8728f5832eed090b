/* SPDX-License-Identifier: MIT */
#include "passes/shadow/fill_reference.h"

/* ---- pages, as maps_shared.h defines them ---- */

static const uint32_t level_side[SHADOW_LEVELS] = {16, 8, 4, 2, 1, 1, 1, 1},
                      level_size[SHADOW_LEVELS] = {128, 128, 128, 128, 128, 64, 32, 16},
                      level_bit[SHADOW_LEVELS] = {0, 256, 320, 336, 340, 341, 342, 343};

uint32_t page_side(uint32_t level) { return level_side[level]; }
uint32_t page_size(const struct page *p) { return level_size[p->level]; }
uint32_t page_bit(const struct page *p) {
    return p->face * SHADOW_FACE_WORDS * 32 + level_bit[p->level] + p->y * level_side[p->level] + p->x;
}

void pages_put(struct pages *pages, struct page page) {
    const uint32_t size = page_size(&page), across = 128 / size;
    if (pages->small != size || pages->used == across * across) {
        if (pages->used) pages->cell++;
        pages->used = 0;
        pages->small = size;
    }
    assert_true(pages->count < MOST_PAGES && pages->cell < CELLS * CELLS);
    page.place_x = pages->cell % CELLS * 128 + pages->used % across * size;
    page.place_y = pages->cell / CELLS * 128 + pages->used / across * size;
    pages->used++;
    pages->data[pages->count++] = page;
}

/* ---- the scene as the CPU sees it ---- */

static struct point point_of(vec3 v) { return (struct point){{v.x, v.y, v.z}}; }
static double dot(struct point a, struct point b) { return a.x[0] * b.x[0] + a.x[1] * b.x[1] + a.x[2] * b.x[2]; }
static struct point add_scaled(struct point a, struct point b, double s) {
    return (struct point){{a.x[0] + b.x[0] * s, a.x[1] + b.x[1] * s, a.x[2] + b.x[2] * s}};
}
static struct point cross(struct point a, struct point b) {
    return (struct point){
        {a.x[1] * b.x[2] - a.x[2] * b.x[1], a.x[2] * b.x[0] - a.x[0] * b.x[2], a.x[0] * b.x[1] - a.x[1] * b.x[0]}};
}

void triangles_gather(struct triangles *out, const struct device_scene *d) {
    enum { MOST = 20000 };
    const fnl_scene *scene = d->scene;
    free(out->data);
    *out = (struct triangles){malloc(MOST * sizeof *out->data), 0};
    for (uint32_t i = 0; i < d->item_count; i++) {
        const uint32_t n = d->item_nodes.data[i], own = d->nodes.data[n].first_primitive;
        const struct scene_node *node = &scene->nodes.data[n];
        const struct scene_mesh *mesh = &scene->meshes.data[node->mesh];
        const uint32_t index = own == SCENE_NONE ? d->item_list.data[i].primitive
                                                 : mesh->first_primitive + d->item_list.data[i].primitive - own;
        const struct scene_primitive *p = &scene->primitives.data[index];
        const struct scene_material *material = p->material == SCENE_NONE ? NULL : &scene->materials.data[p->material];
        if (p->topology != SCENE_TOPOLOGY_TRIANGLES || (material && (material->alpha_mode == FNL_ALPHA_BLEND || scene_material_transmissive(material)))) continue;
        for (uint32_t t = 0; t + 2 < p->index_count; t += 3) {
            assert_true(out->count < MOST);
            struct triangle *triangle = &out->data[out->count++];
            *triangle = (struct triangle){
                .item = i, .cutoff = material && material->alpha_mode == FNL_ALPHA_MASK ? material->alpha_cutoff : 0};
            for (int k = 0; k < 3; k++) {
                const uint32_t v = p->indices[t + k];
                vec3 at = p->positions[v];
                for (uint32_t m = 0; m < p->morph_target_count; m++)
                    at = vec3_add(at, vec3_scale(p->morph_targets[m].positions[v], mesh->morph_weights[m]));
                triangle->p[k] = point_of(mat4_point(&node->world, at));
                triangle->alpha[k] = (p->colors ? p->colors[v].w : 1) * (material ? material->base_color.w : 1);
            }
        }
    }
}

/* ---- rays ---- */

struct face face_of(const struct gpu_shape *s, uint32_t face) {
    struct face f = {.origin = point_of(s->position), .range = s->range, .is_box = s->kind == GPU_SHAPE_BOX};
    if (f.is_box) {
        f.u = point_of(s->side);
        f.along = point_of(s->direction);
        f.v = cross(f.u, f.along);
        f.size[0] = s->size.x, f.size[1] = s->size.y, f.size[2] = s->size.z;
    } else {
        const uint32_t axis = face / 2;
        f.u.x[(axis + 1) % 3] = f.v.x[(axis + 2) % 3] = 1;
        f.along.x[axis] = face % 2 ? -1 : 1;
    }
    return f;
}

void texel_on_face(const struct page *p, double x, double y, double out[2]) {
    const double inner = page_size(p) - 2.0 * SHADOW_BORDER, width = inner * level_side[p->level];
    out[0] = 2 * (p->x * inner + x - SHADOW_BORDER) / width - 1;
    out[1] = 2 * (p->y * inner + y - SHADOW_BORDER) / width - 1;
}

struct hit hit_nearest(const struct triangles *triangles, const struct face *f, const double at[2]) {
    struct point from = f->origin, way = f->along;
    if (f->is_box) {
        from = add_scaled(add_scaled(from, f->u, at[0] * f->size[0]), f->v, at[1] * f->size[1]);
        from = add_scaled(from, f->along, -f->size[2]);
    } else {
        way = add_scaled(add_scaled(way, f->u, at[0]), f->v, at[1]);
    }
    const double low = f->is_box ? 0 : SHADOW_NEAR, high = f->is_box ? 2 * f->size[2] : INFINITY;
    struct hit best = {.item = UINT32_MAX};
    for (uint32_t i = 0; i < triangles->count; i++) {
        const struct triangle *t = &triangles->data[i];
        struct point a = add_scaled(t->p[0], from, -1), b = add_scaled(t->p[1], from, -1), c = add_scaled(t->p[2], from, -1);
        double w[3] = {dot(cross(b, c), way), dot(cross(c, a), way), dot(cross(a, b), way)}, sum = w[0] + w[1] + w[2];
        if (!((w[0] >= 0 && w[1] >= 0 && w[2] >= 0) || (w[0] <= 0 && w[1] <= 0 && w[2] <= 0)) || sum == 0) continue;
        double distance = 0, alpha = 0;
        for (int k = 0; k < 3; k++) {
            distance += w[k] / sum * dot(k == 0 ? a : k == 1 ? b : c, f->along);
            alpha += w[k] / sum * t->alpha[k];
        }
        if (distance < low || distance > high || alpha < t->cutoff) continue;
        const double depth = f->is_box ? 1 - 0.5 * distance / f->size[2] : SHADOW_NEAR / distance;
        if (depth <= best.depth) continue;
        best = (struct hit){depth, t->item, !f->is_box && distance * sqrt(dot(way, way)) > f->range * 0.9999};
    }
    return best;
}

struct triangles triangles_of_page(const struct triangles *all, const struct page *p, const struct face *f, uint32_t *out_items) {
    double low[2], high[2];
    texel_on_face(p, 0, 0, low);
    texel_on_face(p, page_size(p), page_size(p), high);
    uint32_t last = UINT32_MAX;
    struct triangles out = {malloc(MAX(all->count, 1u) * sizeof *out.data), 0};
    *out_items = 0;
    for (uint32_t i = 0; i < all->count; i++) {
        bool beyond[6] = {true, true, true, true, true, true};
        for (int k = 0; k < 3; k++) {
            const struct point q = add_scaled(all->data[i].p[k], f->origin, -1);
            const double along = dot(q, f->along), x = dot(q, f->u), y = dot(q, f->v), sx = f->is_box ? f->size[0] : along,
                         sy = f->is_box ? f->size[1] : along;
            beyond[0] &= x<low[0] * sx, beyond[1] &= x> high[0] * sx;
            beyond[2] &= y<low[1] * sy, beyond[3] &= y> high[1] * sy;
            beyond[4] &= f->is_box ? along < -f->size[2] : along < 0;
            beyond[5] &= along > (f->is_box ? f->size[2] : f->range);
        }
        if (beyond[0] || beyond[1] || beyond[2] || beyond[3] || beyond[4]) continue;
        out.data[out.count++] = all->data[i];
        if (beyond[5] || all->data[i].item == last) continue;
        last = all->data[i].item;
        ++*out_items;
    }
    return out;
}
