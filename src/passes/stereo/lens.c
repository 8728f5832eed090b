/* SPDX-License-Identifier: MIT */
#include "passes/stereo/lens.h"

#include "shaders.h"

/* ---- lenses ---- */

vec2 lens_bend(const fnl_lens *lens, vec2 at, uint32_t channel) {
    const float x = at.x - lens->center.x, y = at.y - lens->center.y, r2 = x * x + y * y;
    float factor = 0;
    for (int i = LENS_TERMS - 1; i >= 0; i--) factor = (factor + lens->k[channel][i]) * r2;
    return (vec2){at.x + x * factor, at.y + y * factor};
}

struct gpu_lens_eye lens_eye(const fnl_display_eye *eye, vec2 source_size) {
    struct gpu_lens_eye e = {.display = {eye->left, eye->right, eye->down, eye->up},
                             .rendered = {eye->eye.left, eye->eye.right, eye->eye.down, eye->eye.up},
                             .center = eye->lens.center,
                             .visible_radius = fminf(eye->visible_radius, 1e9f),
                             .source_size = source_size};
    memcpy(e.terms, eye->lens.k, sizeof e.terms);
    return e;
}

void lens_mesh(const fnl_display_eye *eye, struct gpu_lens_vertex vertices[LENS_VERTICES]) {
    for (uint32_t i = 0; i < LENS_VERTICES; i++) {
        const float x = (float)(i % (LENS_QUADS + 1)) / LENS_QUADS, y = (float)(i / (LENS_QUADS + 1)) / LENS_QUADS;
        const vec2 q = {eye->left + (eye->right - eye->left) * x, eye->up + (eye->down - eye->up) * y};
        vertices[i] = (struct gpu_lens_vertex){{x, y}, lens_bend(&eye->lens, q, 0), lens_bend(&eye->lens, q, 1), lens_bend(&eye->lens, q, 2)};
    }
}

/* ---- which quads show something ---- */

static float cross(vec2 a, vec2 b) { return a.x * b.y - a.y * b.x; }
static vec2 minus(vec2 a, vec2 b) { return (vec2){a.x - b.x, a.y - b.y}; }
static float dot(vec2 a, vec2 b) { return a.x * b.x + a.y * b.y; }

static float segment_distance(vec2 a, vec2 b, vec2 p) {
    const vec2 along = minus(b, a), to = minus(p, a);
    const float length2 = dot(along, along), t = length2 > 0 ? CLAMP(dot(to, along) / length2, 0.0f, 1.0f) : 0;
    const vec2 off = {to.x - along.x * t, to.y - along.y * t};
    return sqrtf(dot(off, off));
}

static float triangle_distance(const vec2 t[3], vec2 p) {
    uint32_t left = 0, right = 0;
    float nearest = FLT_MAX;
    for (uint32_t i = 0; i < 3; i++) {
        const float side = cross(minus(t[(i + 1) % 3], t[i]), minus(p, t[i]));
        left += side >= 0;
        right += side <= 0;
        nearest = fminf(nearest, segment_distance(t[i], t[(i + 1) % 3], p));
    }
    return left == 3 || right == 3 ? 0 : nearest;
}

/* By axes that separate a triangle from a rectangle: those of the rectangle and the normals of the triangle. */
static bool touches_rectangle(const vec2 t[3], vec4 r) {
    if (fmaxf(fmaxf(t[0].x, t[1].x), t[2].x) < r.x || fminf(fminf(t[0].x, t[1].x), t[2].x) > r.y) return false;
    if (fmaxf(fmaxf(t[0].y, t[1].y), t[2].y) < r.z || fminf(fminf(t[0].y, t[1].y), t[2].y) > r.w) return false;
    const vec2 corners[4] = {{r.x, r.z}, {r.y, r.z}, {r.x, r.w}, {r.y, r.w}};
    for (uint32_t i = 0; i < 3; i++) {
        const vec2 edge = minus(t[(i + 1) % 3], t[i]);
        const float own = cross(edge, minus(t[(i + 2) % 3], t[i]));
        uint32_t beyond = 0;
        for (uint32_t c = 0; c < 4; c++) beyond += cross(edge, minus(corners[c], t[i])) * (own < 0 ? -1.0f : 1.0f) < 0;
        if (beyond == 4) return false;
    }
    return true;
}

