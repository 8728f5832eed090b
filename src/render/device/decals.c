/* SPDX-License-Identifier: MIT */
#include "image/image.h"
#include "decals_shared.h"
#include "passes/decals/decals_redraw_shared.h"
#include "render/device/scene.h"

/* ---- pictures ---- */

/* Colours times alpha, in linear light: what filtering mixes in from clear texels is then nothing (ES-35b). */
static void premultiply(uint8_t *pixels, uint64_t count) {
    float linear[256];
    for (int i = 0; i < 256; i++) linear[i] = decode_srgb((float)i / 255);
    for (uint64_t i = 0; i < count; i++) {
        uint8_t *p = pixels + i * 4;
        if (p[3] == 255) continue;
        for (int c = 0; c < 3; c++) p[c] = (uint8_t)(encode_srgb(linear[p[c]] * (float)p[3] / 255) * 255 + 0.5f);
    }
}

static uint32_t mip_count(uint32_t width, uint32_t height) {
    uint32_t count = 1;
    for (uint32_t side = MAX(width, height); side > 1; side /= 2) count++;
    return count;
}

static fnl_result upload_pixels(struct device_scene *d, struct decal_picture *picture, uint32_t width, uint32_t height,
                                const void *pixels) {
    bool color = picture->kind != DECAL_PICTURE_DATA;
    struct gpu_image_params params = {.name = "decal picture",
                                      .format = VK_FORMAT_R8G8B8A8_UNORM,
                                      .width = width,
                                      .height = height,
                                      .layers = 1,
                                      .mips = mip_count(width, height),
                                      .samples = 1,
                                      .srgb_view = color,
                                      .use = GPU_USE_TEXTURES,
                                      .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_SRC_BIT |
                                               VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    TRY(gpu_image_create(d->device, &params, &picture->gpu));
    return gpu_upload_image(d->device, &picture->gpu, pixels, (uint64_t)width * height * 4, true, color);
}

static fnl_result upload_picture(struct device_scene *d, struct decal_picture *picture, uint32_t width, uint32_t height,
                                 const void *pixels) {
    if (picture->kind != DECAL_PICTURE_PREMULTIPLIED) return upload_pixels(d, picture, width, height, pixels);
    size_t bytes = (size_t)width * height * 4;
    uint8_t *copy = host_allocate(&d->host, bytes);
    if (!copy) return FNL_ERROR_MEMORY;
    memcpy(copy, pixels, bytes);
    premultiply(copy, (uint64_t)width * height);
    fnl_result result = upload_pixels(d, picture, width, height, copy);
    host_free(&d->host, copy, bytes);
    return result;
}

/* A decal whose picture is broken shows without it. */
fnl_result device_decals_deliver(struct device_scene *d, uint32_t image, const struct texture *texture) {
    for (uint32_t i = 0; i < d->decals.pictures.count; i++) {
        struct decal_picture *picture = &d->decals.pictures.data[i];
        if (picture->image != image || !picture->coming) continue;
        picture->coming = false;
        d->sent.decals = UINT64_MAX; /* it has an index from now on */
        if (!texture) continue;
        struct texture plain = *texture;
        if (texture->format != TEXTURE_RGBA8) TRY(texture_unpack(&d->host, texture, &plain));
        fnl_result result = upload_picture(d, picture, plain.width, plain.height, plain.bytes);
        if (texture->format != TEXTURE_RGBA8) texture_free(&d->host, &plain);
        TRY(result);
    }
    if (!texture) d->images.data[image].broken = true;
    return FNL_OK;
}

static const struct decal_picture *find_picture(const struct device_scene *d, uint32_t image, enum decal_picture_kind kind) {
    for (uint32_t i = 0; i < d->decals.pictures.count; i++)
        if (d->decals.pictures.data[i].image == image && d->decals.pictures.data[i].kind == kind)
            return &d->decals.pictures.data[i];
    return NULL;
}

static fnl_result need_picture(struct device_scene *d, fnl_image_id id, enum decal_picture_kind kind) {
    uint32_t image = decal_image(id);
    if (image == SCENE_NONE || find_picture(d, image, kind)) return FNL_OK;
    const struct scene_image *source = &d->scene->images.data[image];
    struct decal_picture picture = {.image = image, .kind = kind, .version = source->version};
    fnl_result result = FNL_OK;
    if (source->width && source->height && source->pixels)
        result = upload_picture(d, &picture, source->width, source->height, source->pixels);
    else
        picture.coming = source->width && source->height && source->encoded && !d->images.data[image].broken;
    if (result == FNL_OK && !array_push(&d->host, &d->decals.pictures, picture)) result = FNL_ERROR_MEMORY;
    if (result != FNL_OK && picture.gpu.handle) gpu_image_destroy(d->device, &picture.gpu);
    return result;
}

static enum decal_picture_kind color_kind(const fnl_decal_params *p) {
    return p->distance_field ? DECAL_PICTURE_COLOR : DECAL_PICTURE_PREMULTIPLIED;
}

static uint32_t picture_index(const struct device_scene *d, fnl_image_id id, enum decal_picture_kind kind) {
    const struct decal_picture *picture = find_picture(d, decal_image(id), kind);
    if (!picture || !picture->gpu.handle) return GPU_DECAL_NO_IMAGE;
    return kind == DECAL_PICTURE_DATA || picture->gpu.srgb_index == GPU_NO_INDEX ? picture->gpu.sampled_index
                                                                                 : picture->gpu.srgb_index;
}

/* ---- which, and in which order ---- */

/* Boxes and volumes, then meshes, then redraws; SCENE_NONE: not drawn as a decal. */
static uint32_t kind_rank(fnl_decal_kind kind) {
    return kind == FNL_DECAL_MESH ? 1 : kind == FNL_DECAL_REDRAW ? 2 : kind == FNL_DECAL_BAKED ? SCENE_NONE : 0;
}

/* Whether decal x is applied before decal y. */
static bool comes_before(const struct scene_decal *decals, uint32_t x, uint32_t y) {
    uint32_t kx = kind_rank(decals[x].params.kind), ky = kind_rank(decals[y].params.kind);
    if (kx != ky) return kx < ky;
    if (decals[x].params.sort_key != decals[y].params.sort_key) return decals[x].params.sort_key < decals[y].params.sort_key;
    return x < y;
}

/* A merge sort: keeps the order of equal elements and needs no memory beside its arrays. */
static void sort_order(uint32_t *values, uint32_t *spare, uint32_t count, const struct scene_decal *decals) {
    for (uint32_t width = 1; width < count; width *= 2) {
        for (uint32_t first = 0; first < count; first += 2 * width) {
            uint32_t middle = MIN(first + width, count), end = MIN(first + 2 * width, count), a = first, b = middle;
            for (uint32_t i = first; i < end; i++)
                spare[i] =
                    b >= end || (a < middle && comes_before(decals, values[a], values[b])) ? values[a++] : values[b++];
        }
        memcpy(values, spare, count * sizeof *values);
        if (width > count / 2) break;
    }
}

static fnl_result find_order(struct device_scene *d) {
    const fnl_scene *scene = d->scene;
    struct device_decals *all = &d->decals;
    uint32_t count = 0, counts[3] = {0};
    if (!array_reserve(&d->host, &all->order, scene->decals.count * 2ull)) return FNL_ERROR_MEMORY;
    bool sorted = true;
    all->moves = all->emits = all->masks = false;
    for (uint32_t i = 0; i < d->scene->nodes.count; i++) all->masks |= d->scene->nodes.data[i].refuses != 0;
    for (uint32_t i = 0; i < scene->decals.count; i++) {
        const struct scene_decal *decal = &scene->decals.data[i];
        uint32_t rank = kind_rank(decal->params.kind);
        if (rank == SCENE_NONE || !decal_shows(scene, decal)) continue;
        all->order.data[count++] = i;
        counts[rank]++;
        all->moves |= rank == 0 && decal->node != SCENE_NONE;
        all->masks |= rank == 0 && decal->params.receivers != 255;
        all->emits |= rank == 0 && decal->params.channels & FNL_DECAL_EMISSION;
        sorted = sorted && (count < 2 || comes_before(scene->decals.data, all->order.data[count - 2], i));
    }
    if (!sorted) sort_order(all->order.data, all->order.data + count, count, scene->decals.data);
    all->order.count = count;
    all->count = counts[0];
    all->mesh_count = counts[1];
    all->redraw_count = counts[2];
    return FNL_OK;
}

/* ---- one decal ---- */

static vec3 column(const mat4 *m, int i) { return vec3_make(m->m[i * 4], m->m[i * 4 + 1], m->m[i * 4 + 2]); }

static bool picture_coming(const struct device_scene *d, fnl_image_id id, enum decal_picture_kind kind) {
    const struct decal_picture *picture = find_picture(d, decal_image(id), kind);
    return picture && picture->coming;
}

/* Until its pictures are there a decal does not show: as a plain box it would cover more than it ever will. */
static bool waits(const struct device_scene *d, const fnl_decal_params *p) {
    return d->images_coming && (picture_coming(d, p->color_image, color_kind(p)) ||
                                picture_coming(d, p->normal_image, DECAL_PICTURE_DATA) ||
                                picture_coming(d, p->metallic_roughness_image, DECAL_PICTURE_DATA) ||
                                picture_coming(d, p->emissive_image, DECAL_PICTURE_COLOR));
}

static struct gpu_decal device_decal(const struct device_scene *d, const struct scene_decal *decal, const mat4 *transform) {
    const fnl_decal_params *p = &decal->params;
    mat4 m;
    if (!mat4_inverse(transform, &m))
        m = mat4_scaling(vec3_make(INFINITY, INFINITY, INFINITY)); /* flattened by its node: holds nothing */
    bool volume = p->kind == FNL_DECAL_VOLUME;
    float high = cosf(p->fade_start), low = cosf(p->fade_end);
    struct gpu_decal g = {.flags = p->channels | (p->flatten ? GPU_DECAL_FLATTEN : 0) |
                                   (p->distance_field ? GPU_DECAL_FIELD : 0) | (volume ? GPU_DECAL_VOLUME : 0) |
                                   (uint32_t)p->blend << GPU_DECAL_BLEND_SHIFT | p->receivers << GPU_DECAL_RECEIVERS_SHIFT,
                          .side = vec3_normalize(column(transform, 0)),
                          .up = vec3_normalize(column(transform, 1)),
                          .color = {p->color[0], p->color[1], p->color[2], p->color[3]},
                          .emissive = {p->emissive[0], p->emissive[1], p->emissive[2]},
                          .metallic = p->metallic,
                          .roughness = p->roughness,
                          .normal_scale = p->normal_scale,
                          .fade_scale = 1 / fmaxf(high - low, 1e-4f),
                          .cut = p->cut,
                          .slices = volume ? (float)p->slices : 1,
                          .color_image = picture_index(d, p->color_image, color_kind(p)),
                          .normal_image = picture_index(d, p->normal_image, DECAL_PICTURE_DATA),
                          .metallic_roughness_image = picture_index(d, p->metallic_roughness_image, DECAL_PICTURE_DATA),
                          .emissive_image = picture_index(d, p->emissive_image, DECAL_PICTURE_COLOR)};
    if (waits(d, p)) g.color.w = 0;
    g.fade_offset = -low * g.fade_scale;
    for (int row = 0; row < 3; row++) g.rows[row] = (vec4){m.m[row], m.m[4 + row], m.m[8 + row], m.m[12 + row]};
    /* A picture plane stays one under any affine map: its normal is that of the cube's x and y, on the side of z. */
    vec3 facing = vec3_normalize(vec3_cross(column(transform, 0), column(transform, 1)));
    g.facing = vec3_dot(facing, column(transform, 2)) < 0 ? vec3_scale(facing, -1) : facing;
    return g;
}

/* Flat boxes hardly have a volume; lists see them a little larger, so that rounding loses nothing. */
#define BOX_SLACK (1 + 1e-4f)

struct gpu_entity_bounds device_decal_bounds(const mat4 *transform, uint32_t index) {
    float radius = 0;
    for (int i = 0; i < 4; i++) {
        vec3 corner = vec3_add_scaled(column(transform, 0), column(transform, 1), i & 1 ? 1 : -1);
        corner = vec3_add_scaled(corner, column(transform, 2), i & 2 ? 1 : -1);
        radius = fmaxf(radius, 0.5f * vec3_length(corner));
    }
    return (struct gpu_entity_bounds){.center = column(transform, 3),
                                      .radius = radius * BOX_SLACK + 1e-6f,
                                      .shape = GPU_NO_SHAPE,
                                      .kind = GPU_ENTITY_DECAL,
                                      .user = index};
}

/* ---- mesh decals ---- */

static fnl_result prepare_mesh(struct device_scene *d) {
    struct device_decals *all = &d->decals;
    gpu_buffer_destroy(d->device, &all->mesh_ranges);
    gpu_buffer_destroy(d->device, &all->mesh_ids);
    if (all->mesh_count == 0) return FNL_OK;
    const fnl_scene *scene = d->scene;
    uint32_t instance_count = d->instances_taken.end, id_count = 0;
    uint32_t *ranges = host_allocate_zero(&d->host, (instance_count + 1) * sizeof *ranges);
    ARRAY(uint32_t) ids = {0};
    fnl_result result = ranges ? FNL_OK : FNL_ERROR_MEMORY;
    for (int fills = 0; fills < 2 && result == FNL_OK; fills++) {
        for (uint32_t i = all->count; i < all->count + all->mesh_count; i++) {
            uint32_t node = scene->decals.data[all->order.data[i]].node, first = d->nodes.data[node].first_instance;
            if (first == SCENE_NONE) continue;
            for (uint32_t k = 0; k < scene->nodes.data[node].instance_count; k++) {
                if (fills)
                    ids.data[ranges[first + k]++] = i;
                else
                    ranges[first + k]++;
            }
        }
        uint32_t sum = 0;
        for (uint32_t i = 0; i <= instance_count; i++) { /* counts to beginnings; after filling, ends to beginnings */
            uint32_t value = ranges[i];
            ranges[i] = sum;
            sum = fills ? value : sum + value;
        }
        if (!fills) {
            id_count = sum;
            if (!array_reserve(&d->host, &ids, MAX(sum, 1u))) result = FNL_ERROR_MEMORY;
        }
    }
    if (result == FNL_OK)
        result =
            device_upload_array(d, GPU_USE_LIGHTS, "mesh decal ranges", &all->mesh_ranges, ranges, (instance_count + 1) * sizeof *ranges);
    if (result == FNL_OK)
        result = device_upload_array(d, GPU_USE_LIGHTS, "mesh decal ids", &all->mesh_ids, ids.data, id_count * sizeof *ids.data);
    array_free(&d->host, &ids);
    host_free(&d->host, ranges, (instance_count + 1) * sizeof *ranges);
    return result;
}

/* ---- redrawn decals ---- */

struct redraws {
    ARRAY(uint32_t) indices;
    ARRAY(struct gpu_draw) draws;
    ARRAY(struct gpu_redraw) table;
};

/* The triangles of a mesh's primitive that a decal touches before it deforms, and a draw of them for each instance. */
static fnl_result add_redraw(struct device_scene *d, struct redraws *r, uint32_t decal_index, const mat4 *inverse,
                             uint32_t node, uint32_t primitive) {
    const struct scene_mesh *mesh = &d->scene->meshes.data[d->scene->nodes.data[node].mesh];
    const struct scene_primitive *p = &d->scene->primitives.data[mesh->first_primitive + primitive];
    if (p->topology != SCENE_TOPOLOGY_TRIANGLES) return FNL_OK;
    uint32_t first = r->indices.count, own = d->nodes.data[node].first_primitive;
    for (uint32_t i = 0; i + 2 < p->index_count; i += 3) {
        vec3 corners[3];
        for (uint32_t k = 0; k < 3; k++) corners[k] = mat4_point(inverse, p->positions[p->indices[i + k]]);
        if (!decal_touches(corners)) continue;
        for (uint32_t k = 0; k < 3; k++)
            if (!array_push(&d->host, &r->indices, p->indices[i + k])) return FNL_ERROR_MEMORY;
    }
    uint32_t count = r->indices.count - first;
    for (uint32_t k = 0; count && k < d->scene->nodes.data[node].instance_count; k++) {
        struct gpu_redraw entry = {.instance = d->nodes.data[node].first_instance + k,
                                   .primitive = own == SCENE_NONE ? mesh->first_primitive + primitive : own + primitive,
                                   .decal = decal_index,
                                   .light_mask = 255u & ~d->scene->nodes.data[node].unlit};
        struct gpu_draw draw = {
            .index_count = count, .instance_count = 1, .first_index = first, .first_instance = r->table.count};
        if (!array_push(&d->host, &r->table, entry) || !array_push(&d->host, &r->draws, draw)) return FNL_ERROR_MEMORY;
    }
    return FNL_OK;
}

static fnl_result find_redraws(struct device_scene *d, struct redraws *r) {
    const struct device_decals *all = &d->decals;
    for (uint32_t i = all->count + all->mesh_count; i < all->order.count; i++) {
        const struct scene_decal *decal = &d->scene->decals.data[all->order.data[i]];
        mat4 inverse;
        if (d->nodes.data[decal->node].first_instance == SCENE_NONE || !mat4_inverse(&decal->params.transform, &inverse)) continue;
        uint32_t count = d->scene->meshes.data[d->scene->nodes.data[decal->node].mesh].primitive_count;
        for (uint32_t k = 0; k < count; k++) TRY(add_redraw(d, r, i, &inverse, decal->node, k));
    }
    return FNL_OK;
}

static fnl_result prepare_redraws(struct device_scene *d) {
    struct device_decals *all = &d->decals;
    gpu_buffer_destroy(d->device, &all->redraw_indices);
    gpu_buffer_destroy(d->device, &all->redraw_draws);
    gpu_buffer_destroy(d->device, &all->redraw_table);
    all->draw_count = 0;
    if (all->redraw_count == 0) return FNL_OK;
    struct redraws r = {{0}, {0}, {0}};
    fnl_result result = find_redraws(d, &r);
    if (result == FNL_OK)
        result = device_upload_array(d, GPU_USE_LIGHTS, "redraw indices", &all->redraw_indices, r.indices.data, r.indices.count * 4ull);
    if (result == FNL_OK)
        result =
            device_upload_array(d, GPU_USE_LIGHTS, "redraw draws", &all->redraw_draws, r.draws.data, r.draws.count * sizeof *r.draws.data);
    if (result == FNL_OK)
        result =
            device_upload_array(d, GPU_USE_LIGHTS, "redraw table", &all->redraw_table, r.table.data, r.table.count * sizeof *r.table.data);
    if (result == FNL_OK) all->draw_count = r.draws.count;
    array_free(&d->host, &r.indices);
    array_free(&d->host, &r.draws);
    array_free(&d->host, &r.table);
    return result;
}

/* ---- life ---- */

static void free_pictures(struct device_scene *d) {
    for (uint32_t i = 0; i < d->decals.pictures.count; i++)
        if (d->decals.pictures.data[i].gpu.handle) gpu_image_destroy(d->device, &d->decals.pictures.data[i].gpu);
    d->decals.pictures.count = 0;
}

static void free_changed_pictures(struct device_scene *d) {
    uint32_t kept = 0;
    for (uint32_t i = 0; i < d->decals.pictures.count; i++) {
        struct decal_picture *picture = &d->decals.pictures.data[i];
        if (picture->version == d->scene->images.data[picture->image].version) {
            d->decals.pictures.data[kept++] = *picture;
            continue;
        }
        if (picture->gpu.handle) gpu_image_destroy(d->device, &picture->gpu);
        d->sent.decals = UINT64_MAX; /* it has another index from now on */
    }
    d->decals.pictures.count = kept;
}

void device_decals_finish(struct device_scene *d) {
    struct device_decals *all = &d->decals;
    free_pictures(d);
    gpu_buffer_destroy(d->device, &all->decals);
    gpu_buffer_destroy(d->device, &all->bounds);
    gpu_buffer_destroy(d->device, &all->mesh_ranges);
    gpu_buffer_destroy(d->device, &all->mesh_ids);
    gpu_buffer_destroy(d->device, &all->redraw_indices);
    gpu_buffer_destroy(d->device, &all->redraw_draws);
    gpu_buffer_destroy(d->device, &all->redraw_table);
    array_free(&d->host, &all->data);
    array_free(&d->host, &all->bound_data);
    array_free(&d->host, &all->order);
    array_free(&d->host, &all->pictures);
}

static fnl_result grow_buffer(struct device_scene *d, const char *name, struct gpu_buffer *buffer, uint64_t size) {
    if (buffer->size >= size) return FNL_OK;
    uint64_t wanted = MAX(size, buffer->size + buffer->size / 2);
    gpu_buffer_destroy(d->device, buffer);
    d->sent.decals = UINT64_MAX;
    return gpu_buffer_create_for(d->device, GPU_USE_LIGHTS, name, wanted, GPU_MEMORY_DEVICE, buffer);
}

/* Those that are coming: now, or in the background. */
static fnl_result decode_pictures(struct device_scene *d) {
    const struct decal_picture *pictures = d->decals.pictures.data;
    ARRAY(uint32_t) images = {0};
    fnl_result result = FNL_OK;
    for (uint32_t i = 0; i < d->decals.pictures.count && result == FNL_OK; i++) {
        if (!pictures[i].coming) continue;
        uint32_t before = 0; /* another kind of the same picture */
        while (before < i && !(pictures[before].coming && pictures[before].image == pictures[i].image)) before++;
        if (before < i) continue;
        if (d->scene->images.data[pictures[i].image].async)
            result = device_image_ask(d, pictures[i].image);
        else if (!array_push(&d->host, &images, pictures[i].image))
            result = FNL_ERROR_MEMORY;
    }
    if (result == FNL_OK) result = device_images_decode(d, images.data, images.count, false, device_decals_deliver);
    array_free(&d->host, &images);
    return result;
}

static fnl_result prepare_pictures(struct device_scene *d) {
    const struct device_decals *all = &d->decals;
    for (uint32_t i = 0; i < all->order.count; i++) {
        const fnl_decal_params *p = &d->scene->decals.data[all->order.data[i]].params;
        TRY(need_picture(d, p->color_image, color_kind(p)));
        TRY(need_picture(d, p->normal_image, DECAL_PICTURE_DATA));
        TRY(need_picture(d, p->metallic_roughness_image, DECAL_PICTURE_DATA));
        TRY(need_picture(d, p->emissive_image, DECAL_PICTURE_COLOR));
    }
    return decode_pictures(d);
}

fnl_result device_decals_prepare(struct device_scene *d) {
    struct device_decals *all = &d->decals;
    const fnl_scene *scene = d->scene;
    if (all->version == scene->decal_version && all->structure_version == scene->structure_version) return FNL_OK;
    if (scene->decals.count == 0 && all->order.count == 0) return FNL_OK;
    all->version = UINT64_MAX; /* until it is whole */
    free_changed_pictures(d);
    TRY(find_order(d));
    TRY(prepare_pictures(d));
    TRY(prepare_mesh(d));
    TRY(prepare_redraws(d));
    struct gpu_sampler_params sampler = {.mag = VK_FILTER_LINEAR,
                                         .min = VK_FILTER_LINEAR,
                                         .mip = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                         .mipmapped = true,
                                         .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                         .anisotropy = 8,
                                         .bias = scene->texture_bias};
    all->sampler = gpu_sampler_index(d->device, &sampler);
    TRY(grow_buffer(d, "decals", &all->decals, all->order.count * sizeof(struct gpu_decal)));
    TRY(grow_buffer(d, "decal bounds", &all->bounds, all->count * sizeof(struct gpu_entity_bounds)));
    all->version = scene->decal_version;
    all->structure_version = scene->structure_version;
    return FNL_OK;
}

/* ---- inside a frame ---- */

struct send_data {
    struct gpu_slice decals, bounds;
    graph_buffer to_decals, to_bounds;
    uint64_t decals_size, bounds_size;
};

static void execute_send(const struct graph_context *context, const void *data) {
    const struct send_data *s = data;
    gpu_copy_buffer(context->commands, s->decals.buffer, s->decals.offset, graph_get_buffer(context, s->to_decals), 0,
                    s->decals_size);
    if (s->bounds_size)
        gpu_copy_buffer(context->commands, s->bounds.buffer, s->bounds.offset, graph_get_buffer(context, s->to_bounds), 0,
                        s->bounds_size);
}

static fnl_result gather(struct device_scene *d) {
    struct device_decals *all = &d->decals;
    if (!array_reserve(&d->host, &all->data, all->order.count)) return FNL_ERROR_MEMORY;
    if (!array_reserve(&d->host, &all->bound_data, all->count)) return FNL_ERROR_MEMORY;
    all->data.count = all->order.count;
    all->bound_data.count = all->count;
    for (uint32_t i = 0; i < all->order.count; i++) {
        const struct scene_decal *decal = &d->scene->decals.data[all->order.data[i]];
        mat4 transform = decal_transform(d->scene, decal);
        all->data.data[i] = device_decal(d, decal, &transform);
        if (i < all->count) all->bound_data.data[i] = device_decal_bounds(&transform, i);
    }
    return FNL_OK;
}

fnl_result device_decals_add(struct device_scene *d, struct graph *graph, struct device_decals_frame *out) {
    struct device_decals *all = &d->decals;
    *out = (struct device_decals_frame){{0}, {0}, {0}, {0}, {0}};
    if (all->order.count == 0) return FNL_OK;
    out->decals = graph_import_buffer(graph, "decals", &all->decals);
    if (all->count) out->bounds = graph_import_buffer(graph, "decal bounds", &all->bounds);
    if (all->mesh_count) {
        out->mesh_ranges = graph_import_buffer(graph, "mesh decal ranges", &all->mesh_ranges);
        out->mesh_ids = graph_import_buffer(graph, "mesh decal ids", &all->mesh_ids);
    }
    if (all->draw_count) out->redraw_draws = graph_import_buffer(graph, "redraw draws", &all->redraw_draws);
    if (d->sent.decals == d->scene->decal_version &&
        (!all->moves || d->sent.decal_transforms == d->scene->transform_version))
        return FNL_OK;
    TRY(gather(d));
    struct send_data send = {.to_decals = out->decals,
                             .to_bounds = out->bounds,
                             .decals_size = all->data.count * sizeof(struct gpu_decal),
                             .bounds_size = all->bound_data.count * sizeof(struct gpu_entity_bounds)};
    send.decals = gpu_frame_allocate(d->device, send.decals_size);
    send.bounds = gpu_frame_allocate(d->device, MAX(send.bounds_size, 16u));
    if (!send.decals.data || !send.bounds.data) return gpu_status(d->device);
    memcpy(send.decals.data, all->data.data, send.decals_size);
    if (send.bounds_size) memcpy(send.bounds.data, all->bound_data.data, send.bounds_size);
    struct graph_pass *pass = graph_add_pass(graph, "update decals", GRAPH_QUEUE_GRAPHICS, execute_send, &send, sizeof send);
    graph_use_buffer(pass, send.to_decals, GRAPH_COPY_TO);
    if (send.bounds_size) graph_use_buffer(pass, send.to_bounds, GRAPH_COPY_TO);
    d->sent.decals = d->scene->decal_version;
    d->sent.decal_transforms = d->scene->transform_version;
    return FNL_OK;
}
