/* SPDX-License-Identifier: MIT */
/** Shadows by the cube maps of probes (fanal/probe.h), which know what the walls of their rooms let in. */
#include "render/shadows/method.h"
#include "render/step.h"

/* ---- what moves: whatever has moved since it was first seen, what an animation moves, and what deforms. It is not baked, and rays find its shadow ---- */

static void see_node(fnl_renderer *r, uint32_t n) {
    struct renderer_probes *p = &r->probes;
    const struct scene_node *node = &r->scene->nodes.data[n];
    if (p->known_generations.data[n] != node->generation || p->mover_generations.data[n] == node->generation) return;
    if (!device_node_draws(node)) return;
    p->mover_generations.data[n] = node->generation;
    p->mover_version++;
}

static bool is_animated(const fnl_scene *scene, uint32_t node) {
    for (uint32_t i = 0; i < scene->animations.count; i++)
        for (uint32_t k = 0; k < scene->animations.data[i].channel_count; k++) {
            const struct scene_channel *channel = &scene->animations.data[i].channels[k];
            if (channel->path > SCENE_PATH_SCALE) continue; /* moves nothing */
            for (uint32_t n = node; n != SCENE_NONE; n = scene->nodes.data[n].parent)
                if (n == channel->node) return true;
        }
    return false;
}

/*
 * A move of the origin marks all nodes as moved. If a call first moved a node since the
 * last frame and before the origin moved, the node is therefore not recognized as a mover.
 */
static fnl_result find_movers(fnl_renderer *r) {
    struct renderer_probes *p = &r->probes;
    const fnl_scene *scene = r->scene;
    if (!array_reserve(&r->host, &p->mover_generations, scene->nodes.count) || !array_reserve(&r->host, &p->known_generations, scene->nodes.count))
        return FNL_ERROR_MEMORY;
    for (uint32_t n = p->known_generations.count; n < scene->nodes.count; n++) p->known_generations.data[n] = p->mover_generations.data[n] = 0;
    p->known_generations.count = p->mover_generations.count = scene->nodes.count;
    const uint64_t since = MAX(p->transforms, scene->origin_version);
    if (p->started && since != scene->transform_version) {
        if (scene->moved_since <= since)
            for (uint32_t i = 0; i < scene->moved.count; i++) {
                const uint32_t n = scene->moved.data[i];
                if (scene->nodes.data[n].moved_version > since) see_node(r, n);
            }
        else
            for (uint32_t n = 0; n < scene->nodes.count; n++)
                if (scene->nodes.data[n].moved_version > since) see_node(r, n);
    }
    p->transforms = scene->transform_version;
    if (!p->started || p->structure != r->device_scene->structure_version)
        for (uint32_t n = 0; n < scene->nodes.count; n++) {
            p->known_generations.data[n] = scene->nodes.data[n].generation;
            if (scene->nodes.data[n].mesh != SCENE_NONE && is_animated(scene, n)) see_node(r, n);
        }
    return FNL_OK;
}

static fnl_result send_movers(fnl_renderer *r) {
    struct renderer_probes *p = &r->probes;
    struct device_scene *d = r->device_scene;
    if (p->started && p->structure == d->structure_version && p->sent_movers == p->mover_version) return FNL_OK;
    ARRAY(uint32_t) bits = {0};
    const uint32_t words = DIVIDE_UP(d->item_count, 32u) + 1;
    if (!array_reserve(&r->host, &bits, words)) return FNL_ERROR_MEMORY;
    memset(bits.data, 0, words * sizeof *bits.data);
    p->moves = false;
    for (uint32_t i = 0; i < d->item_count; i++) {
        const uint32_t n = d->item_nodes.data[i];
        const bool moves = p->mover_generations.data[n] == r->scene->nodes.data[n].generation || d->nodes.data[n].first_primitive != SCENE_NONE;
        if (moves) bits.data[i / 32] |= 1u << i % 32;
        p->moves |= moves;
    }
    fnl_result result = device_array_set(d, GPU_USE_LIGHTS, "moving items", &p->moving, bits.data, words, sizeof *bits.data);
    array_free(&r->host, &bits);
    p->structure = d->structure_version;
    p->sent_movers = p->mover_version;
    p->started = true;
    return result;
}

