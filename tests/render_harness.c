/* SPDX-License-Identifier: MIT */
#include "tests/render_test.h"

#include "tests/stand_in.h"

#include <time.h>

/* ---- host and device ---- */

static void log_line(void *user, fnl_log_level level, const char *line) {
    struct test_memory *memory = user;
    static atomic_int printed; /* a failed test leaves objects behind: the first lines say enough */
    bool validation = strncmp(line, "validation", 10) == 0;
    if (validation ? atomic_fetch_add(&printed, 1) < 5 : memory->loud && level >= FNL_LOG_WARNING)
        print_error("%.400s\n", line);
    if (level == FNL_LOG_WARNING) atomic_fetch_add(&memory->warnings, 1);
    if (level < FNL_LOG_ERROR) return;
    atomic_fetch_add(&memory->errors, 1);
    snprintf(memory->last_error, sizeof memory->last_error, "%s", line);
}

fnl_host test_host(struct test_memory *memory) {
    fnl_host host = fnl_host_default();
    host.user = memory;
    host.reallocate = test_memory_reallocate;
    host.log = log_line;
    host.thread_count = 2;
    return host;
}

static fnl_device *create_device(struct test_memory *memory, uint32_t thread_count) {
    fnl_device_params params = fnl_device_params_default();
    params.host = test_host(memory);
    params.host.thread_count = thread_count;
    params.validate = true;
    params.cache_folder = "";
    fnl_device *device;
    assert_int_equal(fnl_device_create(&params, &device), FNL_OK);
    return device;
}

fnl_device *test_device_create(struct test_memory *memory) { return create_device(memory, 2); }

void test_device_destroy(fnl_device **device) {
    uint64_t messages = fnl_device_validation_count(*device);
    fnl_device_destroy(device);
    assert_null(*device);
    assert_int_equal(messages, 0);
}

fnl_device *test_device;
struct test_memory test_device_memory;
static uint64_t messages_seen;
static void forget_kept(void);
static struct stage open_stages[8]; /* those of a test that fails are closed after it */

static bool shares_device; /* the device outlasts a group of tests */

static int begin(bool loud) {
    test_device_memory.loud = loud;
    if (!test_device) test_device = create_device(&test_device_memory, 4);
    return 0;
}

int test_group_begin(void **state) {
    UNUSED(state);
    return begin(false);
}

int harness_begin(void **state) {
    UNUSED(state);
    return begin(true);
}

void harness_share_device(void) { shares_device = true; }

int harness_check(void **state) {
    UNUSED(state);
    for (uint32_t i = 0; i < COUNT_OF(open_stages); i++)
        if (open_stages[i].scene) stage_close(&open_stages[i]);
    forget_kept();
    uint64_t messages = fnl_device_validation_count(test_device);
    bool silent = messages == messages_seen;
    if (!silent) print_error("%llu validation messages\n", (unsigned long long)(messages - messages_seen));
    messages_seen = messages;
    return silent ? 0 : -1;
}

int harness_end(void **state) {
    bool good = gpu_wait_idle(test_device) == FNL_OK;
    good = harness_check(state) == 0 && good; /* also what tests that do not check left behind */
    return (shares_device || harness_finish()) && good ? 0 : -1;
}

bool harness_finish(void) {
    if (!test_device) return true;
    bool good = fnl_device_validation_count(test_device) == 0;
    fnl_device_destroy(&test_device);
    long long left = test_device_memory.live_bytes;
    if (left != 0) print_error("%lld bytes of host memory are left\n", left);
    if (test_device_memory.wrong_sizes) print_error("blocks came back with a wrong size\n");
    return good && left == 0 && test_device_memory.wrong_sizes == 0;
}

int test_group_end(void **state) { return harness_end(state); }

struct renderer_tests *harness_hooks(fnl_renderer *renderer) {
    if (!renderer->tests) renderer->tests = host_allocate_zero(&renderer->host, sizeof *renderer->tests);
    assert_non_null(renderer->tests);
    return renderer->tests;
}

fnl_device *harness_device(void) { return test_device; }

/* ---- scenes ---- */

