/* SPDX-License-Identifier: MIT */
/**
 * Images that are decoded in the background while frames go on (fnl_load_params.async). The host of the device holds the jobs of other
 * threads back until the test lets them run: nothing here depends on how long decoding takes.
 */
#include "fanal/options.h"
#include "tests/gltf_test_file.h"
#include "tests/render_harness.h"
#include "tests/texture_file.h"

#include <dlfcn.h>
#include <pthread.h>
#include <unistd.h>

extern fnl_device *test_device; /* the harness's, with a host of ours */

/* ---- the host ---- */

enum { OPEN = 1 << 20 };

static struct {
    struct test_log log;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    pthread_t main;
    int permits;      /* jobs of other threads that may still run */
    int began, done;  /* … so far */
    int handed;       /* jobs of the main thread so far, which any threads could have run */
    size_t fail_size; /* of a block that other threads cannot have; 0: none */
    long long live;   /* bytes */
} host_state = {.mutex = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static void permit(int count) {
    pthread_mutex_lock(&host_state.mutex);
    host_state.permits = count;
    pthread_cond_broadcast(&host_state.changed);
    pthread_mutex_unlock(&host_state.mutex);
}

/* Until so many jobs have run, or wait. */
static void await_jobs(int count, bool done) {
    pthread_mutex_lock(&host_state.mutex);
    while ((done ? host_state.done : host_state.began) < count) pthread_cond_wait(&host_state.changed, &host_state.mutex);
    pthread_mutex_unlock(&host_state.mutex);
}

static int jobs_done(void) {
    pthread_mutex_lock(&host_state.mutex);
    int count = host_state.done;
    pthread_mutex_unlock(&host_state.mutex);
    return count;
}

static void shut(void) {
    permit(0);
    host_state.began = host_state.done = 0;
}

static void host_parallel_for(void *user, uint32_t count, void (*run)(void *context, uint32_t index), void *context) {
    UNUSED(user);
    bool held = !pthread_equal(pthread_self(), host_state.main);
    for (uint32_t i = 0; i < count; i++) {
        if (!held) {
            host_state.handed++;
            run(context, i);
            continue;
        }
        pthread_mutex_lock(&host_state.mutex);
        host_state.began++;
        pthread_cond_broadcast(&host_state.changed);
        while (host_state.permits == 0) pthread_cond_wait(&host_state.changed, &host_state.mutex);
        host_state.permits--;
        pthread_mutex_unlock(&host_state.mutex);
        run(context, i);
        pthread_mutex_lock(&host_state.mutex);
        host_state.done++;
        pthread_cond_broadcast(&host_state.changed);
        pthread_mutex_unlock(&host_state.mutex);
    }
}

static void *host_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    UNUSED(user);
    pthread_mutex_lock(&host_state.mutex);
    bool fails = new_size && new_size == host_state.fail_size && !pthread_equal(pthread_self(), host_state.main);
    if (!fails) host_state.live += (long long)new_size - (long long)(old ? old_size : 0);
    pthread_mutex_unlock(&host_state.mutex);
    if (fails) return NULL;
    if (new_size) return realloc(old, new_size);
    free(old);
    return NULL;
}

static void host_log_line(void *user, fnl_log_level level, const char *line) {
    UNUSED(user);
    pthread_mutex_lock(&host_state.mutex);
    test_log_line(&host_state.log, level, line);
    pthread_mutex_unlock(&host_state.mutex);
}

static fnl_host make_host(void) {
    fnl_host host = fnl_host_default();
    host.reallocate = host_reallocate;
    host.log = host_log_line;
    host.parallel_for = host_parallel_for;
    host.thread_count = 4;
    return host;
}

static int begin(void **state) {
    UNUSED(state);
    host_state.main = pthread_self();
    fnl_device_params params = fnl_device_params_default();
    params.host = make_host();
    params.validate = true;
    params.cache_folder = "";
    return fnl_device_create(&params, &test_device) == FNL_OK ? 0 : -1;
}

static int end(void **state) {
    int result = harness_end(state);
    if (host_state.live) print_error("%lld bytes of host memory are left\n", host_state.live);
    return host_state.live ? -1 : result;
}

static int check(void **state) {
    permit(OPEN);
    host_state.fail_size = 0;
    if (host_state.log.count) print_message("%s", host_state.log.text);
    host_state.log.length = host_state.log.count = 0;
    host_state.log.text[0] = 0;
    return harness_check(state);
}

/* ---- files ---- */

enum { SIDE = 16, IMAGES = 6 };

struct bytes {
    unsigned char *data;
    size_t size;
};