/* ---- which there are ---- */

static bool is_lit_from_outside(const fnl_scene *scene, struct box room) {
    for (uint32_t i = 0; i < scene->lights.count; i++) {
        const struct scene_light *light = &scene->lights.data[i];
        const vec3 at = light->params.position;
        if (!scene_light_shines(light) || !light->params.casts_shadows) continue;
        if (light->params.kind == FNL_LIGHT_DIRECTIONAL || at.x < room.low.x || at.y < room.low.y || at.z < room.low.z || at.x > room.high.x ||
            at.y > room.high.y || at.z > room.high.z)
            return true;
    }
    return false;
}

/* For a scene without probes: a box round all of it, if it has an inside and some light shines in. */
static bool fit_probe(fnl_renderer *r, fnl_probe_params *out) {
    const struct box box = r->device_scene->bounds;
    *out = fnl_probe_params_default();
    out->centre = vec3_scale(vec3_add(box.low, box.high), 0.5f);
    out->half_size = vec3_scale(vec3_sub(box.high, box.low), 0.5f);
    const float least = fminf(out->half_size.x, fminf(out->half_size.y, out->half_size.z));
    const bool fits = least > 4 * out->wall && isfinite(least) && is_lit_from_outside(r->scene, box);
    if (!r->probes.told && fits)
        log_info(&r->host, "shadows: the scene has no probe: the walls of one are taken to be its bounds, %g x %g x %g m", 2 * (double)out->half_size.x,
                 2 * (double)out->half_size.y, 2 * (double)out->half_size.z);
    if (!r->probes.told && !fits)
        log_warning(&r->host, "shadows: the scene has no probe and no room that light shines into, so cubemap has nothing to do: rays find all shadows");
    r->probes.told = true;
    return fits;
}

static fnl_result take_probe(fnl_renderer *r, uint32_t index, const fnl_probe_params *params, bool compressed) {
    struct renderer_probes *p = &r->probes;
    if (index == p->list.count && !array_push(&r->host, &p->list, (struct renderer_probe){0})) return FNL_ERROR_MEMORY;
    struct renderer_probe *probe = &p->list.data[index];
    const bool is_compressed = probe->image.params.format == VK_FORMAT_BC3_UNORM_BLOCK;
    if (probe->image.handle && (probe->image.params.width != params->face_size || is_compressed != compressed)) gpu_image_destroy(r->device, &probe->image);
    if (!probe->image.handle) {
        TRY(cubemap_create(r->device, params->face_size, compressed, &probe->image));
        probe->key = 0;
    }
    probe->params = *params;
    return FNL_OK;
}

static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    struct renderer_probes *p = &r->probes;
    const fnl_scene *scene = r->scene;
    const bool compressed = frame->shadow.cubemap_compress && gpu_info(r->device)->texture_compression;
    TRY(find_movers(r));
    TRY(send_movers(r));
    uint32_t count = 0;
    for (uint32_t i = 0; i < scene->probes.count; i++) {
        const struct scene_probe *probe = &scene->probes.data[i];
        if (probe->removed || !probe->params.shadows) continue;
        if (count == PROBES_MOST) {
            if (!p->told) log_warning(&r->host, "shadows: the scene has more than %u probes: those after them cast no shadows", PROBES_MOST);
            p->told = true;
            break;
        }
        TRY(take_probe(r, count++, &probe->params, compressed));
    }
    fnl_probe_params fitted;
    if (scene_entity_count(scene, FNL_ENTITY_PROBE) == 0 && fit_probe(r, &fitted)) TRY(take_probe(r, count++, &fitted, compressed));
    while (p->list.count > count) gpu_image_destroy(r->device, &p->list.data[--p->list.count].image);
    return gpu_upload_submit(r->device);
}

/* ---- in the frame ---- */