fnl_scene *test_scene(void) {
    fnl_host host = test_host(&test_device_memory);
    fnl_scene *scene;
    assert_int_equal(scene_create(&host, "test", &scene), FNL_OK);
    return scene;
}

fnl_scene *test_load(const char *name, bool shared) {
    fnl_host host = test_host(&test_device_memory);
    fnl_load_params params = fnl_load_params_default();
    const char *path = shared ? stand_in_sample(name) : name;
    unsigned char *model = path ? NULL : stand_in_model(name, &params.size);
    fnl_scene *scene;
    if (!path && !model) fail_msg("%s is missing, and nothing replaces it", name);
    params.data = model;
    assert_int_equal(scene_load_plain(&host, path ? path : name, &params, &scene), FNL_OK);
    free(model);
    return scene;
}

fnl_material_id test_material(fnl_scene *scene, const fnl_material_params *params) {
    fnl_material_id id;
    assert_int_equal(fnl_scene_add_material(scene, params, &id), FNL_OK);
    return id;
}

static uint32_t add_mesh(fnl_scene *scene, struct scene_primitive *primitive) {
    assert_int_equal(mesh_complete(&scene->arena, primitive), FNL_OK);
    uint32_t mesh = scene_add_mesh(scene, "", primitive, 1);
    assert_int_not_equal(mesh, SCENE_NONE);
    return mesh;
}

uint32_t test_quad_mesh(fnl_scene *scene, uint32_t material) {
    static const vec3 positions[4] = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}},
                      normals[4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
    static const vec4 tangents[4] = {{1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}, {1, 0, 0, 1}};
    static const vec2 uv[4] = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
    struct scene_primitive primitive = {.material = material,
                                        .vertex_count = 4,
                                        .index_count = 6,
                                        .indices = indices,
                                        .positions = positions,
                                        .normals = normals,
                                        .tangents = tangents,
                                        .uv = {uv, NULL}};
    return add_mesh(scene, &primitive);
}

uint32_t test_sphere_mesh(fnl_scene *scene, uint32_t material, uint32_t rings) {
    uint32_t columns = rings * 2, vertex_count = (rings + 1) * (columns + 1), index_count = rings * columns * 6;
    vec3 *positions = ARENA_ARRAY(&scene->arena, vec3, vertex_count);
    vec2 *uv = ARENA_ARRAY(&scene->arena, vec2, vertex_count);
    uint32_t *indices = ARENA_ARRAY(&scene->arena, uint32_t, index_count), at = 0;
    for (uint32_t r = 0; r <= rings; r++)
        for (uint32_t c = 0; c <= columns; c++) {
            float theta = PI * (float)r / (float)rings, phi = 2 * PI * (float)c / (float)columns;
            uint32_t v = r * (columns + 1) + c;
            positions[v] = (vec3){sinf(theta) * sinf(phi), cosf(theta), sinf(theta) * cosf(phi)};
            uv[v] = (vec2){(float)c / (float)columns, (float)r / (float)rings};
            if (r == rings || c == columns) continue;
            uint32_t quad[6] = {v, v + columns + 1, v + columns + 2, v, v + columns + 2, v + 1};
            memcpy(indices + at, quad, sizeof quad);
            at += 6;
        }
    struct scene_primitive primitive = {.material = material,
                                        .vertex_count = vertex_count,
                                        .index_count = index_count,
                                        .indices = indices,
                                        .positions = positions,
                                        .normals = positions,
                                        .uv = {uv, NULL}};
    return add_mesh(scene, &primitive);
}

uint32_t test_place(fnl_scene *scene, uint32_t mesh, vec3 position, vec3 scale) {
    mat4 matrix = mat4_from_trs(position, quat_identity(), scale);
    uint32_t node = scene_add_node(scene, "", SCENE_NONE, &matrix, mesh);
    assert_int_not_equal(node, SCENE_NONE);
    return node;
}

struct scene_material test_unlit(float r, float g, float b) {
    struct scene_material material = scene_material_default();
    material.unlit = true;
    material.base_color = (vec4){r, g, b, 1};
    return material;
}