/* Of noise from `seed`; alpha and blue as the images below want them. */
static struct bytes make_png(uint32_t width, uint32_t height, uint32_t seed, bool flat) {
    fnl_image image = {width, height, FNL_PIXEL_FORMAT_RGBA8, malloc((size_t)width * height * 4)};
    uint8_t *pixels = image.pixels;
    struct random_state random = {seed};
    for (size_t i = 0; i < (size_t)width * height * 4; i++) {
        uint8_t value = flat ? (uint8_t)(50 * seed) : (uint8_t)(random_bits(&random) >> 40);
        pixels[i] = seed == 2 && i % 4 == 2 ? 90 : seed == 3 && i % 4 == 2 ? 200 + value / 8 : value; /* 2: one blue; 3: normals */
    }
    char path[64];
    snprintf(path, sizeof path, "/tmp/fanal-images-test-%d.png", (int)getpid());
    assert_int_equal(fnl_image_save(NULL, path, &image), FNL_OK);
    free(pixels);
    fnl_host host = fnl_host_default();
    host = host_resolve(&host);
    struct file_view view;
    assert_int_equal(file_load(&host, path, &view), FNL_OK);
    struct bytes png = {malloc(view.size), view.size};
    memcpy(png.data, view.data, view.size);
    file_free(&host, &view);
    unlink(path);
    return png;
}

/* What a file has. */
struct file {
    bool plain;      /* materials without textures, and without the emission that one has */
    int broken;      /* this image is; IMAGES: none */
    bool uris;       /* images are files of a resolver */
};
static const struct file whole = {.broken = IMAGES};

static struct bytes pngs[IMAGES];

static void append(char *json, const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(json + strlen(json), 16000 - strlen(json), format, arguments);
    va_end(arguments);
}

/*
 * Six boards in a row: base colour with a normal map; base colour that masks; that blends, with the image of the first; roughness whose blue is the same everywhere;
 * emission with roughness that varies; no texture.
 */
static unsigned char *make_glb(const struct file *f, size_t *size) {
    static const char *const looks[] = {
        "{\"normalTexture\":{\"index\":3},\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":0}}}",
        "{\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":{\"index\":1}}}",
        "{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[1,0.8,0.6,0.5],"
        "\"baseColorTexture\":{\"index\":0}}}",
        "{\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":2}}}",
        "{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":4},"
        "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.3,0.4,0.5,1],\"metallicRoughnessTexture\":{\"index\":5}}}",
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.1,0.1,1]}}"};
    static const char *const plain[] = {
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0}}",
        "{\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"metallicFactor\":0}}",
        "{\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorFactor\":[1,0.8,0.6,0.5]}}",
        "{}",
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.3,0.4,0.5,1]}}",
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.1,0.1,1]}}"};
    static const float board[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};
    float uv[12];
    for (int i = 0; i < 12; i++) uv[i] = board[i / 2 * 3 + i % 2] * (i % 2 ? -0.5f : 0.5f) + 0.5f;
    static char json[16000], binary[32768];
    size_t end = sizeof board + sizeof uv;
    memcpy(binary, board, sizeof board);
    memcpy(binary + sizeof board, uv, sizeof uv);
    strcpy(json, "{\"asset\":{\"version\":\"2.0\"},\"bufferViews\":[{\"buffer\":0,\"byteLength\":72},{\"buffer\":0,\"byteOffset\":72,\"byteLength\":48}");
    for (int i = 0; i < IMAGES && !f->uris; i++) {
        append(json, ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", end, pngs[i].size);
        memcpy(binary + end, pngs[i].data, pngs[i].size);
        if (i == f->broken) memset(binary + end + pngs[i].size / 2, 0x55, 16); /* the header is good */
        end = align_up(end + pngs[i].size, 4);
        assert_true(end < sizeof binary);
    }
    append(json, "],\"buffers\":[{\"byteLength\":%zu}],\"accessors\":[", end);
    append(json, "{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":6,\"min\":[-1,-1,0],\"max\":[1,1,0]},"
                 "{\"bufferView\":1,\"componentType\":5126,\"type\":\"VEC2\",\"count\":6}],\"images\":[");
    for (int i = 0; i < IMAGES; i++)
        append(json, f->uris ? "%s{\"uri\":\"%d.png\"}" : "%s{\"bufferView\":%d,\"mimeType\":\"image/png\"}", i ? "," : "",
               f->uris ? i : i + 2);
    append(json, "],\"textures\":[");
    for (int i = 0; i < IMAGES; i++) append(json, "%s{\"source\":%d}", i ? "," : "", i);
    append(json, "],\"materials\":[");
    for (int i = 0; i < 6; i++) append(json, "%s%s", i ? "," : "", f->plain ? plain[i] : looks[i]);
    append(json, "],\"meshes\":[");
    for (int i = 0; i < 6; i++)
        append(json, "%s{\"primitives\":[{\"material\":%d,\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}}]}", i ? "," : "", i);
    append(json, "],\"nodes\":[");
    for (int i = 0; i < 6; i++) append(json, "%s{\"mesh\":%d,\"translation\":[%d,%d,0]}", i ? "," : "", i, i % 3 * 2, i / 3 * 2);
    append(json, "],\"scenes\":[{\"nodes\":[0,1,2,3,4,5]}],\"scene\":0}");
    return test_glb(json, binary, end, size);
}

