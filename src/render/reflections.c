/* SPDX-License-Identifier: MIT */
#include "render/reflections.h"

#include "render/orders/order.h"
#include "render/shadows/method.h"
#include "render/step.h"

enum { FACES = 6, DIRECT = 4 /* so few probes need no list */, DIFFUSE_START = 32 };

/* Of the list over the boxes of probes. */
struct reflections_counts {
    struct light_totals list;
};
static const struct counter_table counters_reflections;

/* The probes that a frame looks up: a renderer that captures uses the probes of the renderer it captures for. */
static const struct renderer_reflections *reflections_of(const fnl_renderer *r) { return r->capture.owner ? &r->capture.owner->reflections : &r->reflections; }
static struct renderer_reflections *owned_reflections(fnl_renderer *r) { return r->capture.owner ? &r->capture.owner->reflections : &r->reflections; }

/* ---- which there are ---- */

static uint32_t side_of(const fnl_probe_params *params) {
    uint32_t side = 16;
    while (side < 1024 && side * 2 <= params->face_size) side *= 2;
    return side;
}

static void release(gpu_device *device, struct renderer_reflection *probe) { environment_finish_maps(device, &probe->maps); }

static int by_priority(const void *a, const void *b) {
    const struct renderer_reflection *x = a, *y = b;
    if (x->params.priority != y->params.priority) return x->params.priority > y->params.priority ? -1 : 1;
    return x->slot < y->slot ? -1 : 1;
}

static struct renderer_reflection *find_slot(struct renderer_reflections *p, uint32_t slot) {
    for (uint32_t i = 0; i < p->list.count; i++)
        if (p->list.data[i].slot == slot) return &p->list.data[i];
    return NULL;
}

static fnl_result grow_diffuse(fnl_renderer *r) {
    struct renderer_reflections *p = &r->reflections;
    const uint32_t held = (uint32_t)(p->diffuse.size / sizeof(struct gpu_environment));
    p->gathered = false;
    if (held >= p->list.count) return FNL_OK;
    gpu_buffer_destroy(r->device, &p->diffuse);
    const uint32_t room = MAX(MAX(2 * held, p->list.count), (uint32_t)DIFFUSE_START);
    return gpu_buffer_create_for(r->device, GPU_USE_LIGHTS, "probe light", room * sizeof(struct gpu_environment), GPU_MEMORY_DEVICE, &p->diffuse);
}

/* What the maps hold is kept where the probe is the same. */
static fnl_result take_probes(fnl_renderer *r) {
    struct renderer_reflections *p = &r->reflections;
    const fnl_scene *scene = r->scene;
    if (p->version == scene->probe_version) return FNL_OK;
    for (uint32_t i = p->list.count; i-- > 0;) {
        const uint32_t slot = p->list.data[i].slot;
        const struct scene_probe *probe = slot < scene->probes.count ? &scene->probes.data[slot] : NULL;
        if (probe && !probe->removed && probe->params.reflection) continue;
        release(r->device, &p->list.data[i]);
        p->list.data[i] = p->list.data[--p->list.count];
    }
    for (uint32_t slot = 0; slot < scene->probes.count; slot++) {
        const struct scene_probe *probe = &scene->probes.data[slot];
        if (probe->removed || !probe->params.reflection) continue;
        struct renderer_reflection *known = find_slot(p, slot);
        if (!known && !array_push(&r->host, &p->list, (struct renderer_reflection){.slot = slot})) return FNL_ERROR_MEMORY;
        if (!known) known = &p->list.data[p->list.count - 1];
        known->params.centre = probe->params.centre; /* the origin may have moved */
        if (known->version == probe->version) continue;
        const uint32_t side = side_of(&probe->params);
        if (known->maps.side != side) known->is_captured = false;
        known->params = probe->params;
        known->version = probe->version;
        known->is_due = true;
    }
    if (p->list.count) qsort(p->list.data, p->list.count, sizeof *p->list.data, by_priority);
    TRY(grow_diffuse(r));
    p->version = scene->probe_version;
    return FNL_OK;
}

static mat4 placed(const fnl_probe_params *params) { return mat4_from_trs(params->centre, params->rotation, (vec3){1, 1, 1}); }