static mat4 world_to_probe(const fnl_probe_params *params) {
    const mat4 placed = mat4_from_trs(params->centre, params->rotation, (vec3){1, 1, 1});
    mat4 inverse = mat4_identity();
    for (int row = 0; row < 3; row++) {
        float shift = 0;
        for (int k = 0; k < 3; k++) {
            inverse.m[k * 4 + row] = placed.m[row * 4 + k];
            shift -= placed.m[row * 4 + k] * placed.m[12 + k];
        }
        inverse.m[12 + row] = shift;
    }
    return inverse;
}

static struct gpu_probe probe_of(const struct renderer_probe *probe) {
    const fnl_probe_params *params = &probe->params;
    const mat4 m = world_to_probe(params);
    struct gpu_probe out = {.half_size = params->half_size,
                            .wall = params->wall,
                            .capture = params->capture,
                            .softness = params->softness,
                            .image = probe->image.sampled_index,
                            .side = params->face_size};
    for (int row = 0; row < 3; row++) out.rows[row] = vec4_make(m.m[row], m.m[4 + row], m.m[8 + row], m.m[12 + row]);
    return out;
}

/* What the image of a probe depends on. */
static uint64_t key_of(const fnl_renderer *r, const struct renderer_probe *probe) {
    const struct device_scene *d = r->device_scene;
    const struct renderer_probes *p = &r->probes;
    fnl_probe_params seen = probe->params;
    seen.softness = 0; /* not of the image, as the next */
    seen.reflection = false;
    seen.blend = seen.intensity = 0;
    seen.priority = 0;
    const uint64_t words[] = {d->ray_key, d->structure_version, d->material_version, d->texture_version, d->image_arrivals, p->sent_movers};
    return hash_bytes(&seen, sizeof seen, hash_bytes(words, sizeof words, 1)) | 1;
}

static void begin(struct frame_state *shared) {
    const fnl_renderer *r = shared->r;
    const struct renderer_probes *p = &r->probes;
    const fnl_shadow_options *options = &shared->frame->shadow;
    const uint32_t count = p->list.count;
    if (count == 0) return;
    struct gpu_slice head = gpu_frame_allocate(r->device, sizeof(struct gpu_probes)), list = gpu_frame_allocate(r->device, count * sizeof(struct gpu_probe));
    if (!head.data || !list.data) return; /* the frame fails */
    const struct gpu_sampler_params smooth = {.mag = VK_FILTER_LINEAR,
                                              .min = VK_FILTER_LINEAR,
                                              .mip = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                              .mipmapped = true,
                                              .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                              .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                              .anisotropy = 1};
    *(struct gpu_probes *)head.data = (struct gpu_probes){
        .probes = list.address,
        .moving = p->moving.buffer.address,
        .count = count,
        .smooth_sampler = gpu_sampler_index(r->device, &smooth),
        .flags = (options->cubemap_lod == FNL_CUBEMAP_LOD_PHYSICAL ? PROBES_PHYSICAL : 0) | (options->cubemap_correct ? PROBES_CORRECT : 0) |
                 (options->cubemap_tint ? PROBES_TINT : 0) | (options->cubemap_inside == FNL_CUBEMAP_INSIDE_ALL ? PROBES_INSIDE : 0) |
                 (p->moves && options->cubemap_inside != FNL_CUBEMAP_INSIDE_NONE ? PROBES_MOVERS : 0)};
    /* Bakes pass by what moves, whatever the frame's rays find. */
    struct gpu_slice baking = gpu_frame_allocate(r->device, sizeof(struct gpu_probes));
    if (!baking.data) return;
    *(struct gpu_probes *)baking.data = *(const struct gpu_probes *)head.data;
    ((struct gpu_probes *)baking.data)->flags = p->moves ? PROBES_MOVERS : 0;
    struct probes *out = &shared->lighting.shadows.rooms;
    *out = (struct probes){.count = count, .address = head.address};
    shared->lighting.shadows.bits |= GPU_LIGHTING_CUBEMAP;
    for (uint32_t i = 0; i < count; i++) {
        const struct renderer_probe *probe = &p->list.data[i];
        ((struct gpu_probe *)list.data)[i] = probe_of(probe);
        const VkImageLayout sampled = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
        const bool bakes = probe->key != key_of(r, probe);
        out->images[i] = graph_import_image(shared->graph, &probe->image, probe->key == 0 ? VK_IMAGE_LAYOUT_UNDEFINED : sampled, sampled);
        if (bakes) cubemap_bake_add(shared->graph, &shared->shadows.rays, baking.address, i, out->images[i], renderer_tests(r).probe_tap);
    }
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    if (!shadows_have(frame, SHADOWS_ROOMS)) return;
    for (uint32_t i = 0; i < r->probes.list.count; i++) r->probes.list.data[i].key = key_of(r, &r->probes.list.data[i]);
}

