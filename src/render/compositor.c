/* SPDX-License-Identifier: MIT */
/** From the pictures of the eyes to the display of a headset. */
#include "fanal/compositor.h"

#include "base/check.h"
#include "passes/stereo/lens.h"
#include "scene/eye.h"

/* A picture on the device. */
struct kept_image {
    struct gpu_image image;
    uint64_t version;
};

struct fnl_compositor {
    fnl_host host;
    gpu_device *device;
    struct graph *graph;
    fnl_compositor_params params;
    struct compositor_eye {
        struct gpu_image color, depth; /* of the newest frame; no handle: none */
        struct gpu_buffer mesh;        /* vertices, then cells */
        uint32_t cell_count;
    } eyes[2];
    uint32_t source_width, source_height; /* of an eye's picture */
    bool has_depth;
    fnl_rigid_pose head;                  /* for which it was rendered */
    struct kept_image layers[FNL_LAYERS_MAX];
    struct gpu_buffer out, count;         /* read back */
    fnl_compositor_stats stats;
    bool told_of_layers; /* the log knows that one is too near or too far */
};

/* ---- params ---- */

fnl_compositor_params fnl_compositor_params_default(void) {
    fnl_compositor_params params = {.width = 1080, .height = 1080, .eye_count = 2, .trim = true};
    for (uint32_t i = 0; i < 2; i++)
        params.eyes[i] = (fnl_display_eye){.eye = {{{i ? 0.032f : -0.032f, 0, 0}, {0, 0, 0, 1}}, -1, 1, -1, 1},
                                           .left = -1, .right = 1, .down = -1, .up = 1, .visible_radius = INFINITY};
    return params;
}

float fnl_lens_display_edge(const fnl_lens *lens, float edge, bool vertical) {
    if (!lens) return 0;
    const float center = vertical ? lens->center.y : lens->center.x;
    float low = fminf(center, edge) - fabsf(edge - center), high = fmaxf(center, edge) + fabsf(edge - center);
    for (uint32_t i = 0; i < 60; i++) {
        const float middle = 0.5f * (low + high);
        const vec2 at = vertical ? (vec2){lens->center.x, middle} : (vec2){middle, lens->center.y}, bent = lens_bend(lens, at, 1);
        if ((vertical ? bent.y : bent.x) < edge)
            low = middle;
        else
            high = middle;
    }
    return 0.5f * (low + high);
}

static fnl_result check_params(const struct call *call, const fnl_compositor_params *p) {
    TRY(check_count(call, "params->width", p->width, 1, 8192));
    TRY(check_count(call, "params->height", p->height, 1, 8192));
    TRY(check_count(call, "params->eye_count", p->eye_count, 1, 2));
    TRY(check_enum(call, "params->warp", (int64_t)p->warp, FNL_WARP_COUNT, "fnl_warp"));
    for (uint32_t i = 0; i < p->eye_count; i++) {
        const fnl_display_eye *e = &p->eyes[i];
        char name[40];
        snprintf(name, sizeof name, "params->eyes[%u].eye", i);
        TRY(rigid_pose_check(call, name, &e->eye.pose));
        TRY(edges_check(call, name, e->eye.left, e->eye.right, e->eye.down, e->eye.up));
        snprintf(name, sizeof name, "params->eyes[%u]", i);
        TRY(edges_check(call, name, e->left, e->right, e->down, e->up));
        snprintf(name, sizeof name, "params->eyes[%u].lens.k", i);
        TRY(check_floats(call, name, &e->lens.k[0][0], 12, -1e3, 1e3, ""));
        snprintf(name, sizeof name, "params->eyes[%u].lens.center", i);
        TRY(check_floats(call, name, &e->lens.center.x, 2, -1e4, 1e4, ""));
        if (!(e->visible_radius > 0)) return misuse(call, "params->eyes[%u].visible_radius is %g, must be above 0", i, (double)e->visible_radius);
    }
    return FNL_OK;
}

/* ---- life ---- */