static vec3 axis_of(const mat4 *m, int i) { return vec3_make(m->m[i * 4], m->m[i * 4 + 1], m->m[i * 4 + 2]); }

static vec3 capture_of(const fnl_probe_params *params) {
    const mat4 m = placed(params);
    return mat4_point(&m, params->capture);
}

static struct gpu_reflection reflection_of(const struct renderer_reflection *probe, uint32_t rank) {
    const fnl_probe_params *params = &probe->params;
    const mat4 m = placed(params);
    struct gpu_reflection out = {.half_size = params->half_size,
                                 .reach = params->wall,
                                 .capture = capture_of(params),
                                 .inverse_blend = 1 / fmaxf(params->blend, 1e-6f),
                                 .intensity = params->intensity,
                                 .last_mip = (float)environment_last_mip(side_of(params)),
                                 .cube = probe->is_captured ? probe->maps.cube.sampled_index : GPU_REFLECTION_DARK,
                                 .rank = rank,
                                 .mask = params->mask};
    for (int i = 0; i < 3; i++) {
        const vec3 axis = axis_of(&m, i);
        out.rows[i] = vec4_make(axis.x, axis.y, axis.z, -vec3_dot(axis, params->centre));
    }
    return out;
}

static struct gpu_entity_bounds bounds_of(const struct renderer_reflection *probe, uint32_t index) {
    const fnl_probe_params *params = &probe->params;
    const vec3 reach = vec3_make(params->wall, params->wall, params->wall);
    return (struct gpu_entity_bounds){.center = params->centre,
                                      .radius = vec3_length(vec3_add(params->half_size, reach)),
                                      .shape = GPU_NO_SHAPE,
                                      .kind = GPU_ENTITY_PROBE,
                                      .user = index};
}

/* Sends what shaders look up. */
static fnl_result prepare(fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(frame);
    if (!r->capture.owner) TRY(take_probes(r));
    struct renderer_reflections *p = owned_reflections(r);
    const uint32_t count = p->list.count;
    if (count == 0) return FNL_OK;
    struct gpu_reflection *probes = host_allocate_zero(&r->host, count * sizeof *probes);
    struct gpu_entity_bounds *bounds = host_allocate_zero(&r->host, count * sizeof *bounds);
    fnl_result result = probes && bounds ? FNL_OK : FNL_ERROR_MEMORY;
    for (uint32_t i = 0, rank = 0; i < count && result == FNL_OK; i++) {
        rank += i > 0 && p->list.data[i].params.priority != p->list.data[i - 1].params.priority;
        probes[i] = reflection_of(&p->list.data[i], rank);
        bounds[i] = bounds_of(&p->list.data[i], i);
    }
    if (result == FNL_OK) result = device_array_set(r->device_scene, GPU_USE_LIGHTS, "reflection probes", &p->probes, probes, count, sizeof *probes);
    if (result == FNL_OK) result = device_array_set(r->device_scene, GPU_USE_LIGHTS, "reflection bounds", &p->bounds, bounds, count, sizeof *bounds);
    host_free(&r->host, probes, count * sizeof *probes);
    host_free(&r->host, bounds, count * sizeof *bounds);
    return result == FNL_OK ? gpu_upload_submit(r->device) : result;
}

/* ---- capturing ---- */

/* Direct light and what the surfaces give off; ambient light outside of all boxes, and in them what was captured before. */
static fnl_frame capture_frame(const fnl_frame *shown, const fnl_camera *cameras, uint32_t side) {
    fnl_frame frame = fnl_frame_default();
    frame.width = frame.height = side;
    frame.views = cameras;
    frame.view_count = FACES;
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_CLUSTERED;
    frame.studio = shown->studio;
    frame.ground = shown->ground;
    frame.msaa = 1;
    frame.aa = FNL_ANTIALIASING_NONE;
    frame.shadows = shadow_method(shown->shadows)->captured_as;
    frame.shadow = shown->shadow;
    frame.shadow.denoise = frame.shadow.guide = false;
    frame.shadow.contact_length = 0; /* the picture of another view */
    frame.shadow.memory = MAX(shown->shadow.memory / FACES, 8u); /* each face has its own */
    frame.decals = shown->decals == FNL_DECALS_OFF ? FNL_DECALS_OFF : FNL_DECALS_LISTS;
    frame.transparency = shown->transparency;
    frame.exposure = FNL_EXPOSURE_NONE;
    frame.outputs = 0;
    frame.timers = false;
    frame.occlusion = FNL_OCCLUSION_OFF;
    frame.record_threads = shown->record_threads;
    frame.reflections = shown->reflections;
    return frame;
}