static bool is_seen(const fnl_display_eye *eye, const vec2 t[3]) {
    const vec4 rendered = {eye->eye.left, eye->eye.right, eye->eye.down, eye->eye.up};
    return touches_rectangle(t, rendered) && triangle_distance(t, eye->lens.center) <= eye->visible_radius;
}

uint32_t lens_cells(const fnl_display_eye *eye, const struct gpu_lens_vertex vertices[LENS_VERTICES], bool trim, uint32_t cells[LENS_CELLS]) {
    uint32_t count = 0;
    for (uint32_t cell = 0; cell < LENS_CELLS; cell++) {
        const struct gpu_lens_vertex *v = &vertices[cell / LENS_QUADS * (LENS_QUADS + 1) + cell % LENS_QUADS];
        const uint32_t corners[4] = {0, LENS_QUADS + 1, 1, LENS_QUADS + 2}; /* as lens.vert.glsl takes them */
        bool seen = !trim;
        for (uint32_t i = 0; i < 2 && !seen; i++) {
            vec2 red[3], green[3], blue[3];
            for (uint32_t k = 0; k < 3; k++) {
                red[k] = v[corners[i + k]].red;
                green[k] = v[corners[i + k]].green;
                blue[k] = v[corners[i + k]].blue;
            }
            seen = is_seen(eye, red) || is_seen(eye, green) || is_seen(eye, blue);
        }
        if (seen) cells[count++] = cell;
    }
    return count;
}

/* ---- layers ---- */

struct gpu_lens_layer lens_picture(vec4 rendered, const mat4 *turn) {
    const float *m = turn->m, width = rendered.y - rendered.x, height = rendered.w - rendered.z;
    struct gpu_lens_layer layer = {.blended = 0};
    float *rows[3] = {&layer.rows[0].x, &layer.rows[1].x, &layer.rows[2].x};
    for (int i = 0; i < 3; i++) {
        const float x = m[4 * i], y = m[4 * i + 1], z = m[4 * i + 2];
        rows[2][i] = -z;
        rows[0][i] = (x + rendered.x * z) / width;
        rows[1][i] = (-rendered.w * z - y) / height;
    }
    return layer;
}

bool lens_quad(const mat4 *pose, float width, float height, struct gpu_lens_layer *out) {
    const float *m = pose->m;
    const vec3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]}, z = {m[8], m[9], m[10]}, middle = {m[12], m[13], m[14]};
    const float before = -vec3_dot(z, middle);
    if (before <= 1e-6f) return false;
    /* A direction d hits the plane at d t = middle + a x + b y with 1 / t = -(z . d) / before; then a / t = x . d - (x . middle) / t. */
    const vec3 depth = vec3_scale(z, -1 / before), a = vec3_sub(x, vec3_scale(depth, vec3_dot(x, middle))), b = vec3_sub(y, vec3_scale(depth, vec3_dot(y, middle)));
    *out = (struct gpu_lens_layer){.rows = {vec3_add(vec3_scale(a, 1 / width), vec3_scale(depth, 0.5f)), vec3_add(vec3_scale(b, -1 / height), vec3_scale(depth, 0.5f)), depth},
                                   .blended = 1};
    return true;
}

/* ---- passes ---- */

static uint32_t smooth_sampler(gpu_device *device) {
    return gpu_sampler_index(device, &(struct gpu_sampler_params){.mag = VK_FILTER_LINEAR,
                                                                  .min = VK_FILTER_LINEAR,
                                                                  .wrap_u = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                  .wrap_v = VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE,
                                                                  .anisotropy = 1});
}

struct lens_data {
    struct gpu_lens_push push;
    uint32_t x, width, height, vertex_count;
    struct gpu_graphics_params state;
};

static void execute_lens(const struct graph_context *context, const void *data) {
    const struct lens_data *d = data;
    if (d->vertex_count == 0) return;
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_scissor(context->commands, d->x, 0, d->width, d->height);
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_draw(context->commands, d->vertex_count, 1, 0, 0);
}