static fnl_result create_mesh(fnl_compositor *c, uint32_t index) {
    struct compositor_eye *eye = &c->eyes[index];
    struct mesh {
        struct gpu_lens_vertex vertices[LENS_VERTICES];
        uint32_t cells[LENS_CELLS];
    } *mesh = host_allocate_zero(&c->host, sizeof *mesh);
    if (!mesh) return FNL_ERROR_MEMORY;
    lens_mesh(&c->params.eyes[index], mesh->vertices);
    eye->cell_count = lens_cells(&c->params.eyes[index], mesh->vertices, c->params.trim, mesh->cells);
    c->stats.quads += LENS_CELLS;
    c->stats.quads_drawn += eye->cell_count;
    fnl_result result = gpu_buffer_create(c->device, "lens mesh", sizeof *mesh, GPU_MEMORY_DEVICE, &eye->mesh);
    if (result == FNL_OK) result = gpu_upload_buffer(c->device, &eye->mesh, 0, mesh, sizeof *mesh);
    host_free(&c->host, mesh, sizeof *mesh);
    return result;
}

static fnl_result begin(fnl_compositor *c) {
    const uint64_t bytes = 4ull * c->params.width * c->params.height * c->params.eye_count;
    TRY(graph_create(&c->host, c->device, &c->graph));
    TRY(gpu_buffer_create(c->device, "display", bytes, GPU_MEMORY_READBACK, &c->out));
    TRY(gpu_buffer_create(c->device, "display pixels", 4, GPU_MEMORY_READBACK, &c->count));
    for (uint32_t i = 0; i < c->params.eye_count; i++) {
        fnl_display_eye *eye = &c->params.eyes[i];
        if (c->params.warp == FNL_WARP_OFF) {
            eye->lens = (fnl_lens){.center = eye->lens.center};
            eye->left = eye->eye.left, eye->right = eye->eye.right, eye->down = eye->eye.down, eye->up = eye->eye.up;
        }
        if (c->params.warp == FNL_WARP_MESH) TRY(create_mesh(c, i));
    }
    return FNL_OK;
}

fnl_result fnl_compositor_create(fnl_device *device, const fnl_compositor_params *params, fnl_compositor **out) {
    TRY(check_handle(__func__, "device", device));
    const fnl_host *host = gpu_host(device);
    TRY(check_pointer(CALL(host), "out", out));
    *out = NULL;
    const fnl_compositor_params used = params ? *params : fnl_compositor_params_default();
    TRY(check_params(CALL(host), &used));
    fnl_compositor *c = host_allocate_zero(host, sizeof *c);
    if (!c) return FNL_ERROR_MEMORY;
    c->host = *host;
    c->device = device;
    c->params = used;
    fnl_result result = begin(c);
    if (result != FNL_OK) fnl_compositor_destroy(&c);
    *out = c;
    return result;
}

static void drop(fnl_compositor *c, struct gpu_image *image) {
    if (image->handle) gpu_image_destroy(c->device, image);
    *image = (struct gpu_image){0};
}

void fnl_compositor_destroy(fnl_compositor **handle) {
    fnl_compositor *c = handle ? *handle : NULL;
    if (!c) return;
    gpu_wait_idle(c->device);
    graph_destroy(&c->graph);
    for (uint32_t i = 0; i < 2; i++) {
        drop(c, &c->eyes[i].color);
        drop(c, &c->eyes[i].depth);
        gpu_buffer_destroy(c->device, &c->eyes[i].mesh);
    }
    for (uint32_t i = 0; i < FNL_LAYERS_MAX; i++) drop(c, &c->layers[i].image);
    gpu_buffer_destroy(c->device, &c->out);
    gpu_buffer_destroy(c->device, &c->count);
    gpu_wait_idle(c->device);
    fnl_host host = c->host;
    host_free(&host, c, sizeof *c);
    *handle = NULL;
}

/* ---- pictures ---- */

static fnl_result send(fnl_compositor *c, struct gpu_image *image, const char *name, VkFormat format, uint32_t width, uint32_t height, const void *pixels) {
    drop(c, image); /* freed once the frames in flight are over */
    const struct gpu_image_params params = {.name = name,
                                            .format = format,
                                            .width = width,
                                            .height = height,
                                            .layers = 1,
                                            .mips = 1,
                                            .samples = 1,
                                            .srgb_view = format == VK_FORMAT_R8G8B8A8_UNORM,
                                            .usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT};
    TRY(gpu_image_create(c->device, &params, image));
    return gpu_upload_image(c->device, image, pixels, (uint64_t)width * height * gpu_texel_bytes(format), false, false);
}