/* Bytes that are gone once they were released. */
static fnl_result resolve(void *user, const char *uri, fnl_resource *out);
static int released;
static void release(void *user, const void *data, size_t size) {
    UNUSED(user);
    memset((void *)(uintptr_t)data, 0xdd, size);
    free((void *)(uintptr_t)data);
    released++;
}
static fnl_result resolve(void *user, const char *uri, fnl_resource *out) {
    UNUSED(user);
    const struct bytes *png = &pngs[atoi(uri)];
    void *copy = malloc(png->size);
    memcpy(copy, png->data, png->size);
    *out = (fnl_resource){.data = copy, .size = png->size, .release = release};
    return FNL_OK;
}

static fnl_scene *load(const struct file *f, bool async) {
    size_t size;
    unsigned char *glb = make_glb(f, &size);
    fnl_host host = make_host();
    fnl_load_params params = fnl_load_params_default();
    params.async = async;
    params.data = glb;
    params.size = size;
    if (f->uris) params.resolve = resolve;
    fnl_scene *scene;
    if (fnl_scene_load(&host, "test.glb", &params, &scene) != FNL_OK) fail_msg("%s", host_state.log.text);
    free(glb);
    const fnl_vec3 ambient = {1, 1, 1};
    assert_int_equal(fnl_scene_set_ambient(scene, ambient, ambient), FNL_OK);
    fnl_light_params light = fnl_light_params_default();
    light.position = vec3_make(2, 1, 2);
    light.intensity = 20;
    fnl_light_id id;
    assert_int_equal(fnl_scene_add_light(scene, &light, &id), FNL_OK);
    return scene;
}

static struct stage open_stage(fnl_scene *scene) {
    struct stage stage = stage_open_scene(scene);
    stage.frame.width = 72;
    stage.frame.height = 48;
    stage.frame.ev = 0;
    stage.frame.shading = FNL_SHADING_FORWARD;
    stage.frame.lists = FNL_LISTS_ALL;
    stage.frame.camera = fnl_camera_default();
    stage.frame.camera.position = vec3_make(2, 1, 5);
    stage.frame.camera.target = vec3_make(2, 1, 0);
    return stage;
}

static uint64_t pending(struct stage *stage) {
    assert_int_equal(fnl_renderer_render(stage->renderer, &stage->frame), FNL_OK);
    return counter_of(stage->renderer, "images.pending");
}

static fnl_image picture(struct stage *stage) {
    fnl_image image;
    assert_int_equal(fnl_renderer_read(stage->renderer, FNL_OUTPUT_RADIANCE, &image), FNL_OK);
    return image;
}

/* Of a scene that is not async: one frame. */
static fnl_image picture_of(fnl_scene *scene, const fnl_frame *frame) {
    struct stage stage = open_stage(scene);
    stage.frame = *frame;
    assert_int_equal(pending(&stage), 0);
    fnl_image image = picture(&stage);
    stage_close(&stage);
    return image;
}

static void free_image(fnl_image *image) { fnl_image_free(gpu_host(harness_device()), image); }

static void expect_equal(struct stage *stage, fnl_image *expected, const char *what) {
    fnl_image image = picture(stage);
    uint64_t differing = count_differing(&image, expected);
    if (differing) fail_msg("%s: %llu pixels differ", what, (unsigned long long)differing);
    free_image(&image);
}

/* ---- tests ---- */

static void add_decals(fnl_scene *scene, bool pictures) {
    static const fnl_decal_kind kinds[] = {FNL_DECAL_BOX, FNL_DECAL_MESH, FNL_DECAL_REDRAW};
    for (uint32_t i = 0; i < COUNT_OF(kinds) && pictures; i++) {
        fnl_decal_params decal = fnl_decal_params_default();
        fnl_decal_id id;
        decal.kind = kinds[i];
        const uint32_t node = i == 2 ? 0 : i == 1 ? 3 : 5;
        if (kinds[i] != FNL_DECAL_BOX)
            decal.instance = (fnl_instance_id){node, scene->nodes.data[node].generation};
        decal.channels = FNL_DECAL_COLOR | FNL_DECAL_NORMAL | FNL_DECAL_ROUGHNESS;
        decal.color_image = (fnl_image_id){i == 2 ? 4 : 1, FIRST_GENERATION};
        decal.normal_image = (fnl_image_id){3, FIRST_GENERATION};
        decal.transform = mat4_scaling(vec3_make(1.2f, 1.2f, 1));
        if (kinds[i] == FNL_DECAL_BOX) decal.transform = mat4_mul(mat4_translation(vec3_make(4, 2, 0)), decal.transform);
        assert_int_equal(fnl_scene_add_decal(scene, &decal, &id), FNL_OK);
    }
}