fnl_light_params test_point(vec3 position, float intensity, float range) {
    fnl_light_params light = fnl_light_params_default();
    light.position = position;
    light.intensity = intensity;
    light.range = range;
    return light;
}

fnl_camera test_front_camera(void) {
    fnl_camera camera = fnl_camera_default();
    camera.position = (vec3){0, 0, 5};
    camera.target = (vec3){0, 0, 0};
    camera.orthographic = true;
    camera.vertical_extent = 2;
    camera.near_distance = 0.5f;
    camera.far_distance = 20;
    return camera;
}

fnl_frame test_frame(uint32_t outputs) {
    fnl_frame frame = frame_plain();
    frame.width = frame.height = 64;
    frame.camera = test_front_camera();
    frame.shading = FNL_SHADING_FORWARD;
    frame.lists = FNL_LISTS_ALL;
    frame.exposure = FNL_EXPOSURE_NONE;
    frame.tonemap = FNL_TONEMAP_NONE;
    frame.outputs = outputs;
    frame.timers = false;
    frame.record_threads = 1;
    return frame;
}

/* ---- shaders ---- */

uint32_t test_count_operations(const struct gpu_shader *shader, uint32_t first, uint32_t last) {
    const fnl_host host = fnl_host_default();
    uint32_t count = 0, *code = gpu_shader_code(&host, shader);
    assert_non_null(code);
    for (size_t i = 5; i < shader->size / 4; i += code[i] >> 16) {
        uint32_t operation = code[i] & 0xffff;
        count += operation >= first && operation <= last;
        assert_true(code[i] >> 16 > 0);
    }
    host_free(&host, code, shader->size);
    return count;
}

/* ---- pictures ---- */

fnl_renderer *test_renderer(fnl_scene *scene) {
    fnl_renderer *renderer;
    void **shared = gpu_shared(test_device), *before = *shared;
    *shared = NULL; /* it finds no other's */
    const fnl_result result = fnl_renderer_create(test_device, scene, &renderer);
    if (before) {
        struct device_scene *last = before;
        while (last->next) last = last->next;
        last->next = *shared; /* behind that which others of the scene may come to share */
        *shared = before;
    }
    assert_int_equal(result, FNL_OK);
    return renderer;
}

void test_render_frame(fnl_renderer *renderer, const fnl_frame *frame) {
    assert_int_equal(fnl_renderer_render(renderer, frame), FNL_OK);
}

fnl_image test_read(fnl_renderer *renderer, fnl_output output) {
    fnl_image image;
    assert_int_equal(fnl_renderer_read(renderer, output, &image), FNL_OK);
    return image;
}

fnl_image test_render(fnl_scene *scene, const fnl_frame *frame, fnl_output output) {
    fnl_renderer *renderer = test_renderer(scene);
    test_render_frame(renderer, frame);
    fnl_image image = test_read(renderer, output);
    fnl_renderer_destroy(&renderer);
    return image;
}

void free_picture(fnl_image *image) {
    fnl_host host = test_host(&test_device_memory);
    fnl_image_free(&host, image);
}

const float *test_pixel(const fnl_image *image, uint32_t x, uint32_t y) {
    assert_int_equal(image->format, FNL_PIXEL_FORMAT_RGBA32F);
    assert_true(x < image->width && y < image->height);
    return (const float *)image->pixels + ((size_t)y * image->width + x) * 4;
}

const uint8_t *test_pixel8(const fnl_image *image, uint32_t x, uint32_t y) {
    assert_int_equal(image->format, FNL_PIXEL_FORMAT_RGBA8);
    assert_true(x < image->width && y < image->height);
    return (const uint8_t *)image->pixels + ((size_t)y * image->width + x) * 4;
}

void assert_pixel(const fnl_image *image, uint32_t x, uint32_t y, double r, double g, double b, double tolerance) {
    const float *p = test_pixel(image, x, y);
    if (fabs(p[0] - r) <= tolerance && fabs(p[1] - g) <= tolerance && fabs(p[2] - b) <= tolerance) return;
    fail_msg("pixel %u, %u is %.9g %.9g %.9g, expected %.9g %.9g %.9g within %g", x, y, (double)p[0], (double)p[1],
             (double)p[2], r, g, b, tolerance);
}