static void destroy(fnl_renderer *r) {
    for (uint32_t i = 0; i < r->probes.list.count; i++) gpu_image_destroy(r->device, &r->probes.list.data[i].image);
    gpu_buffer_destroy(r->device, &r->probes.moving.buffer);
    array_free(&r->host, &r->probes.moving.sent);
    array_free(&r->host, &r->probes.list);
    array_free(&r->host, &r->probes.mover_generations);
    array_free(&r->host, &r->probes.known_generations);
}

/* ---- numbers ---- */

static bool holds(const struct renderer_probe *probe, vec3 at) {
    const mat4 m = world_to_probe(&probe->params);
    const float *half = &probe->params.half_size.x;
    for (int row = 0; row < 3; row++) {
        const float place = m.m[row] * at.x + m.m[4 + row] * at.y + m.m[8 + row] * at.z + m.m[12 + row];
        if (!(fabsf(place) <= half[row] + probe->params.wall)) return false;
    }
    return true;
}

static uint64_t lights_inside(const fnl_renderer *r) {
    uint64_t inside = 0;
    for (uint32_t i = 0; i < r->scene->lights.count; i++) {
        const struct scene_light *light = &r->scene->lights.data[i];
        if (!scene_light_shines(light) || !light->params.casts_shadows || light->params.kind == FNL_LIGHT_DIRECTIONAL) continue;
        uint32_t k = 0;
        while (k < r->probes.list.count && !holds(&r->probes.list.data[k], light->params.position)) k++;
        inside += k < r->probes.list.count;
    }
    return inside;
}

static void begin_view(struct frame_state *f) {
    const struct renderer_probes *p = &f->r->probes;
    uint64_t baked = 0, bytes = 0;
    for (uint32_t i = 0; i < p->list.count; i++) {
        baked += p->list.data[i].key != key_of(f->r, &p->list.data[i]);
        bytes += cubemap_bytes(p->list.data[i].params.face_size, p->list.data[i].image.params.format == VK_FORMAT_BC3_UNORM_BLOCK);
    }
    counters_note(f, "probes.count", p->list.count);
    counters_note(f, "probes.baked", f->view_index == 0 ? baked : 0);
    counters_note(f, "probes.bytes", bytes);
    counters_note(f, "probes.lights-inside", lights_inside(f->r));
}

static const struct counter rows[] = {
    {"probes.count", "probes", "probes by whose cube maps shadows are found", NOTED, .needs = "shadows=cubemap"},
    {"probes.baked", "probes", "of them, baked in this frame", NOTED, .needs = "shadows=cubemap"},
    {"probes.bytes", "bytes", "memory of their cube maps", NOTED, .needs = "shadows=cubemap"},
    {"probes.lights-inside", "lights", "lights in a box of a probe, whose shadows rays find", NOTED, .needs = "shadows=cubemap"},
};
static const struct counter_table counters_cubemap = COUNTER_TABLE(rows);

const struct shadow_method shadow_method_cubemap = {.traits = SHADOWS_RAYS | SHADOWS_TREES | SHADOWS_ROOMS | SHADOWS_EXACT,
                                                    .captured_as = FNL_SHADOWS_CUBEMAP,
                                                    .prepare = prepare,
                                                    .submitted = submitted,
                                                    .destroy = destroy,
                                                    .begin = begin,
                                                    .begin_view = begin_view,
                                                    .counters = &counters_cubemap};