struct way {
    fnl_shading shading;
    const char *key, *value;
    bool rounds; /* what is in its G-buffer: materials with such a texture are lit forward, those without are not */
};

/*
 * With each path: the first frame waits for nothing and shows factors alone, to the bit what a file without textures shows; the last one is that of a file that is
 * not async. Each image is decoded once and uploaded once, whoever uses it.
 */
static void test_frames_go_on_without_images(void **state) {
    UNUSED(state);
    static const struct way ways[] = {{FNL_SHADING_FORWARD, "transparency", "linked", false},
                                      {FNL_SHADING_DEFERRED, "decals", "gbuffer", false},
                                      {FNL_SHADING_DEFERRED, "gbuffer.layout", "stalker", true},
                                      {FNL_SHADING_VISIBILITY, NULL, NULL, false},
                                      {FNL_SHADING_VIRTUAL_TEXTURING, NULL, NULL, false}};
    for (uint32_t w = 0; w < COUNT_OF(ways); w++) {
        const bool decals = ways[w].shading != FNL_SHADING_VIRTUAL_TEXTURING;
        shut();
        fnl_scene *scene = load(&whole, true), *wanted = load(&whole, false);
        fnl_scene *bare = load(&(struct file){.plain = true, .broken = IMAGES}, false);
        add_decals(scene, decals);
        add_decals(wanted, decals);
        struct stage stage = open_stage(scene);
        stage.frame.shading = ways[w].shading;
        if (ways[w].key && fnl_frame_set(NULL, &stage.frame, ways[w].key, ways[w].value) != FNL_OK) fail();
        const struct device_scene *d = stage.renderer->device_scene;
        for (int i = 0; i < 2; i++) assert_int_equal(pending(&stage), IMAGES);
        fnl_image shown = picture(&stage);
        assert_int_equal(d->image_upload_count, 0);
        const uint64_t sorted = d->sort_count;
        permit(1);
        await_jobs(1, true);
        assert_int_equal(pending(&stage), IMAGES - 1);
        assert_int_equal(harness_stats(stage.renderer).pipelines_made, 0);
        permit(OPEN);
        await_jobs(IMAGES, true);
        assert_int_equal(pending(&stage), 0);
        assert_int_equal(harness_stats(stage.renderer).pipelines_made, 0);
        assert_int_equal(jobs_done(), IMAGES);
        assert_int_equal(d->image_upload_count, IMAGES);
        assert_int_equal(d->upload_count, 1); /* the structure was not made again */
        assert_int_equal(d->sort_count, sorted + 1); /* for the roughness whose blue turned out to be a factor */
        assert_null(d->image_queue);

        fnl_image last = picture_of(wanted, &stage.frame), first = picture_of(bare, &stage.frame);
        if (!ways[w].rounds) assert_int_equal(count_differing(&shown, &first), 0);
        assert_true(count_differing(&first, &last) > 1000);
        expect_equal(&stage, &last, fnl_value_name(FNL_ENUM_SHADING, ways[w].shading));
        assert_int_equal(pending(&stage), 0);
        expect_equal(&stage, &last, "the frame after");
        free_image(&shown);
        free_image(&first);
        free_image(&last);
        stage_close(&stage);
    }
}

static void set_images(fnl_scene *scene, uint32_t material, fnl_image_id color, fnl_image_id emissive) {
    fnl_material_params look;
    assert_int_equal(fnl_scene_query_material(scene, material, &look), FNL_OK);
    look.base_color_image = color;
    look.emissive_image = emissive;
    assert_int_equal(fnl_scene_set_material(scene, (fnl_material_id){material, FIRST_GENERATION}, &look), FNL_OK);
}

/* Images of 4 MiB, and the fourth of 18, as a file would bring them; each with a material. `from` .. `end` of them. */
enum { LATE = 7, LARGE = 3, LARGE_WIDTH = 2304, LARGE_HEIGHT = 2048 };

static uint32_t add_late_images(fnl_scene *scene, const struct bytes *small, const struct bytes *large, uint32_t from, uint32_t end) {
    const uint32_t first = scene->materials.count;
    for (uint32_t i = from; i < end; i++) {
        const struct bytes *png = i == LARGE ? large : small;
        struct scene_image image = {.name = "late",
                                    .encoded = png->data,
                                    .encoded_size = png->size,
                                    .width = i == LARGE ? LARGE_WIDTH : 1024,
                                    .height = i == LARGE ? LARGE_HEIGHT : 1024,
                                    .color = true,
                                    .async = true};
        struct scene_material material = scene_material_default();
        material.name = "";
        material.textures[SCENE_TEXTURE_BASE_COLOR].image = scene_add_image(scene, &image);
        assert_int_not_equal(scene_add_material(scene, &material), SCENE_NONE);
    }
    return first;
}