double test_difference(const fnl_image *a, const fnl_image *b) {
    assert_true(a->width == b->width && a->height == b->height && a->format == b->format);
    double max = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height * 4; i++) {
        double x, y;
        if (a->format == FNL_PIXEL_FORMAT_RGBA8) {
            x = ((const uint8_t *)a->pixels)[i];
            y = ((const uint8_t *)b->pixels)[i];
        } else {
            x = ((const float *)a->pixels)[i];
            y = ((const float *)b->pixels)[i];
        }
        if (isnan(x) || isnan(y)) return INFINITY;
        max = fmax(max, fabs(x - y));
    }
    return max;
}

bool test_equal(const fnl_image *a, const fnl_image *b) { return count_differing(a, b) == 0; }

/* ---- stages ---- */

struct stage stage_open_scene(fnl_scene *scene) {
    struct stage stage = {.scene = scene, .frame = frame_plain()};
    stage.frame.lists = FNL_LISTS_CLUSTERED;
    uint32_t place = 0;
    while (place < COUNT_OF(open_stages) && open_stages[place].scene) place++;
    assert_true(place < COUNT_OF(open_stages));
    assert_int_equal(fnl_renderer_create(test_device, scene, &stage.renderer), FNL_OK);
    harness_hooks(stage.renderer)->poison = true; /* nobody may read what nobody wrote */
    open_stages[place] = stage;
    stage.frame.width = 113;
    stage.frame.height = 65;
    stage.frame.exposure = FNL_EXPOSURE_EV;
    stage.frame.ev = 5;
    stage.frame.outputs = FNL_OUTPUT_COLOR | FNL_OUTPUT_RADIANCE;
    stage.frame.timers = false;
    fnl_result result = fnl_scene_count(scene, FNL_ENTITY_CAMERA)
                            ? fnl_scene_query_camera(scene, 0, &stage.frame.camera)
                            : fnl_scene_query_framing_camera(scene, 113 / 65.0f, &stage.frame.camera);
    assert_int_equal(result, FNL_OK);
    return stage;
}

struct stage stage_open(const char *source, uint32_t scattered) {
    fnl_scene *scene = test_load(source, strncmp(source, "builtin:", 8) != 0);
    assert_int_equal(fnl_scene_scatter_lights(scene, scattered, 1), FNL_OK);
    return stage_open_scene(scene);
}

void harness_set_pool(struct stage *stage, uint32_t entries) {
    stage->renderer->lists.pool_capacity = entries;
    harness_hooks(stage->renderer)->fixed_pools = true;
    memset(stage->renderer->slots.views, 0, sizeof stage->renderer->slots.views);
}

void stage_close(struct stage *stage) {
    fnl_scene *scene = stage->scene;
    fnl_renderer_destroy(&stage->renderer);
    fnl_scene_destroy(&stage->scene);
    for (uint32_t i = 0; i < COUNT_OF(open_stages); i++)
        if (open_stages[i].scene == scene) open_stages[i] = (struct stage){0};
}

/* ---- numbers ---- */

static struct kept {
    struct kept *next;
    max_align_t bytes[];
} * all_kept;

static void forget_kept(void) {
    for (struct kept *next; all_kept; all_kept = next) {
        next = all_kept->next;
        free(all_kept);
    }
}

static void *keep(const void *data, size_t size) {
    struct kept *kept = malloc(sizeof *kept + size);
    assert_non_null(kept);
    if (size) memcpy(kept->bytes, data, size);
    kept->next = all_kept;
    all_kept = kept;
    return kept->bytes;
}

static void keep_stats(fnl_frame_stats *stats) {
    stats->counters = keep(stats->counters, stats->counter_count * sizeof *stats->counters);
    fnl_frame_stats *views = keep(stats->views, stats->view_count * sizeof *stats->views);
    for (uint32_t i = 0; i < stats->view_count; i++) keep_stats(&views[i]);
    stats->views = stats->view_count ? views : NULL;
}

fnl_frame_stats harness_stats(fnl_renderer *renderer) {
    fnl_frame_stats stats;
    assert_int_equal(fnl_renderer_query_stats(renderer, &stats), FNL_OK);
    keep_stats(&stats);
    return stats;
}