/* Cameras that see the faces of a cube map, mirrored: reflections_face.comp.glsl. */
static void face_cameras(const fnl_probe_params *params, fnl_camera *out) {
    static const vec3 forward[FACES] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    static const vec3 up[FACES] = {{0, 1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}, {0, 1, 0}, {0, 1, 0}};
    const vec3 from = capture_of(params);
    for (int i = 0; i < FACES; i++) {
        out[i] = fnl_camera_default();
        out[i].position = from;
        out[i].target = vec3_add(from, forward[i]);
        out[i].up = up[i];
        out[i].vertical_fov = PI / 2;
        out[i].near_distance = 0.01f;
    }
}

/* In a frame that captures: the picture of the view becomes a face. */
static void finish_view(struct frame_state *f) {
    const fnl_renderer *r = f->r;
    if (!r->capture.owner) return;
    const struct renderer_reflection *probe = &r->capture.owner->reflections.list.data[r->capture.probe];
    const uint32_t side = f->frame->width;
    if (f->view_index == 0) f->common->faces = environment_faces_create(f->graph, side);
    environment_face_add(f->graph, r->device, side, f->view_index, f->radiance, &f->common->faces);
    if (f->view_index + 1 < FACES) return;
    environment_faces_filter(f->graph, r->device, &probe->maps, &f->common->faces);
}

static fnl_result capture(fnl_renderer *r, const fnl_frame *shown, uint32_t index) {
    struct renderer_reflections *p = &r->reflections;
    struct renderer_reflection *probe = &p->list.data[index];
    fnl_camera cameras[FACES];
    const uint32_t side = side_of(&probe->params);
    const bool compressed = r->scene->environment.compressed && gpu_info(r->device)->texture_compression;
    const VkFormat before = probe->maps.cube.params.format;
    TRY(environment_prepare_cube(r->device, side, compressed, &probe->maps));
    if (probe->maps.cube.params.format != before) probe->is_captured = false;
    if (!probe->maps.light.handle) TRY(gpu_buffer_create_for(r->device, GPU_USE_LIGHTS, "probe light", sizeof(struct gpu_environment), GPU_MEMORY_DEVICE, &probe->maps.light));
    face_cameras(&probe->params, cameras);
    const fnl_frame frame = capture_frame(shown, cameras, side);
    p->capturer->capture.probe = index;
    p->captures++;
    const fnl_result result = fnl_renderer_render(p->capturer, &frame);
    environment_release(r->device, &probe->maps);
    p->gathered = false;
    return result;
}

static fnl_result capture_due(fnl_renderer *r, const fnl_frame *frame) {
    struct renderer_reflections *p = &r->reflections;
    if (!p->capturer) {
        TRY(fnl_renderer_create(r->device, r->scene, &p->capturer));
        p->capturer->capture.owner = r;
    }
    bool all_known = true;
    for (uint32_t i = 0; i < p->list.count; i++) all_known &= !p->list.data[i].is_due || p->list.data[i].is_captured;
    const uint32_t rounds = all_known ? 1 : frame->reflections.bounces; /* later ones go on from what is there */
    for (uint32_t round = 0; round < rounds; round++) {
        for (uint32_t i = 0; i < p->list.count; i++)
            if (p->list.data[i].is_due) TRY(capture(r, frame, i));
        for (uint32_t i = 0; i < p->list.count; i++) p->list.data[i].is_captured |= p->list.data[i].is_due;
        p->gathered = false;
    }
    for (uint32_t i = 0; i < p->list.count; i++) p->list.data[i].is_due = false;
    return FNL_OK;
}