/* A frame sends so many bytes; a large image comes in parts, and shows when it is whole. */
static void test_a_frame_takes_up_little(void **state) {
    UNUSED(state);
    static const uint64_t left[] = {LATE - 2, LATE - 3, LATE - 3, LATE - 4, LATE - 6, 0};
    const struct bytes small = make_png(1024, 1024, 1, true), large = make_png(LARGE_WIDTH, LARGE_HEIGHT, 2, false);
    for (int way = 0; way < 3; way++) { /* to the end; the large one is not used any more; the renderer goes */
        shut();
        const uint64_t device_bytes = gpu_memory_stats(harness_device()).used_bytes;
        fnl_scene *scene = load(&whole, false);
        struct stage stage = open_stage(scene);
        const struct device_scene *d = stage.renderer->device_scene;
        assert_int_equal(pending(&stage), 0);
        const uint32_t material = add_late_images(scene, &small, &large, 0, 1) + LARGE;
        assert_int_equal(pending(&stage), 1);
        await_jobs(1, false); /* or it could take so many at once that those would fill what may wait */
        add_late_images(scene, &small, &large, 1, LATE);
        assert_int_equal(pending(&stage), LATE);
        permit(OPEN);
        await_jobs(LATE, true);
        uint64_t sent = 0;
        for (uint32_t i = 0; i < (way ? 2 : COUNT_OF(left)); i++) {
            const uint64_t before = d->bytes_uploaded;
            assert_int_equal(pending(&stage), left[i]);
            assert_in_range(d->bytes_uploaded - before, 1, DEVICE_IMAGE_BYTES + (64 << 10)); /* and materials */
            sent += d->bytes_uploaded - before;
        }
        if (way == 1) {
            assert_true(d->arrival.busy && d->arrival.row_count > 0);
            set_images(scene, material, (fnl_image_id){0, 0}, (fnl_image_id){0, 0});
            assert_int_equal(pending(&stage), LATE - 4);
            while (pending(&stage)) usleep(1000);
            assert_int_equal(d->image_upload_count, IMAGES + LATE - 1);
            set_images(scene, material, (fnl_image_id){scene->images.count - LATE + LARGE, FIRST_GENERATION}, (fnl_image_id){0, 0});
            while (pending(&stage)) usleep(1000);
        }
        if (way < 2) assert_int_equal(d->image_upload_count, IMAGES + LATE);
        if (way == 0) {
            /* What came in parts is the picture. */
            fnl_scene *wanted = load(&whole, false);
            set_images(scene, 5, (fnl_image_id){IMAGES + LARGE, FIRST_GENERATION}, (fnl_image_id){0, 0});
            add_late_images(wanted, &small, &large, 0, LATE);
            for (uint32_t i = 0; i < LATE; i++) wanted->images.data[IMAGES + i].async = false;
            set_images(wanted, 5, (fnl_image_id){IMAGES + LARGE, FIRST_GENERATION}, (fnl_image_id){0, 0});
            fnl_image last = picture_of(wanted, &stage.frame);
            assert_int_equal(pending(&stage), 0);
            expect_equal(&stage, &last, "an image that came in parts");
            free_image(&last);
            assert_in_range(sent, 42 << 20, (42 << 20) + (256 << 10));
        }
        stage_close(&stage);
        if (way) assert_int_equal(gpu_memory_stats(harness_device()).used_bytes, device_bytes);
    }
    free(small.data);
    free(large.data);
}

/* Blocks that come for a material and decals at once: the material keeps them, the decals have them decoded, as where frames waited for them. */
static void test_blocks_come_for_decals_too_MA_8(void **state) {
    UNUSED(state);
    struct test_ktx2 in = {.format = 138, .width = SIDE, .height = SIDE, .mips = 5, .sizes = {256, 64, 16, 16, 16}}; /* BC3 */
    unsigned char blocks[368];
    struct random_state random = {9};
    for (size_t i = 0; i < sizeof blocks; i++) blocks[i] = (unsigned char)(random_bits(&random) >> 40);
    in.bytes = blocks;
    size_t size;
    unsigned char *file = test_ktx2_make(&in, &size);
    shut();
    fnl_scene *scenes[] = {load(&whole, true), load(&whole, false)};
    for (int i = 0; i < 2; i++) {
        scenes[i]->images.data[1].encoded = file;
        scenes[i]->images.data[1].encoded_size = size;
        add_decals(scenes[i], true);
    }
    struct stage stage = open_stage(scenes[0]);
    assert_int_equal(pending(&stage), IMAGES);
    permit(OPEN);
    await_jobs(IMAGES, true);
    assert_int_equal(jobs_done(), IMAGES); /* decoded once */
    assert_int_equal(pending(&stage), 0);
    if (gpu_info(harness_device())->texture_compression)
        assert_int_equal(stage.renderer->device_scene->images.data[1].gpu.params.format, VK_FORMAT_BC3_UNORM_BLOCK);
    fnl_image last = picture_of(scenes[1], &stage.frame);
    expect_equal(&stage, &last, "blocks");
    free_image(&last);
    stage_close(&stage);
    free(file);
}