static fnl_result check_picture(const struct call *call, const char *name, const fnl_image *image, fnl_pixel_format format) {
    if (!image->pixels) return misuse(call, "%s has no pixels", name);
    if (image->format != format) return misuse(call, "%s is not %s", name, format == FNL_PIXEL_FORMAT_RGBA8 ? "RGBA8" : "RGBA32F");
    if (image->width >= 1 && image->width <= 16384 && image->height >= 1 && image->height <= 32768) return FNL_OK;
    return misuse(call, "%s has %u x %u pixels, must have 1 .. 16384 in each direction", name, image->width, image->height);
}

static fnl_result send_depth(fnl_compositor *c, uint32_t eye, const fnl_image *normal) {
    const uint64_t count = (uint64_t)c->source_width * c->source_height;
    float *depth = host_allocate(&c->host, count * sizeof *depth);
    if (!depth) return FNL_ERROR_MEMORY;
    const float *from = (const float *)normal->pixels + 4 * eye * count;
    for (uint64_t i = 0; i < count; i++) depth[i] = from[4 * i + 3];
    fnl_result result = send(c, &c->eyes[eye].depth, "eye depth", VK_FORMAT_R32_SFLOAT, c->source_width, c->source_height, depth);
    host_free(&c->host, depth, count * sizeof *depth);
    return result;
}

fnl_result fnl_compositor_submit(fnl_compositor *c, const fnl_eye_pictures *pictures) {
    TRY(check_handle(__func__, "compositor", c));
    const struct call *call = CALL(&c->host);
    TRY(check_pointer(call, "pictures", pictures));
    TRY(check_pointer(call, "pictures->color", pictures->color));
    const fnl_image *color = pictures->color, *normal = pictures->normal;
    TRY(check_picture(call, "pictures->color", color, FNL_PIXEL_FORMAT_RGBA8));
    if (normal) TRY(check_picture(call, "pictures->normal", normal, FNL_PIXEL_FORMAT_RGBA32F));
    if (color->height % c->params.eye_count) return misuse(call, "pictures->color has %u rows, which %u eyes do not divide", color->height, c->params.eye_count);
    if (normal && (normal->width != color->width || normal->height != color->height))
        return misuse(call, "pictures->normal has %u x %u pixels, but color %u x %u", normal->width, normal->height, color->width, color->height);
    TRY(rigid_pose_check(call, "pictures->head", &pictures->head));
    c->source_width = color->width;
    c->source_height = color->height / c->params.eye_count;
    c->has_depth = false;
    for (uint32_t i = 0; i < c->params.eye_count; i++) {
        const char *own = (const char *)color->pixels + 4ull * i * c->source_width * c->source_height;
        TRY(send(c, &c->eyes[i].color, "eye picture", VK_FORMAT_R8G8B8A8_UNORM, c->source_width, c->source_height, own));
        if (normal) TRY(send_depth(c, i, normal));
    }
    TRY(gpu_upload_flush(c->device));
    c->has_depth = normal;
    c->head = pictures->head;
    c->stats.submitted++;
    c->stats.repeated = 0;
    return FNL_OK;
}

/* ---- composing ---- */

static fnl_result check_layers(const struct call *call, const fnl_composition *composition) {
    TRY(check_count(call, "layer_count", composition->layer_count, 0, FNL_LAYERS_MAX));
    if (composition->layer_count) TRY(check_pointer(call, "layers", composition->layers));
    for (uint32_t i = 0; i < composition->layer_count; i++) {
        const fnl_layer *layer = &composition->layers[i];
        char name[32];
        snprintf(name, sizeof name, "layers[%u].image", i);
        TRY(check_pointer(call, name, layer->image));
        TRY(check_picture(call, name, layer->image, FNL_PIXEL_FORMAT_RGBA8));
        snprintf(name, sizeof name, "layers[%u].pose", i);
        TRY(rigid_pose_check(call, name, &layer->pose));
        snprintf(name, sizeof name, "layers[%u].width", i);
        TRY(check_above(call, name, (double)layer->width, 0, 1e4, " metres"));
        snprintf(name, sizeof name, "layers[%u].height", i);
        TRY(check_above(call, name, (double)layer->height, 0, 1e4, " metres"));
    }
    return FNL_OK;
}