fnl_result reflections_capture(fnl_renderer *r, const fnl_frame *frame) {
    struct renderer_reflections *p = &r->reflections;
    p->captures = 0;
    if (r->capture.owner) return FNL_OK;
    TRY(take_probes(r));
    const uint32_t again = MIN(frame->reflections.refresh, p->list.count);
    for (uint32_t i = 0; i < again; i++) p->list.data[p->turn++ % p->list.count].is_due = true;
    bool is_due = false;
    for (uint32_t i = 0; i < p->list.count; i++) is_due |= p->list.data[i].is_due;
    if (is_due) TRY(capture_due(r, frame));
    if (frame->reflections.refresh == 0 && p->capturer) fnl_renderer_destroy(&p->capturer); /* with the memory of its frames */
    return FNL_OK;
}

static void destroy(fnl_renderer *r) {
    struct renderer_reflections *p = &r->reflections;
    fnl_renderer_destroy(&p->capturer);
    for (uint32_t i = 0; i < p->list.count; i++) release(r->device, &p->list.data[i]);
    gpu_buffer_destroy(r->device, &p->diffuse);
    gpu_buffer_destroy(r->device, &p->probes.buffer);
    gpu_buffer_destroy(r->device, &p->bounds.buffer);
    array_free(&r->host, &p->probes.sent);
    array_free(&r->host, &p->bounds.sent);
    array_free(&r->host, &p->list);
}

/* ---- in the frame ---- */

static fnl_result send_set(struct frame_state *f, const struct renderer_reflections *p) {
    struct gpu_slice slice = gpu_frame_allocate(f->r->device, sizeof(struct gpu_reflection_set));
    if (!slice.data) return gpu_status(f->r->device);
    const struct gpu_sampler_params smooth = {.mag = VK_FILTER_LINEAR,
                                              .min = VK_FILTER_LINEAR,
                                              .mip = VK_SAMPLER_MIPMAP_MODE_LINEAR,
                                              .mipmapped = true,
                                              .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                              .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                              .anisotropy = 1};
    f->reflections = slice.data;
    *f->reflections = (struct gpu_reflection_set){.reflections = p->probes.buffer.address,
                                                  .diffuse = p->diffuse.address,
                                                  .count = p->list.count,
                                                  .sampler_index = gpu_sampler_index(f->r->device, &smooth),
                                                  .mip_scale = 1 / (float)f->r->device_scene->environment.table_mip,
                                                  .parallax = f->frame->reflections.parallax};
    f->view.reflections = (uvec2){(uint32_t)slice.address, (uint32_t)(slice.address >> 32)};
    f->lighting.environment.reflections.set = slice.address;
    return FNL_OK;
}

/* As the clusters of decals: slices reach as far as the scene does. The pool holds 64 probes for each cell; beyond that there is the spare list. */
static struct clustered_params cluster_params(const struct frame_state *f, uint32_t count) {
    struct clustered_params params = clustered_params_default();
    params.far = fminf(view_reach(&f->view, &f->r->device_scene->bounds), 1e6f);
    params.near = fminf(fmaxf(f->frame->camera.near_distance, params.far / 128), params.far * 0.5f);
    params.slices = 16;
    params.cone_tests = false;
    params.pool_capacity = DIVIDE_UP(f->frame->width, params.tile_size) * DIVIDE_UP(f->frame->height, params.tile_size) * params.slices * MIN(count, 64u);
    return params;
}

struct gather_data {
    graph_buffer from, to;
    uint64_t offset;
};

static void execute_gather(const struct graph_context *context, const void *data) {
    const struct gather_data *d = data;
    gpu_copy_buffer(context->commands, graph_get_buffer(context, d->from), 0, graph_get_buffer(context, d->to), d->offset, sizeof(struct gpu_environment));
}