/* What a test sees of a broken image. */
struct broken_case {
    fnl_shading shading;
    bool decals, decals_only; /* use it */
};
struct broken_outcome {
    char lines[sizeof host_state.log.text];
    fnl_image picture;
    uint64_t uploads, atlas_bytes;
};

static void meet_broken_image(const struct broken_case *c, bool async, struct broken_outcome *out) {
    const struct file file = {.broken = 4};
    shut();
    fnl_scene *scene = load(&file, async);
    const fnl_image_id none = {0, 0}, first = {0, FIRST_GENERATION};
    if (c->decals_only) {
        set_images(scene, 1, none, none); /* of a good image too */
        set_images(scene, 4, none, none);
    }
    add_decals(scene, c->decals);
    struct stage stage = open_stage(scene);
    stage.frame.shading = c->shading;
    host_state.log.length = host_state.log.count = 0;
    if (async) {
        assert_int_equal(pending(&stage), IMAGES);
        assert_int_equal(host_state.log.count, 0);
        permit(OPEN);
        await_jobs(IMAGES, true);
    }
    assert_int_equal(pending(&stage), 0);
    out->atlas_bytes = stage.renderer->shading.atlas.bytes;
    set_images(scene, 5, none, first); /* a change of materials, and another use */
    fnl_decal_params decal = fnl_decal_params_default();
    decal.channels = FNL_DECAL_EMISSION;
    decal.emissive_image = (fnl_image_id){4, FIRST_GENERATION};
    fnl_decal_id id;
    if (c->decals) assert_int_equal(fnl_scene_add_decal(scene, &decal, &id), FNL_OK);
    assert_int_equal(pending(&stage), 0);
    if (host_state.log.count != 1) fail_msg("%u lines: %s", host_state.log.count, host_state.log.text);
    memcpy(out->lines, host_state.log.text, sizeof out->lines);
    host_state.log.count = 0;
    out->picture = picture(&stage);
    out->uploads = stage.renderer->device_scene->image_upload_count;
    stage_close(&stage);
}

/* One line names file and place, now as later, and no change repeats it. */
static void test_a_broken_image(void **state) {
    UNUSED(state);
    static const struct broken_case cases[] = {{FNL_SHADING_DEFERRED, true, false},
                                               {FNL_SHADING_DEFERRED, true, true},
                                               {FNL_SHADING_VIRTUAL_TEXTURING, false, false}};
    static struct broken_outcome now, later;
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        meet_broken_image(&cases[i], false, &now);
        meet_broken_image(&cases[i], true, &later);
        assert_non_null(strstr(now.lines, "test.glb: /images/4: "));
        assert_string_equal(now.lines, later.lines);
        assert_int_equal(count_differing(&now.picture, &later.picture), 0);
        assert_int_equal(now.uploads, later.uploads);
        assert_int_equal(now.atlas_bytes, later.atlas_bytes);
        free_image(&now.picture);
        free_image(&later.picture);
    }
}

/* The frame that would have shown an image fails; the next one begins again, and all are there in the end. */
static void test_memory_runs_out(void **state) {
    UNUSED(state);
    shut();
    struct stage stage = open_stage(load(&whole, true));
    fnl_image last = picture_of(load(&whole, false), &stage.frame);
    assert_int_equal(pending(&stage), IMAGES);
    host_state.fail_size = SIDE * SIDE * 4;
    permit(OPEN);
    await_jobs(IMAGES, true);
    assert_int_equal(fnl_renderer_render(stage.renderer, &stage.frame), FNL_ERROR_MEMORY);
    pthread_mutex_lock(&host_state.mutex);
    host_state.fail_size = 0;
    pthread_mutex_unlock(&host_state.mutex);
    assert_non_null(strstr(host_state.log.text, "test.glb: /images/"));
    host_state.log.count = 0;
    shut();
    assert_int_equal(pending(&stage), IMAGES);
    permit(OPEN);
    await_jobs(IMAGES, true);
    assert_int_equal(pending(&stage), 0);
    expect_equal(&stage, &last, "after memory ran out");
    free_image(&last);
    stage_close(&stage);
}

/* Whoever destroys a renderer joins the thread that decodes, which waits for a job that is held back. */
static bool join_opens;
int pthread_join(pthread_t thread, void **out) {
    static int (*real)(pthread_t, void **);
    if (join_opens) permit(OPEN);
    if (!real) *(void **)&real = dlsym(RTLD_NEXT, "pthread_join");
    return real(thread, out);
}