/* Real-Time Rendering, 4th ed., chapter 21: where objects that people look at for long are comfortable. */
static void lint_layers(fnl_compositor *c, const fnl_composition *composition) {
    c->stats.layers_uncomfortable = 0;
    for (uint32_t i = 0; i < composition->layer_count; i++) {
        const fnl_layer *layer = &composition->layers[i];
        const vec3 at = layer->head_locked ? layer->pose.position : vec3_sub(layer->pose.position, composition->head.position);
        const float distance = vec3_length(at);
        if (distance >= 0.75f && distance <= 3.5f) continue;
        c->stats.layers_uncomfortable++;
        if (c->told_of_layers) continue;
        c->told_of_layers = true;
        log_warning(&c->host, "layers[%u] is %g m away from the head: eyes look at things 0.75 to 3.5 m away without strain", i, (double)distance);
    }
}

static fnl_result send_layers(fnl_compositor *c, const fnl_composition *composition) {
    for (uint32_t i = 0; i < composition->layer_count; i++) {
        const fnl_layer *layer = &composition->layers[i];
        struct kept_image *kept = &c->layers[i];
        if (kept->image.handle && kept->version == layer->version) continue;
        TRY(send(c, &kept->image, "layer", VK_FORMAT_R8G8B8A8_UNORM, layer->image->width, layer->image->height, layer->image->pixels));
        kept->version = layer->version;
    }
    return gpu_upload_flush(c->device);
}

static mat4 matrix_of(const fnl_rigid_pose *pose) { return mat4_from_trs(pose->position, quat_normalize(pose->rotation), vec3_make(1, 1, 1)); }

static mat4 inverse_of(const mat4 *m) {
    mat4 inverse;
    mat4_inverse(m, &inverse);
    return inverse;
}

/* What one eye shows, from the last to the first: rendered picture, layers. */
struct stack {
    struct gpu_lens_layer layers[FNL_LAYERS_MAX + 1];
    graph_image images[FNL_LAYERS_MAX + 1];
    uint32_t count;
};

static vec4 rendered_edges(const fnl_eye *eye) { return (vec4){eye->left, eye->right, eye->down, eye->up}; }

static graph_image import(fnl_compositor *c, const struct gpu_image *image) {
    const VkImageLayout layout = VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL;
    return graph_import_image(c->graph, image, layout, layout);
}

static void put_picture(fnl_compositor *c, uint32_t index, const fnl_composition *composition, const mat4 *world, struct stack *stack) {
    const struct compositor_eye *eye = &c->eyes[index];
    if (!eye->color.handle) return;
    const fnl_eye *of = &c->params.eyes[index].eye;
    const mat4 then = mat4_mul(matrix_of(&c->head), matrix_of(&of->pose)), to_then = inverse_of(&then), turn = mat4_mul(to_then, *world), still = mat4_identity();
    graph_image picture = import(c, &eye->color);
    const bool off = composition->reprojection == FNL_REPROJECTION_OFF, moves = composition->reprojection == FNL_REPROJECTION_DEPTH && c->has_depth;
    struct gpu_lens_layer layer = lens_picture(rendered_edges(of), off || moves ? &still : &turn);
    layer.image = eye->color.srgb_index;
    if (moves) {
        const mat4 from_world = inverse_of(world);
        const struct gpu_reproject_push push = {.to_new = mat4_mul(from_world, then), .rendered = rendered_edges(of), .picture = eye->color.srgb_index};
        picture = reproject_add(c->device, c->graph, graph_name(c->graph, "reproject %u", index), &push, picture, import(c, &eye->depth));
        layer.image = GPU_NO_INDEX;
    }
    stack->layers[stack->count] = layer;
    stack->images[stack->count++] = picture;
}