void lens_add(gpu_device *device, struct graph *graph, const struct lens_params *params, graph_image target) {
    const struct graph_image_params info = graph_image_info(graph, target);
    struct gpu_slice eye = gpu_frame_allocate(device, sizeof params->eye);
    struct gpu_slice layers = gpu_frame_allocate(device, MAX(params->layer_count, 1u) * sizeof *params->layers);
    if (!eye.data || !layers.data) return;
    memcpy(eye.data, &params->eye, sizeof params->eye);
    if (params->layer_count) memcpy(layers.data, params->layers, params->layer_count * sizeof *params->layers);
    const bool mesh = params->vertices;
    struct lens_data data = {.push = {.eye = eye.address,
                                      .layers = layers.address,
                                      .vertices = params->vertices,
                                      .cells = params->cells,
                                      .origin = {(float)params->x, 0},
                                      .size = {(float)params->width, (float)info.height},
                                      .target = {(float)info.width, (float)info.height},
                                      .layer_count = params->layer_count,
                                      .sampler_index = smooth_sampler(device),
                                      .view = params->view,
                                      .flags = (params->encode ? LENS_ENCODES : 0) | (params->count.id ? LENS_COUNTS : 0)},
                             .x = params->x,
                             .width = params->width,
                             .height = info.height,
                             .vertex_count = mesh ? 6 * params->cell_count : 3};
    data.state = (struct gpu_graphics_params){.vertex = mesh ? &shader_lens_vert : &shader_screen_vert,
                                              .fragment = mesh ? &shader_lens_mesh_frag : &shader_lens_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .color_count = 1,
                                              .color_formats = {info.format},
                                              .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, params->name, GRAPH_QUEUE_GRAPHICS, execute_lens, &data, sizeof data);
    for (uint32_t i = 0; i < params->layer_count; i++) {
        if (!params->images[i].id) continue;
        graph_use_image(pass, params->images[i], GRAPH_SAMPLE_FRAGMENT);
        if (params->layers[i].image == GPU_NO_INDEX) graph_put_sampled(graph, &((struct gpu_lens_layer *)layers.data)[i].image, params->images[i]);
    }
    if (params->count.id) graph_add_row(pass, graph_buffer_row(&data.push.count, params->count, GRAPH_READ_WRITE_FRAGMENT));
    static const float black[4] = {0, 0, 0, 1};
    graph_color(pass, target, params->clear ? VK_ATTACHMENT_LOAD_OP_CLEAR : VK_ATTACHMENT_LOAD_OP_LOAD, black);
}

struct reproject_data {
    struct gpu_reproject_push push;
    struct gpu_graphics_params state;
};

static void execute_reproject(const struct graph_context *context, const void *data) {
    const struct reproject_data *d = data;
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &d->push, sizeof d->push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

graph_image reproject_add(gpu_device *device, struct graph *graph, const char *name, const struct gpu_reproject_push *push, graph_image picture, graph_image depth) {
    const struct graph_image_params info = graph_image_info(graph, picture);
    graph_image target = graph_create_image(
        graph, &(struct graph_image_params){.name = graph_name(graph, "%s picture", name), .format = VK_FORMAT_R16G16B16A16_SFLOAT, .width = info.width, .height = info.height});
    struct reproject_data data = {.push = *push};
    data.push.sampler_index = smooth_sampler(device);
    data.push.size = (vec2){(float)info.width, (float)info.height};
    data.state = (struct gpu_graphics_params){.vertex = &shader_screen_vert,
                                              .fragment = &shader_reproject_frag,
                                              .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                              .color_count = 1,
                                              .color_formats = {VK_FORMAT_R16G16B16A16_SFLOAT},
                                              .samples = 1};
    struct graph_pass *pass = graph_add_pass(graph, name, GRAPH_QUEUE_GRAPHICS, execute_reproject, &data, sizeof data);
    graph_use_image(pass, picture, GRAPH_SAMPLE_FRAGMENT);
    graph_add_row(pass, graph_image_row(&data.push.depth, depth, GRAPH_SAMPLE_FRAGMENT));
    graph_color(pass, target, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    return target;
}