/* The bytes of the images are the host's, and gone when the scene is: whatever decodes them is over by then. */
static void test_destroyed_while_images_come(void **state) {
    UNUSED(state);
    const struct file file = {.broken = IMAGES, .uris = true};
    for (int i = 0; i < 2; i++) {
        shut();
        released = 0;
        struct stage stage = open_stage(load(&file, true));
        assert_int_equal(pending(&stage), IMAGES);
        if (i == 0) permit(2);
        await_jobs(i == 0 ? 3 : 1, false); /* two wait to be taken, one is being decoded */
        join_opens = true;
        fnl_renderer_destroy(&stage.renderer);
        join_opens = false;
        assert_int_equal(released, 0);
        stage_close(&stage);
        assert_int_equal(released, IMAGES);
    }
}

static void edit(fnl_scene *scene, bool async) {
    /* Material 0 gets another picture; 5 one that was not asked for before; 4 loses its own. */
    uint8_t pixels[4 * 4 * 4];
    memset(pixels, 130, sizeof pixels);
    fnl_image_id image;
    fnl_material_params look;
    assert_int_equal(fnl_scene_add_image(scene, &(fnl_image){4, 4, FNL_PIXEL_FORMAT_RGBA8, pixels}, true, &image), FNL_OK);
    for (uint32_t m = 0; m < 6; m++) {
        assert_int_equal(fnl_scene_query_material(scene, m, &look), FNL_OK);
        if (m == 0) look.base_color_image = image;
        if (m == 4) look.emissive_image = (fnl_image_id){0, 0};
        if (m == 5) look.base_color_image = (fnl_image_id){4, FIRST_GENERATION};
        assert_int_equal(fnl_scene_set_material(scene, (fnl_material_id){m, FIRST_GENERATION}, &look), FNL_OK);
    }
    assert_int_equal(fnl_scene_grow_metal(scene, 2), FNL_OK); /* decodes images 2 and 5 at once */
    fnl_scene *gone = scene;
    const fnl_instance_id node = {1, gone->nodes.data[1].generation};
    assert_int_equal(fnl_scene_remove_instance(scene, node), FNL_OK);
    size_t size;
    unsigned char *glb = make_glb(&whole, &size);
    fnl_load_params params = fnl_load_params_default();
    params.async = async;
    params.data = glb;
    params.size = size;
    fnl_loaded loaded;
    assert_int_equal(fnl_scene_load_into(scene, (fnl_instance_id){0, 0}, "second.glb", &params, &loaded), FNL_OK);
    free(glb);
    const fnl_mat4 place = mat4_mul(mat4_translation(vec3_make(0, 2, -1)), mat4_scaling(vec3_make(1, 1, 1)));
    assert_int_equal(fnl_scene_set_instance_transform(scene, loaded.root, &place), FNL_OK);
}

/* A scene that changes while its images are decoded looks in the end as one that was changed at leisure. */
static void test_edits_while_images_come(void **state) {
    UNUSED(state);
    shut();
    fnl_scene *scene = load(&whole, true), *wanted = load(&whole, false);
    add_decals(wanted, true);
    edit(wanted, false);
    struct stage stage = open_stage(scene);
    add_decals(scene, true);
    fnl_image last = picture_of(wanted, &stage.frame);
    assert_int_equal(pending(&stage), IMAGES);
    permit(1); /* image 0 has come when it is no longer used by that material */
    await_jobs(2, false);
    edit(scene, true);
    assert_int_equal(pending(&stage), IMAGES - 1 - 2 + IMAGES);
    permit(OPEN);
    await_jobs(2 * IMAGES, true);
    assert_int_equal(pending(&stage), 0);
    expect_equal(&stage, &last, "after edits");
    assert_int_equal(jobs_done(), 2 * IMAGES); /* none twice */
    free_image(&last);
    stage_close(&stage);
}

static void test_two_renderers(void **state) {
    UNUSED(state);
    shut();
    fnl_scene *scene = load(&whole, true);
    struct stage stage = open_stage(scene), other = stage;
    fnl_image last = picture_of(load(&whole, false), &stage.frame);
    assert_int_equal(fnl_renderer_create(harness_device(), scene, &other.renderer), FNL_OK);
    assert_int_equal(pending(&stage), IMAGES);
    assert_int_equal(pending(&other), IMAGES);
    permit(OPEN);
    while (pending(&stage) > 0) usleep(1000);
    expect_equal(&stage, &last, "the first renderer");
    while (pending(&other) > 0) usleep(1000);
    expect_equal(&other, &last, "the second renderer");
    assert_int_equal(jobs_done() % IMAGES, 0); /* once for each, or for both */
    assert_in_range(jobs_done(), IMAGES, 2 * IMAGES);
    fnl_renderer_destroy(&other.renderer);
    free_image(&last);
    stage_close(&stage);
}