static void put_layers(fnl_compositor *c, const fnl_composition *composition, const mat4 *world, const mat4 *in_head, struct stack *stack) {
    const mat4 from_world = inverse_of(world), from_head = inverse_of(in_head);
    for (uint32_t i = 0; i < composition->layer_count; i++) {
        const fnl_layer *layer = &composition->layers[i];
        const mat4 place = mat4_mul(layer->head_locked ? from_head : from_world, matrix_of(&layer->pose));
        struct gpu_lens_layer *put = &stack->layers[stack->count];
        if (!lens_quad(&place, layer->width, layer->height, put)) continue;
        put->image = c->layers[i].image.srgb_index;
        stack->images[stack->count++] = import(c, &c->layers[i].image);
    }
}

/* Blends all into one picture as it was rendered, which is then the only layer. */
static void flatten(fnl_compositor *c, uint32_t index, struct stack *stack) {
    const fnl_display_eye *eye = &c->params.eyes[index];
    const uint32_t width = c->source_width ? c->source_width : c->params.width, height = c->source_height ? c->source_height : c->params.height;
    fnl_display_eye plain = {.eye = eye->eye, .left = eye->eye.left, .right = eye->eye.right, .down = eye->eye.down, .up = eye->eye.up, .visible_radius = INFINITY};
    graph_image target = graph_create_image(c->graph, &(struct graph_image_params){.name = graph_name(c->graph, "blended %u", index),
                                                                                 .format = VK_FORMAT_R16G16B16A16_SFLOAT,
                                                                                 .width = width,
                                                                                 .height = height});
    struct lens_params params = {.name = graph_name(c->graph, "blend layers %u", index),
                                 .eye = lens_eye(&plain, (vec2){(float)width, (float)height}),
                                 .layers = stack->layers,
                                 .layer_count = stack->count,
                                 .width = width,
                                 .clear = true};
    memcpy(params.images, stack->images, sizeof params.images);
    lens_add(c->device, c->graph, &params, target);
    const mat4 still = mat4_identity();
    stack->layers[0] = lens_picture(rendered_edges(&eye->eye), &still);
    stack->layers[0].image = GPU_NO_INDEX;
    stack->images[0] = target;
    stack->count = 1;
}

static void add_eye(fnl_compositor *c, uint32_t index, const fnl_composition *composition, graph_buffer count, graph_image target) {
    const fnl_display_eye *eye = &c->params.eyes[index];
    const mat4 in_head = matrix_of(&eye->eye.pose), world = mat4_mul(matrix_of(&composition->head), in_head);
    struct stack stack = {.count = 0};
    put_picture(c, index, composition, &world, &stack);
    put_layers(c, composition, &world, &in_head, &stack);
    if (composition->layers_first && composition->layer_count > 0) flatten(c, index, &stack);
    const struct compositor_eye *own = &c->eyes[index];
    struct lens_params params = {.name = graph_name(c->graph, "lens %u", index),
                                 .eye = lens_eye(eye, (vec2){(float)c->source_width, (float)c->source_height}),
                                 .layers = stack.layers,
                                 .layer_count = stack.count,
                                 .vertices = own->mesh.handle ? own->mesh.address : 0,
                                 .cells = own->mesh.address + LENS_VERTICES * sizeof(struct gpu_lens_vertex),
                                 .cell_count = own->cell_count,
                                 .count = count,
                                 .x = index * c->params.width,
                                 .width = c->params.width,
                                 .view = (uint32_t)composition->view,
                                 .encode = true,
                                 .clear = index == 0};
    memcpy(params.images, stack.images, sizeof params.images);
    lens_add(c->device, c->graph, &params, target);
}

struct read_data {
    graph_image picture;
    graph_buffer out, count, counted;
};

static void execute_read(const struct graph_context *context, const void *data) {
    const struct read_data *d = data;
    gpu_copy_image_to_buffer(context->commands, graph_get_image(context, d->picture), graph_get_buffer(context, d->out), 0);
    if (d->count.id) gpu_copy_buffer(context->commands, graph_get_buffer(context, d->count), 0, graph_get_buffer(context, d->counted), 0, 4);
}