/* What each has seen is kept apart, because their order changes; shaders read it from one buffer. */
static void gather_diffuse(struct frame_state *f, const struct renderer_reflections *p, graph_buffer to) {
    if (p->gathered || f->view_index > 0) return;
    for (uint32_t i = 0; i < p->list.count; i++) {
        if (!p->list.data[i].is_captured) continue;
        const struct gather_data data = {graph_import_buffer(f->graph, "probe light", &p->list.data[i].maps.light), to, i * sizeof(struct gpu_environment)};
        struct graph_pass *pass =
            graph_add_pass(f->graph, graph_name(f->graph, "reflections light %u", i), GRAPH_QUEUE_GRAPHICS, execute_gather, &data, sizeof data);
        graph_use_buffer(pass, data.from, GRAPH_COPY_FROM);
        graph_use_buffer(pass, data.to, GRAPH_COPY_TO);
    }
}

static void submitted(fnl_renderer *r, const fnl_frame *frame) {
    UNUSED(frame);
    owned_reflections(r)->gathered = true;
}

static void forget(fnl_renderer *r) { owned_reflections(r)->gathered = false; }

/* The list over the boxes, and what shading passes need. */
static fnl_result begin_view(struct frame_state *f) {
    const struct renderer_reflections *p = reflections_of(f->r);
    if (p->list.count == 0) return FNL_OK;
    TRY(send_set(f, p));
    struct environment_reflections *out = &f->lighting.environment.reflections;
    graph_set_role(f->graph, GRAPH_ROLE_SHADING);
    out->reflections = graph_import_buffer(f->graph, "reflection probes", &p->probes.buffer);
    out->bounds = graph_import_buffer(f->graph, "reflection bounds", &p->bounds.buffer);
    out->diffuse = graph_import_buffer(f->graph, "probe light", &p->diffuse);
    gather_diffuse(f, p, out->diffuse);
    if (p->list.count <= DIRECT) return FNL_OK;
    const struct light_input input = {.set = {.buffer = out->bounds, .entities = p->bounds.buffer.address, .local_count = p->list.count},
                                      .kinds = 1u << GPU_ENTITY_PROBE,
                                      .view = f->view_address,
                                      .width = f->frame->width,
                                      .height = f->frame->height,
                                      .spheres_only = true,
                                      .queue = GRAPH_QUEUE_ASYNC};
    const struct clustered_params params = cluster_params(f, p->list.count);
    graph_push_names(f->graph, "reflections");
    const struct lights_in_view in_view = lights_in_view_add(f->graph, f->r->device, &input);
    const struct light_list list = clustered_add(f->graph, f->r->device, &input, &in_view, &params);
    graph_pop_names(f->graph);
    f->reflections->list = list.header;
    out->cells = list.cells;
    out->ids = list.ids;
    out->spare = list.spare;
    COUNTERS_COPY(f, list.totals, 0, reflections, list);
    return FNL_OK;
}

/* ---- numbers ---- */

static void light_view(struct frame_state *f) {
    const struct renderer_reflections *p = &f->r->reflections;
    if (f->r->capture.owner || p->list.count == 0) return;
    uint64_t bytes = 0;
    for (uint32_t i = 0; i < p->list.count; i++) bytes += environment_cube_bytes(&p->list.data[i].maps) + sizeof(struct gpu_environment);
    const uint32_t captures = f->view_index == 0 ? p->captures : 0;
    counters_note(f, "reflections.probes", p->list.count);
    counters_note(f, "reflections.captures", captures);
    counters_note(f, "reflections.faces", captures * FACES);
    counters_note(f, "reflections.bytes", bytes);
}

static const struct counter rows[] = {
    {"reflections.probes", "probes", "reflection probes", NOTED},
    {"reflections.captures", "captures", "captures of a probe that were made for this frame", NOTED},
    {"reflections.faces", "faces", "views drawn for them", NOTED},
    {"reflections.bytes", "bytes", "memory of what the probes have seen", NOTED},
    {"reflections.entries", "", "entries of the list over their boxes; with 4 probes or fewer all are looked at, without a list",
     COUNTED(reflections, list.entries)},
};
static const struct counter_table counters_reflections = COUNTER_TABLE_COUNTED(rows, reflections);

const struct frame_step step_reflections = {.name = "reflections",
                                            .prepare = prepare,
                                            .begin_view = begin_view,
                                            .light_view = light_view,
                                            .finish_view = finish_view,
                                            .submitted = submitted,
                                            .forget = forget,
                                            .destroy = destroy,
                                            .counters = &counters_reflections};