bool has_counter(const fnl_frame_stats *stats, const char *key) {
    fnl_counter row;
    bool known = false;
    for (uint32_t i = 0; fnl_counter_query(i, &row); i++) known = known || strcmp(row.key, key) == 0;
    if (!known) fail_msg("there is no counter %s", key);
    return fnl_counter_find(stats, key);
}

uint64_t counter(const fnl_frame_stats *stats, const char *key) {
    if (!has_counter(stats, key)) fail_msg("the frame does not have the counter %s", key);
    return fnl_counter_find(stats, key)->value;
}

uint64_t counter_of(fnl_renderer *renderer, const char *key) {
    fnl_frame_stats stats = harness_stats(renderer);
    return counter(&stats, key);
}

/* ---- shots ---- */

struct shot stage_shoot(struct stage *stage, const fnl_frame *frame) {
    struct shot shot = {0};
    assert_int_equal(fnl_renderer_render(stage->renderer, frame), FNL_OK);
    fnl_image *images[] = {&shot.color, &shot.radiance, &shot.surface, &shot.normal, &shot.position};
    for (uint32_t i = 0; i < COUNT_OF(images); i++)
        if (frame->outputs & 1u << i)
            assert_int_equal(fnl_renderer_read(stage->renderer, (fnl_output)(1u << i), images[i]), FNL_OK);
    shot.stats = harness_stats(stage->renderer);
    shot.stats.passes = NULL;
    shot.stats.pass_count = 0;
    assert_int_equal(shot.stats.lights_dropped, 0);
    return shot;
}

void shot_free(struct shot *shot) {
    fnl_image *images[] = {&shot->color, &shot->radiance, &shot->surface, &shot->normal, &shot->position};
    for (uint32_t i = 0; i < COUNT_OF(images); i++) fnl_image_free(gpu_host(test_device), images[i]);
}

bool harness_tries(fnl_shading shading, fnl_light_lists lists, uint32_t step) {
    if (!fnl_shading_supports(shading, lists, 1)) return false;
    if (shading == FNL_SHADING_DEFERRED || ((uint32_t)lists + (uint32_t)shading) % step == 0) return true;
    return shading < FNL_SHADING_DEFERRED && !fnl_shading_supports(FNL_SHADING_DEFERRED, lists, 1);
}

uint64_t count_differing(const fnl_image *a, const fnl_image *b) {
    if (a->width != b->width || a->height != b->height || a->format != b->format || !a->pixels || !b->pixels)
        return UINT64_MAX;
    size_t size = fnl_pixel_size(a->format);
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++)
        count += memcmp((const char *)a->pixels + i * size, (const char *)b->pixels + i * size, size) != 0;
    return count;
}

int greatest_difference(const fnl_image *a, const fnl_image *b) {
    assert_true(a->pixels && b->pixels && a->format == FNL_PIXEL_FORMAT_RGBA8);
    return (int)test_difference(a, b);
}

uint64_t count_beyond(const fnl_image *a, const fnl_image *b, int allowed) {
    assert_true(a->width == b->width && a->height == b->height && a->pixels && b->pixels);
    assert_true(a->format == FNL_PIXEL_FORMAT_RGBA8 && b->format == FNL_PIXEL_FORMAT_RGBA8);
    const uint8_t *p = a->pixels, *q = b->pixels;
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; i++, p += 4, q += 4) {
        bool beyond = false;
        for (int k = 0; k < 4; k++) beyond = beyond || abs(p[k] - q[k]) > allowed;
        count += beyond;
    }
    return count;
}

uint64_t count_broken(const fnl_image *image) {
    assert_int_equal(image->format, FNL_PIXEL_FORMAT_RGBA32F);
    const fnl_vec4 *p = image->pixels;
    uint64_t count = 0;
    for (size_t i = 0; i < (size_t)image->width * image->height; i++)
        count += !(isfinite(p[i].x) && isfinite(p[i].y) && isfinite(p[i].z) && p[i].x >= 0 && p[i].y >= 0 && p[i].z >= 0);
    return count;
}