static void test_a_scene_without_images(void **state) {
    UNUSED(state);
    shut();
    fnl_load_params params = fnl_load_params_default();
    params.async = true;
    fnl_host host = make_host();
    fnl_scene *scene;
    assert_int_equal(scene_load_plain(&host, "builtin:spheres", &params, &scene), FNL_OK);
    struct stage stage = open_stage(scene);
    assert_int_equal(pending(&stage), 0);
    assert_null(stage.renderer->device_scene->image_queue); /* and no thread */
    stage_close(&stage);
    scene = load(&whole, false);
    add_decals(scene, true);
    stage = open_stage(scene);
    stage.frame.record_threads = 1;
    host_state.handed = 0;
    assert_int_equal(pending(&stage), 0); /* not async: the frame has waited */
    const int first = host_state.handed;
    assert_int_equal(pending(&stage), 0);
    const int recorded = host_state.handed - first; /* every frame records */
    assert_int_equal(first - recorded, IMAGES + 3); /* for materials; and three for decals, whatever their kinds */
    assert_int_equal(stage.renderer->device_scene->image_upload_count, IMAGES);
    assert_int_equal(jobs_done(), 0);
    stage_close(&stage);
}

/* What was collected before is of other surfaces: the sequence begins with the frame that shows all. */
static void test_temporal_antialiasing_starts_anew(void **state) {
    UNUSED(state);
    shut();
    struct stage stage = open_stage(load(&whole, true)), wanted = open_stage(load(&whole, false));
    stage.frame.aa = wanted.frame.aa = FNL_ANTIALIASING_TAA;
    for (int i = 0; i < 3; i++) assert_int_equal(pending(&stage), IMAGES);
    permit(OPEN);
    await_jobs(IMAGES, true);
    for (int i = 0; i < 4; i++) {
        assert_int_equal(pending(&stage), 0);
        assert_int_equal(pending(&wanted), 0);
        fnl_image last = picture(&wanted);
        expect_equal(&stage, &last, "a frame with temporal antialiasing");
        free_image(&last);
    }
    stage_close(&wanted);
    stage_close(&stage);
}

static void test_auto_does_not_measure_before(void **state) {
    UNUSED(state);
    shut();
    struct stage stage = open_stage(load(&whole, true));
    const struct chooser *chooser = &stage.renderer->choice.chooser;
    stage.frame.lists = FNL_LISTS_AUTO;
    for (int i = 0; i < 4; i++) {
        assert_int_equal(pending(&stage), IMAGES);
        assert_false(stage.renderer->choice.measures);
        assert_int_equal(chooser->frames + chooser->pending_count, 0);
        assert_true(harness_stats(stage.renderer).choosing);
    }
    permit(OPEN);
    await_jobs(IMAGES, true);
    assert_int_equal(pending(&stage), 0);
    assert_true(stage.renderer->choice.measures);
    stage_close(&stage);
}

/* Warming starts the decoding, and waits for none of it. */
static void test_warming_starts_it(void **state) {
    UNUSED(state);
    shut();
    struct stage stage = open_stage(load(&whole, true));
    fnl_image last = picture_of(load(&whole, false), &stage.frame);
    assert_int_equal(fnl_renderer_warm(stage.renderer, &stage.frame, NULL, true, NULL), FNL_OK);
    assert_int_equal(stage.renderer->device_scene->images_coming, IMAGES);
    permit(OPEN);
    await_jobs(IMAGES, true);
    assert_int_equal(pending(&stage), 0);
    expect_equal(&stage, &last, "the first frame");
    free_image(&last);
    stage_close(&stage);
}

int main(void) {
    for (uint32_t i = 0; i < IMAGES; i++) pngs[i] = make_png(SIDE, SIDE, i, false);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(test_frames_go_on_without_images, check),
        cmocka_unit_test_teardown(test_a_frame_takes_up_little, check),
        cmocka_unit_test_teardown(test_blocks_come_for_decals_too_MA_8, check),
        cmocka_unit_test_teardown(test_a_broken_image, check),
        cmocka_unit_test_teardown(test_memory_runs_out, check),
        cmocka_unit_test_teardown(test_destroyed_while_images_come, check),
        cmocka_unit_test_teardown(test_edits_while_images_come, check),
        cmocka_unit_test_teardown(test_two_renderers, check),
        cmocka_unit_test_teardown(test_a_scene_without_images, check),
        cmocka_unit_test_teardown(test_temporal_antialiasing_starts_anew, check),
        cmocka_unit_test_teardown(test_auto_does_not_measure_before, check),
        cmocka_unit_test_teardown(test_warming_starts_it, check),
    };
    int failed = cmocka_run_group_tests_name("render: images that come later", tests, begin, end);
    for (uint32_t i = 0; i < IMAGES; i++) free(pngs[i].data);
    return failed;
}