static fnl_result declare(fnl_compositor *c, const fnl_composition *composition) {
    struct graph *graph = c->graph;
    graph_begin(graph);
    graph_image target = graph_create_image(graph, &(struct graph_image_params){.name = "display",
                                                                              .format = VK_FORMAT_R8G8B8A8_UNORM,
                                                                              .width = c->params.width * c->params.eye_count,
                                                                              .height = c->params.height});
    struct read_data read = {.picture = target, .out = graph_import_buffer(graph, "display bytes", &c->out)};
    if (c->params.count) {
        read.count = graph_create_buffer(graph, "display count", 4);
        read.counted = graph_import_buffer(graph, "display counted", &c->count);
        graph_add_clear(graph, "display count clear", GRAPH_QUEUE_GRAPHICS, (struct graph_clear){.buffers = {read.count}});
    }
    for (uint32_t i = 0; i < c->params.eye_count; i++) add_eye(c, i, composition, read.count, target);
    struct graph_pass *pass = graph_add_pass(graph, "read display", GRAPH_QUEUE_GRAPHICS, execute_read, &read, sizeof read);
    graph_use_image(pass, read.picture, GRAPH_COPY_FROM);
    graph_use_buffer(pass, read.out, GRAPH_COPY_TO);
    struct graph_pass *host = graph_add_pass(graph, "display to host", GRAPH_QUEUE_GRAPHICS, NULL, NULL, 0);
    graph_keep(host);
    graph_use_buffer(host, read.out, GRAPH_READ_HOST);
    if (c->params.count) {
        graph_use_buffer(pass, read.count, GRAPH_COPY_FROM);
        graph_use_buffer(pass, read.counted, GRAPH_COPY_TO);
        graph_use_buffer(host, read.counted, GRAPH_READ_HOST);
    }
    return graph_compile(graph);
}

static fnl_result run(fnl_compositor *c, const fnl_composition *composition) {
    TRY(gpu_frame_begin(c->device));
    fnl_result result = declare(c, composition);
    if (result != FNL_OK) {
        gpu_frame_end(c->device, NULL, 0, NULL);
        return result;
    }
    TRY(graph_execute_frame(c->graph, NULL));
    return gpu_frame_wait(c->device, gpu_frame_number(c->device));
}

fnl_result fnl_compositor_compose(fnl_compositor *c, const fnl_composition *composition, fnl_image *out) {
    TRY(check_handle(__func__, "compositor", c));
    const struct call *call = CALL(&c->host);
    TRY(check_pointer(call, "composition", composition));
    TRY(check_pointer(call, "out", out));
    *out = (fnl_image){0};
    TRY(rigid_pose_check(call, "head", &composition->head));
    TRY(check_enum(call, "reprojection", (int64_t)composition->reprojection, FNL_REPROJECTION_COUNT, "fnl_reprojection"));
    TRY(check_enum(call, "view", (int64_t)composition->view, FNL_DISPLAY_VIEW_COUNT, "fnl_display_view"));
    TRY(check_layers(call, composition));
    lint_layers(c, composition);
    TRY(send_layers(c, composition));
    TRY(run(c, composition));
    const uint64_t size = c->out.size;
    void *pixels = host_allocate(&c->host, size);
    if (!pixels) return FNL_ERROR_MEMORY;
    memcpy(pixels, c->out.mapped, size);
    if (c->params.count) c->stats.pixels_shaded = *(const uint32_t *)c->count.mapped;
    c->stats.composed++;
    c->stats.repeated += c->stats.submitted > 0;
    *out = (fnl_image){c->params.width * c->params.eye_count, c->params.height, FNL_PIXEL_FORMAT_RGBA8, pixels};
    return FNL_OK;
}

fnl_result fnl_compositor_query_stats(const fnl_compositor *c, fnl_compositor_stats *out) {
    TRY(check_handle(__func__, "compositor", c));
    TRY(check_pointer(CALL(&c->host), "out", out));
    *out = c->stats;
    return FNL_OK;
}
