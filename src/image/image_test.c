/* SPDX-License-Identifier: MIT */
#include "image/image.h"

#include "base/file.h"
#include "base/jobs.h"
#include "image/image_samples.h"
#include "tests/stand_in.h"

#include <dirent.h>
#include <errno.h>
#include <float.h>
#include <math.h>
#include <openexr.h>
#include <setjmp.h>
#include <signal.h>
#include <stdatomic.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

/* ---- a host that counts memory and keeps the last line of its log ---- */

struct watch {
    size_t live, largest;
    char line[2048];
    uint32_t lines;
};

static void *watch_reallocate(void *user, void *old, size_t old_size, size_t new_size) {
    struct watch *watch = user;
    watch->live -= old ? old_size : 0;
    watch->live += new_size;
    watch->largest = MAX(watch->largest, new_size);
    if (new_size) return realloc(old, new_size);
    free(old);
    return NULL;
}

static void watch_log(void *user, fnl_log_level log_level, const char *line) {
    struct watch *watch = user;
    UNUSED(log_level);
    snprintf(watch->line, sizeof watch->line, "%s", line);
    watch->lines++;
}

static fnl_host watch_host(struct watch *watch) {
    *watch = (struct watch){0};
    return host_resolve(&(fnl_host){.user = watch, .reallocate = watch_reallocate, .log = watch_log});
}

/* ---- helpers ---- */

static char folder[64];

static const char *path_of(const char *name) {
    static char path[256];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return path;
}

static uint32_t count_files(void) {
    uint32_t count = 0;
    DIR *stream = opendir(folder);
    assert_non_null(stream);
    for (struct dirent *entry; (entry = readdir(stream));) count += entry->d_name[0] != '.';
    closedir(stream);
    return count;
}

static double value_at(const fnl_image *image, size_t i) {
    switch (image->format) {
    case FNL_PIXEL_FORMAT_RGBA8:
        return ((const uint8_t *)image->pixels)[i] / 255.0;
    case FNL_PIXEL_FORMAT_RGBA16:
        return ((const uint16_t *)image->pixels)[i] / 65535.0;
    case FNL_PIXEL_FORMAT_RGBA32F:
        return (double)((const float *)image->pixels)[i];
    }
    return NAN;
}

static bool near(const fnl_image *image, const fnl_image *expected, double tolerance) {
    if (image->width != expected->width || image->height != expected->height || image->format != expected->format)
        return false;
    for (size_t i = 0; i < (size_t)image->width * image->height * 4; i++)
        if (!(fabs(value_at(image, i) - value_at(expected, i)) <= tolerance)) return false;
    return true;
}

static fnl_image make_image(uint32_t width, uint32_t height, fnl_pixel_format format, bool opaque, uint64_t seed) {
    fnl_image image = {width, height, format, malloc((size_t)width * height * fnl_pixel_size(format))};
    assert_non_null(image.pixels);
    struct random_state random = {seed};
    for (size_t i = 0; i < (size_t)width * height * 4; i++) {
        uint64_t bits = opaque && i % 4 == 3 ? UINT64_MAX : random_bits(&random);
        if (format == FNL_PIXEL_FORMAT_RGBA8) ((uint8_t *)image.pixels)[i] = (uint8_t)bits;
        if (format == FNL_PIXEL_FORMAT_RGBA16) ((uint16_t *)image.pixels)[i] = (uint16_t)bits;
        if (format == FNL_PIXEL_FORMAT_RGBA32F)
            ((float *)image.pixels)[i] = i % 4 == 3 ? 1 : ldexpf((float)(bits >> 40), (int)(bits % 40) - 40);
    }
    return image;
}

static const uint32_t sizes[][2] = {{1, 1}, {3, 5}, {257, 131}};

/* ---- reading ---- */

static void test_every_kind_is_read(void **state) {
    UNUSED(state);
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++) {
        struct image_sample samples[IMAGE_SAMPLES_MAX];
        uint32_t count = image_samples_make(samples, sizes[s][0], sizes[s][1]);
        for (uint32_t i = 0; i < count; i++) {
            struct watch watch;
            fnl_host host = watch_host(&watch);
            fnl_image image;
            fnl_result result = image_decode(&host, samples[i].bytes, samples[i].size, samples[i].name, false, &image);
            if (result != samples[i].result ||
                (result == FNL_OK && !near(&image, &samples[i].expected, samples[i].tolerance)))
                fail_msg("%s at %u x %u: %s %s", samples[i].name, sizes[s][0], sizes[s][1], fnl_result_name(result),
                         watch.line);
            if (result != FNL_OK) assert_null(image.pixels);
            fnl_image_free(&host, &image);
            assert_int_equal(watch.live, 0);
            assert_int_equal(watch.lines, result != FNL_OK || strstr(watch.line, "without the channel") != NULL);

            struct image_file_info info;
            result = image_peek(&host, samples[i].bytes, samples[i].size, samples[i].name, &info);
            assert_int_equal(result, samples[i].result);
            if (result != FNL_OK) continue;
            assert_int_equal(info.kind, samples[i].kind);
            assert_int_equal(info.width, sizes[s][0]);
            assert_int_equal(info.height, sizes[s][1]);
        }
        image_samples_free(samples, count);
    }
}

static void test_forced_to_8_bits(void **state) {
    UNUSED(state);
    struct image_sample samples[IMAGE_SAMPLES_MAX];
    uint32_t count = image_samples_make(samples, 37, 11);
    for (uint32_t i = 0; i < count; i++) {
        if (samples[i].result != FNL_OK) continue;
        struct watch watch;
        fnl_host host = watch_host(&watch);
        fnl_image image;
        fnl_result result = image_decode(&host, samples[i].bytes, samples[i].size, samples[i].name, true, &image);
        bool is_float = samples[i].expected.format == FNL_PIXEL_FORMAT_RGBA32F;
        assert_int_equal(result, is_float ? FNL_ERROR_UNSUPPORTED : FNL_OK);
        if (is_float) continue;
        assert_int_equal(image.format, FNL_PIXEL_FORMAT_RGBA8);
        for (size_t k = 0; k < 37 * 11 * 4; k++)
            if (samples[i].tolerance == 0)
                assert_int_equal(((uint8_t *)image.pixels)[k], (int)floor(value_at(&samples[i].expected, k) * 255 + 0.5));
        fnl_image_free(&host, &image);
        assert_int_equal(watch.live, 0);
    }
    image_samples_free(samples, count);
}

/* A cut file is an error, unless nothing of the picture is lost: the second part of an EXR, the checksum of PNG's end
 * mark. */
static void test_files_cut_at_every_byte(void **state) {
    UNUSED(state);
    struct image_sample samples[IMAGE_SAMPLES_MAX];
    uint32_t count = image_samples_make(samples, 13, 5);
    for (uint32_t i = 0; i < count; i++)
        for (size_t size = 0; size < samples[i].size; size++) {
            struct watch watch;
            fnl_host host = watch_host(&watch);
            unsigned char *cut = malloc(size + 1); /* of its own, so that reading on is found */
            assert_non_null(cut);
            memcpy(cut, samples[i].bytes, size);
            unsigned char *exact = size ? realloc(cut, size) : cut;
            fnl_image image;
            fnl_result result = image_decode(&host, exact, size, "a.file", false, &image);
            bool spare = strcmp(samples[i].name, "multipart.exr") == 0 ||
                         (samples[i].kind == IMAGE_FILE_PNG && samples[i].size - size <= 4);
            if (result == FNL_OK && !(spare && near(&image, &samples[i].expected, samples[i].tolerance)))
                fail_msg("%s cut to %zu of %zu bytes was read", samples[i].name, size, samples[i].size);
            if (result != FNL_OK) {
                assert_memory_equal(watch.line, "a.file: ", 8);
                assert_null(image.pixels);
            }
            fnl_image_free(&host, &image);
            assert_int_equal(watch.live, 0);
            free(exact);
        }
    image_samples_free(samples, count);
}

static void test_damaged_files_do_no_harm(void **state) {
    UNUSED(state);
    struct image_sample samples[IMAGE_SAMPLES_MAX];
    uint32_t count = image_samples_make(samples, 37, 21);
    struct random_state random = {7};
    for (uint32_t i = 0; i < count; i++)
        for (int round = 0; round < 100; round++) {
            struct watch watch;
            fnl_host host = watch_host(&watch);
            unsigned char *copy = malloc(samples[i].size);
            assert_non_null(copy);
            memcpy(copy, samples[i].bytes, samples[i].size);
            for (int k = 0; k < 3; k++) copy[random_bits(&random) % samples[i].size] = (unsigned char)random_bits(&random);
            struct image_file_info info;
            fnl_image image = {0};
            if (image_peek(&host, copy, samples[i].size, "x", &info) == FNL_OK &&
                (uint64_t)info.width * info.height < 1 << 22)
                image_decode(&host, copy, samples[i].size, "x", false, &image);
            fnl_image_free(&host, &image);
            assert_int_equal(watch.live, 0);
            free(copy);
        }
    image_samples_free(samples, count);
}

static uint32_t crc32_of(const unsigned char *bytes, size_t size) {
    uint32_t crc = UINT32_MAX;
    for (size_t i = 0; i < size; i++) {
        crc ^= bytes[i];
        for (int k = 0; k < 8; k++) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0);
    }
    return ~crc;
}

static void store_big(unsigned char *at, uint32_t value, int bytes) {
    for (int i = 0; i < bytes; i++) at[i] = (unsigned char)(value >> 8 * (bytes - 1 - i));
}

/* Writes another size into the header of a sample. False for kinds that this test does not know how to change. */
static bool set_size(struct image_sample *sample, uint32_t width, uint32_t height) {
    unsigned char *at;
    switch (sample->kind) {
    case IMAGE_FILE_PNG:
        store_big(sample->bytes + 16, width, 4);
        store_big(sample->bytes + 20, height, 4);
        store_big(sample->bytes + 29, crc32_of(sample->bytes + 12, 17), 4);
        return true;
    case IMAGE_FILE_JPEG:
        for (at = sample->bytes; at[0] != 0xff || at[1] < 0xc0 || at[1] > 0xc2; at++)
            if (at + 10 > sample->bytes + sample->size) return false;
        store_big(at + 5, height, 2);
        store_big(at + 7, width, 2);
        return true;
    case IMAGE_FILE_EXR:
        at = memmem(sample->bytes, sample->size, "dataWindow\0box2i", 17);
        assert_non_null(at);
        for (int i = 0; i < 4; i++) {
            at[21 + i] = at[25 + i] = 0;
            at[29 + i] = (unsigned char)((width - 1) >> 8 * i);
            at[33 + i] = (unsigned char)((height - 1) >> 8 * i);
        }
        return true;
    case IMAGE_FILE_HDR: {
        size_t size = 0;
        at = memmem(sample->bytes, sample->size, "Y ", 2);
        assert_non_null(at);
        unsigned char *end = memchr(at, '\n', 100), *bytes = malloc(sample->size + 100);
        assert_non_null(bytes);
        memcpy(bytes, sample->bytes, (size_t)(at - sample->bytes));
        size = (size_t)(at - sample->bytes);
        size += (size_t)sprintf((char *)bytes + size, "Y %u +X %u", height, width);
        memcpy(bytes + size, end, sample->size - (size_t)(end - sample->bytes));
        sample->size = size + sample->size - (size_t)(end - sample->bytes);
        free(sample->bytes);
        sample->bytes = bytes;
        return true;
    }
    default:
        return false;
    }
}

static void test_impossible_sizes_are_refused(void **state) {
    UNUSED(state);
    static const uint32_t impossible[][2] = {{0, 5},         {5, 0},        {32769, 1},   {1, 40000},
                                             {32768, 32768}, {32768, 8192}, {30000, 8000}};
    for (uint32_t s = 0; s < COUNT_OF(impossible); s++) {
        struct image_sample samples[IMAGE_SAMPLES_MAX];
        uint32_t count = image_samples_make(samples, 9, 3);
        for (uint32_t i = 0; i < count; i++) {
            struct watch watch;
            fnl_host host = watch_host(&watch);
            /* DWA's best case reaches far: a few hundred bytes may stand for these sizes. */
            if (!set_size(&samples[i], impossible[s][0], impossible[s][1]) || strncmp(samples[i].name, "dwa", 3) == 0)
                continue;
            fnl_image image;
            fnl_result result = image_decode(&host, samples[i].bytes, samples[i].size, samples[i].name, false, &image);
            if (result == FNL_OK) fail_msg("%s as %u x %u was read", samples[i].name, impossible[s][0], impossible[s][1]);
            if (watch.largest > 1 << 24) fail_msg("%s asked for %zu bytes: %s", samples[i].name, watch.largest, watch.line);
            assert_int_equal(watch.live, 0);
            assert_int_equal(watch.lines, 1);
            assert_non_null(strstr(watch.line, samples[i].name));
        }
        image_samples_free(samples, count);
    }
}

/* When the pixels are read: the header alone need not show it. */
static void expect_late_refusal(const void *bytes, size_t size, fnl_result expected, const char *words) {
    struct watch watch;
    fnl_host host = watch_host(&watch);
    fnl_image image;
    assert_int_equal(image_decode(&host, bytes, size, "scene.gltf: /images/3", false, &image), expected);
    assert_memory_equal(watch.line, "scene.gltf: /images/3: ", 23);
    if (!strstr(watch.line, words)) fail_msg("'%s' is not in '%s'", words, watch.line);
    assert_int_equal(watch.live, 0);
    if (watch.largest > 1 << 24) fail_msg("%s asked for %zu bytes", words, watch.largest);
}

static void expect_refusal(const char *bytes, size_t size, fnl_result expected, const char *words) {
    struct watch watch;
    fnl_host host = watch_host(&watch);
    struct image_file_info info;
    expect_late_refusal(bytes, size, expected, words);
    assert_int_equal(image_peek(&host, bytes, size, "x", &info), expected);
    assert_int_equal(info.width, 0);
}

static void test_unknown_and_unsupported_contents(void **state) {
    UNUSED(state);
    expect_refusal("", 0, FNL_ERROR_FORMAT, "is empty");
    expect_refusal("GIF89a......", 12, FNL_ERROR_FORMAT, "known kind");
    expect_refusal("\x89PNG\r\n\x1a\n", 8, FNL_ERROR_FORMAT, "PNG");
    expect_refusal("\xff\xd8\xff", 3, FNL_ERROR_FORMAT, "JPEG");
    expect_refusal("RIFF\xff\0\0\0WEBPVP8 ", 16, FNL_ERROR_FORMAT, "WebP");
    const char xyze[] = "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n\1\2\3\4";
    expect_refusal(xyze, sizeof xyze - 1, FNL_ERROR_UNSUPPORTED, "32-bit_rle_xyze");
    const char columns[] = "#?RADIANCE\n\n+X 1 -Y 1\n\1\2\3\4";
    expect_refusal(columns, sizeof columns - 1, FNL_ERROR_UNSUPPORTED, "columns");
    const char exposure[] = "#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n\1\2\3\4";
    expect_refusal(exposure, sizeof exposure - 1, FNL_ERROR_FORMAT, "EXPOSURE=0");
    const char comma[] = "#?RADIANCE\nEXPOSURE=1,5\n\n-Y 1 +X 1\n\1\2\3\4", rest[] = "#?RADIANCE\nCOLORCORR=1 1 1 1\n\n-Y 1 +X 1\n\1\2\3\4";
    expect_refusal(comma, sizeof comma - 1, FNL_ERROR_FORMAT, "EXPOSURE=1,5");
    expect_refusal(rest, sizeof rest - 1, FNL_ERROR_FORMAT, "COLORCORR=1 1 1 1");
    const char primaries[] = "#?RADIANCE\nPRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06\n\n-Y 1 +X 1\n\1\2\3\4";
    expect_refusal(primaries, sizeof primaries - 1, FNL_ERROR_FORMAT, "PRIMARIES=0.64");
    static const char *const resolutions[] = {"-Y -2 +X 1", "-Y +2 +X 1", "-Y 2 +X -1", "-Y 1 +X 1 1", "-Y 1.5 +X 1", "-Y 0x2 +X 1", "-Y +X 1", "Y 1 X 1"};
    for (uint32_t i = 0; i < COUNT_OF(resolutions); i++) {
        char file[128];
        snprintf(file, sizeof file, "#?RADIANCE\n\n%s\n\1\2\3\4\1\2\3\4", resolutions[i]);
        expect_refusal(file, strlen(file), FNL_ERROR_FORMAT, "is not a resolution");
    }
    /* An animation: a VP8X chunk with its flag. */
    const char animated[] = "RIFF\x16\0\0\0WEBPVP8X\x0a\0\0\0\x02\0\0\0\x03\0\0\x03\0\0";
    expect_refusal(animated, sizeof animated - 1, FNL_ERROR_UNSUPPORTED, "animated");
}

struct parallel_decode {
    struct image_sample samples[IMAGE_SAMPLES_MAX];
    uint32_t count;
    fnl_host host;
    atomic_uint wrong;
};

static void decode_one(void *context, uint32_t index) {
    struct parallel_decode *work = context;
    struct image_sample *sample = &work->samples[index % work->count];
    fnl_image image;
    fnl_result result = image_decode(&work->host, sample->bytes, sample->size, sample->name, false, &image);
    if (result != sample->result || (result == FNL_OK && !near(&image, &sample->expected, sample->tolerance))) work->wrong++;
    fnl_image_free(&work->host, &image);
}

static void drop_line(void *user, fnl_log_level log_level, const char *line) {
    UNUSED(user);
    UNUSED(log_level);
    UNUSED(line);
}

static void test_decoders_run_in_parallel(void **state) {
    UNUSED(state);
    static struct parallel_decode work;
    work.count = image_samples_make(work.samples, 61, 33);
    work.host = host_resolve(&(fnl_host){.log = drop_line, .thread_count = 4});
    struct jobs *jobs;
    assert_int_equal(jobs_create(&work.host, &jobs), FNL_OK);
    jobs_parallel_for(jobs, work.count * 8, decode_one, &work);
    jobs_destroy(&jobs);
    assert_int_equal(work.wrong, 0);
    image_samples_free(work.samples, work.count);
}

/* ---- writing ---- */

static void round_trip(const char *name, const fnl_image *image, double relative) {
    struct watch watch;
    fnl_host host = watch_host(&watch);
    char path[256];
    snprintf(path, sizeof path, "%s", path_of(name));
    struct file_view first, second;
    assert_int_equal(fnl_image_save(&host, path, image), FNL_OK);
    assert_int_equal(file_load(&host, path, &first), FNL_OK);
    assert_int_equal(fnl_image_save(&host, path, image), FNL_OK); /* over the first */
    assert_int_equal(file_load(&host, path, &second), FNL_OK);
    assert_int_equal(first.size, second.size);
    assert_memory_equal(first.data, second.data, first.size);
    file_free(&host, &first);
    file_free(&host, &second);
    fnl_image back;
    assert_int_equal(fnl_image_load(&host, path, &back), FNL_OK);
    assert_int_equal(back.format, image->format);
    assert_int_equal(back.width, image->width);
    assert_int_equal(back.height, image->height);
    size_t count = (size_t)image->width * image->height * 4;
    if (relative == 0) assert_memory_equal(back.pixels, image->pixels, count / 4 * fnl_pixel_size(image->format));
    for (size_t i = 0; relative > 0 && i < count; i++) {
        /* RGBE: half a step of the pixel's greatest component */
        double greatest = 0, exact = value_at(image, i);
        for (size_t c = 0; c < 3; c++) greatest = fmax(greatest, value_at(image, i / 4 * 4 + c));
        if (fabs(value_at(&back, i) - exact) > relative * greatest)
            fail_msg("%s: %g became %g", name, exact, value_at(&back, i));
    }
    fnl_image_free(&host, &back);
    assert_int_equal(watch.live, 0);
    assert_int_equal(count_files(), 1);
    unlink(path);
}

static void test_what_is_saved_is_read_again(void **state) {
    UNUSED(state);
    for (uint32_t s = 0; s < COUNT_OF(sizes); s++)
        for (int opaque = 0; opaque < 2; opaque++)
            for (int format = 0; format < 3; format++) {
                fnl_image image = make_image(sizes[s][0], sizes[s][1], (fnl_pixel_format)format, opaque, 3);
                bool is_float = format == FNL_PIXEL_FORMAT_RGBA32F;
                round_trip(is_float ? "a.exr" : "a.PNG", &image, 0);
                if (is_float) round_trip("a.hdr", &image, 0.5 / 127);
                free(image.pixels);
            }
}

static void test_hdr_splits_long_runs(void **state) {
    UNUSED(state);
    static float values[300 * 2 * 4];
    for (uint32_t i = 0; i < COUNT_OF(values); i++) values[i] = i % 4 < 3 && i / 4 % 300 < 3 ? (float)(i / 4 % 300 + 1) : 1;
    round_trip("a.hdr", &(fnl_image){300, 2, FNL_PIXEL_FORMAT_RGBA32F, values}, 0);
}

static void test_exr_keeps_what_is_not_finite(void **state) {
    UNUSED(state);
    float values[] = {NAN, INFINITY, -INFINITY, -0.0f, 1e-45f, FLT_MAX, -FLT_MAX, 1, 0, 0.1f, 2, NAN};
    round_trip("a.exr", &(fnl_image){3, 1, FNL_PIXEL_FORMAT_RGBA32F, values}, 0);
}

/* Compressed to as many bytes as there are: a chunk of that length is one that is not compressed. */
static void test_exr_that_does_not_shrink(void **state) {
    UNUSED(state);
    struct random_state random = {5};
    round_trip("a.exr", &(fnl_image){1, 1, FNL_PIXEL_FORMAT_RGBA32F, (float[]){-1, 0, 0, 0}}, 0);
    for (uint32_t i = 0; i < 200; i++) {
        float values[4 * 6] = {0};
        uint32_t width = 1 + i % 6;
        for (uint32_t k = 0; k < 4 * width; k++)
            if (random_bits(&random) % 3 == 0) values[k] = random_float(&random);
        round_trip("a.exr", &(fnl_image){width, 1, FNL_PIXEL_FORMAT_RGBA32F, values}, 0);
    }
}

static void test_hdr_clamps_what_it_cannot_hold(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    float values[] = {NAN, -1, 0.5f, 1, INFINITY, 0, 0, 1, 1e-44f, 0, 0, 1, 255.9f, 1, 0, 1};
    fnl_image image = {4, 1, FNL_PIXEL_FORMAT_RGBA32F, values}, back;
    assert_int_equal(fnl_image_save(&host, path_of("a.hdr"), &image), FNL_OK);
    assert_int_equal(fnl_image_load(&host, path_of("a.hdr"), &back), FNL_OK);
    const float *p = back.pixels;
    assert_true(p[0] == 0 && p[1] == 0 && p[2] == 0.5f);
    assert_true(isfinite(p[4]) && p[4] > 1.6e38f);
    assert_true(p[8] == 0);
    assert_true(p[12] == 256 && p[13] == 2 * rintf(1 / 2.0f)); /* a step of 2: nearest even */
    fnl_image_free(&host, &back);
    unlink(path_of("a.hdr"));
}

static void test_png_says_srgb_and_drops_full_alpha(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    for (int opaque = 0; opaque < 2; opaque++) {
        fnl_image image = make_image(5, 4, FNL_PIXEL_FORMAT_RGBA8, opaque, 1);
        assert_int_equal(fnl_image_save(&host, path_of("a.png"), &image), FNL_OK);
        struct file_view view;
        assert_int_equal(file_load(&host, path_of("a.png"), &view), FNL_OK);
        assert_int_equal(view.data[25], opaque ? 2 : 6); /* colour type of the header */
        assert_non_null(memmem(view.data, view.size, "sRGB", 4));
        file_free(&host, &view);
        unlink(path_of("a.png"));
        free(image.pixels);
    }
}

static void test_exr_planes(void **state) {
    UNUSED(state);
    struct watch watch;
    fnl_host host = watch_host(&watch);
    enum { WIDTH = 19, HEIGHT = 35 };
    static float values[WIDTH * HEIGHT * 6];
    for (uint32_t i = 0; i < COUNT_OF(values); i++) values[i] = (float)i;
    const char *long_name = "a.layer.of.a.very.long.name.that.needs.the.long.form";
    const fnl_exr_channel channels[] = {{"normal.X", values, 6}, {"R", values + 1, 6}, {"depth.Z", values + 2, 6},
                                        {"B", values + 3, 6},    {"G", values, 1},     {long_name, values + 4, 3}};
    assert_int_equal(fnl_exr_save(&host, path_of("planes.exr"), WIDTH, HEIGHT, channels, COUNT_OF(channels)), FNL_OK);
    fnl_image image;
    assert_int_equal(fnl_image_load(&host, path_of("planes.exr"), &image), FNL_OK);
    for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
        const float *pixel = (const float *)image.pixels + (size_t)i * 4;
        assert_true(pixel[0] == values[i * 6 + 1] && pixel[1] == values[i] && pixel[2] == values[i * 6 + 3] &&
                    pixel[3] == 1);
    }
    fnl_image_free(&host, &image);

    exr_context_t exr = NULL;
    const exr_attr_chlist_t *list;
    assert_int_equal(exr_start_read(&exr, path_of("planes.exr"), NULL), 0);
    assert_int_equal(exr_get_channels(exr, 0, &list), 0);
    const char *sorted[] = {"B", "G", "R", long_name, "depth.Z", "normal.X"};
    assert_int_equal(list->num_channels, COUNT_OF(sorted));
    for (uint32_t i = 0; i < COUNT_OF(sorted); i++) {
        assert_string_equal(list->entries[i].name.str, sorted[i]);
        assert_int_equal(list->entries[i].pixel_type, EXR_PIXEL_FLOAT);
    }
    exr_compression_t compression;
    exr_storage_t storage;
    assert_int_equal(exr_get_compression(exr, 0, &compression), 0);
    assert_int_equal(exr_get_storage(exr, 0, &storage), 0);
    assert_int_equal(compression, EXR_COMPRESSION_ZIP);
    assert_int_equal(storage, EXR_STORAGE_SCANLINE);
    exr_finish(&exr);

    fnl_exr_channel twice[] = {{"R", values, 1}, {"R", values, 1}};
    assert_int_equal(fnl_exr_save(&host, path_of("twice.exr"), 1, 1, twice, 2), FNL_ERROR_INVALID);
    twice[1].name = "";
    assert_int_equal(fnl_exr_save(&host, path_of("twice.exr"), 1, 1, twice, 2), FNL_ERROR_INVALID);
    assert_int_equal(fnl_exr_save(&host, path_of("twice.exr"), 0, 1, twice, 1), FNL_ERROR_INVALID);
    /* Only planes that are no colours. */
    assert_int_equal(fnl_exr_save(&host, path_of("planes.exr"), WIDTH, HEIGHT, channels, 1), FNL_OK);
    assert_int_equal(fnl_image_load(&host, path_of("planes.exr"), &image), FNL_ERROR_UNSUPPORTED);
    assert_non_null(strstr(watch.line, "normal.X"));
    unlink(path_of("planes.exr"));
    assert_int_equal(watch.live, 0);
    assert_int_equal(count_files(), 0);
}

/* ---- windows, channels and primaries ---- */

struct written {
    unsigned char bytes[8192];
    size_t size;
};

static void put(struct written *out, const void *bytes, size_t size) {
    assert_true(out->size + size <= sizeof out->bytes);
    memcpy(out->bytes + out->size, bytes, size);
    out->size += size;
}

static void put_attribute(struct written *out, const char *name, const char *type, const void *value, uint32_t size) {
    put(out, name, strlen(name) + 1);
    put(out, type, strlen(type) + 1);
    put(out, &size, 4);
    put(out, value, size);
}

/* Uncompressed floats by the format's description; `channels` in alphabetical order. Values: column + 100 row of the display window, + 1000 channel. */
static struct written write_exr(const char *channels, const int32_t data[4], const int32_t display[4], unsigned char compression, const float *primaries) {
    static const uint32_t start[2] = {20000630, 2};
    struct written out = {0}, list = {0};
    const uint32_t channel[4] = {2, 0, 1, 1};
    const float one = 1, middle[2] = {0, 0};
    const char zero = 0;
    put(&out, start, 8);
    for (const char *c = channels; *c; c++) {
        const char name[2] = {*c, 0};
        put(&list, name, 2);
        put(&list, channel, 16);
    }
    put(&list, &zero, 1);
    put_attribute(&out, "channels", "chlist", list.bytes, (uint32_t)list.size);
    if (primaries) put_attribute(&out, "chromaticities", "chromaticities", primaries, 32);
    put_attribute(&out, "compression", "compression", &compression, 1);
    put_attribute(&out, "dataWindow", "box2i", data, 16);
    put_attribute(&out, "displayWindow", "box2i", display, 16);
    put_attribute(&out, "lineOrder", "lineOrder", &zero, 1);
    put_attribute(&out, "pixelAspectRatio", "float", &one, 4);
    put_attribute(&out, "screenWindowCenter", "v2f", middle, 8);
    put_attribute(&out, "screenWindowWidth", "float", &one, 4);
    put(&out, &zero, 1);
    const int32_t rows = data[3] - data[1] + 1, bytes = (data[2] - data[0] + 1) * 4 * (int32_t)strlen(channels);
    const uint64_t first = out.size + 8 * (uint64_t)rows;
    for (int32_t y = 0; y < rows; y++) put(&out, &(uint64_t){first + (uint64_t)(y * (8 + bytes))}, 8);
    for (int32_t y = data[1]; y <= data[3]; y++) {
        put(&out, &y, 4);
        put(&out, &bytes, 4);
        for (const char *c = channels; *c; c++)
            for (int32_t x = data[0]; x <= data[2]; x++) {
                const float value = (float)(x - display[0] + 100 * (y - display[1])) + 1000 * (float)(c - channels);
                put(&out, &value, 4);
            }
    }
    return out;
}

/* The picture is the display window: overscan is cut, and what the data window leaves out is empty. */
static void test_exr_windows(void **state) {
    UNUSED(state);
    static const int32_t display[4] = {10, -5, 17, -2}, data[][4] = {{10, -5, 17, -2}, {6, -7, 21, 0}, {12, -4, 14, -3}, {4, -9, 12, -4}, {15, -3, 30, 2}, {40, 0, 41, 1}};
    for (uint32_t i = 0; i < COUNT_OF(data); i++)
        for (int alpha = 0; alpha < 2; alpha++) {
            struct watch watch;
            const fnl_host host = watch_host(&watch);
            const struct written file = write_exr(alpha ? "ABGR" : "BGR", data[i], display, 0, NULL);
            struct image_file_info info;
            fnl_image image;
            assert_int_equal(image_peek(&host, file.bytes, file.size, "windows", &info), FNL_OK);
            if (image_decode(&host, file.bytes, file.size, "windows", false, &image) != FNL_OK) fail_msg("%s", watch.line);
            assert_true(info.width == 8 && info.height == 4 && image.width == 8 && image.height == 4);
            for (int32_t y = 0; y < 4; y++)
                for (int32_t x = 0; x < 8; x++) {
                    const bool held = x + 10 >= data[i][0] && x + 10 <= data[i][2] && y - 5 >= data[i][1] && y - 5 <= data[i][3];
                    const float *pixel = (const float *)image.pixels + 4 * (y * 8 + x), at = (float)(x + 100 * y);
                    for (int c = 0; c < 3; c++)
                        if (pixel[c] != (held ? at + 1000 * (float)(2 - c + alpha) : 0)) fail_msg("window %u at %d, %d: %g", i, x, y, (double)pixel[c]);
                    assert_true(pixel[3] == (!alpha ? 1 : held ? at : 0));
                }
            fnl_image_free(&host, &image);
            assert_int_equal(watch.live, 0);
        }
    /* A header alone gets little memory. */
    static const int32_t small[4] = {0, 0, 3, 3}, large[4] = {0, 0, 32767, 8191};
    const struct written file = write_exr("BGR", small, large, 0, NULL);
    expect_late_refusal(file.bytes, file.size, FNL_ERROR_FORMAT, "cannot hold the 32768 x 8192 pixels");
}

static void test_exr_channels_that_are_missing(void **state) {
    UNUSED(state);
    static const int32_t window[4] = {0, 0, 1, 1};
    static const struct {
        const char *channels, *message;
    } cases[] = {{"R", "without the channels G, B, read as 0; it has R"}, {"GR", "without the channel B, read as 0; it has G, R"}, {"BGR", ""}, {"Y", ""}};
    for (uint32_t i = 0; i < COUNT_OF(cases); i++) {
        struct watch watch;
        const fnl_host host = watch_host(&watch);
        const struct written file = write_exr(cases[i].channels, window, window, 0, NULL);
        fnl_image image;
        assert_int_equal(image_decode(&host, file.bytes, file.size, "file", false, &image), FNL_OK);
        if (!strstr(watch.line, cases[i].message) || watch.lines != (cases[i].message[0] != 0)) fail_msg("%s: '%s'", cases[i].channels, watch.line);
        fnl_image_free(&host, &image);
    }
}

/* Where the library cannot read them, the line says so. */
static void test_exr_of_dwa(void **state) {
    UNUSED(state);
    static const int32_t window[4] = {0, 0, 15, 7};
    for (unsigned char compression = 8; compression < 10; compression++) {
        struct watch watch;
        const fnl_host host = watch_host(&watch);
        const struct written file = write_exr("BGR", window, window, compression, NULL);
        fnl_image image;
        const fnl_result result = image_decode(&host, file.bytes, file.size, "file", false, &image);
        assert_int_not_equal(result, FNL_OK);
        if (result == FNL_ERROR_UNSUPPORTED && !strstr(watch.line, compression == 8 ? "compressed as DWAA, which is not read; save it as ZIP" : "compressed as DWAB")) fail_msg("%s", watch.line);
    }
}

/* Against the matrix of ITU-R BT.2087 for Rec. 2020; white stays white whatever its color. */
static void test_primaries_become_those_of_rec709(void **state) {
    UNUSED(state);
    static const float wide[8] = {0.708f, 0.292f, 0.17f, 0.797f, 0.131f, 0.046f, 0.3127f, 0.329f}, own[8] = {0.64f, 0.33f, 0.3f, 0.6f, 0.15f, 0.06f, 0.3127f, 0.329f},
                       aces[8] = {0.713f, 0.293f, 0.165f, 0.83f, 0.128f, 0.044f, 0.32168f, 0.33767f}, flat[8] = {0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f, 0.3f};
    static const float rows[3][3] = {{1.6605f, -0.5876f, -0.0728f}, {-0.1246f, 1.1329f, -0.0083f}, {-0.0182f, -0.1006f, 1.1187f}};
    static const int32_t window[4] = {0, 0, 2, 1};
    struct watch watch;
    const fnl_host host = watch_host(&watch);
    fnl_image plain, image;
    struct written file = write_exr("BGR", window, window, 0, NULL);
    assert_int_equal(image_decode(&host, file.bytes, file.size, "file", false, &plain), FNL_OK);
    file = write_exr("BGR", window, window, 0, own);
    assert_int_equal(image_decode(&host, file.bytes, file.size, "file", false, &image), FNL_OK);
    assert_memory_equal(plain.pixels, image.pixels, 6 * 16);
    fnl_image_free(&host, &image);
    file = write_exr("BGR", window, window, 0, wide);
    assert_int_equal(image_decode(&host, file.bytes, file.size, "file", false, &image), FNL_OK);
    for (int i = 0; i < 6; i++)
        for (int c = 0; c < 3; c++) {
            const float *from = (const float *)plain.pixels + 4 * i, *to = (const float *)image.pixels + 4 * i;
            assert_float_equal(to[c], rows[c][0] * from[0] + rows[c][1] * from[1] + rows[c][2] * from[2], 0.3f);
        }
    fnl_image_free(&host, &image);
    fnl_image_free(&host, &plain);
    file = write_exr("BGR", window, window, 0, flat);
    expect_late_refusal(file.bytes, file.size, FNL_ERROR_FORMAT, "chromaticities");
    /* HDR: gray of the file's white, and its red. */
    const float *sets[] = {wide, aces};
    for (int k = 0; k < 2; k++) {
        char text[256];
        int used = snprintf(text, sizeof text, "#?RADIANCE\nPRIMARIES=");
        for (int i = 0; i < 8; i++) used += snprintf(text + used, sizeof text - (size_t)used, " %d.%05d", 0, (int)lrintf(sets[k][i] * 1e5f));
        used += snprintf(text + used, sizeof text - (size_t)used, "\n\n-Y 1 +X 2\n");
        memcpy(text + used, "\x80\x80\x80\x81\x80\0\0\x81", 8);
        assert_int_equal(image_decode(&host, text, (size_t)used + 8, "file", false, &image), FNL_OK);
        const float *pixels = image.pixels;
        for (int c = 0; c < 3; c++) assert_float_equal(pixels[c], 1, 1e-4f);
        if (k == 0) assert_true(fabsf(pixels[4] - 1.6605f) < 1e-3f && fabsf(pixels[5] + 0.1246f) < 1e-3f);
        fnl_image_free(&host, &image);
    }
    assert_int_equal(watch.live, 0);
}

static void test_failed_saves_leave_nothing(void **state) {
    UNUSED(state);
    struct watch watch;
    fnl_host host = watch_host(&watch);
    fnl_image bytes = make_image(64, 64, FNL_PIXEL_FORMAT_RGBA8, false, 1);
    fnl_image floats = make_image(64, 64, FNL_PIXEL_FORMAT_RGBA32F, false, 1);
    assert_int_equal(fnl_image_save(&host, path_of("a.png"), &floats), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_save(&host, path_of("a.exr"), &bytes), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_save(&host, path_of("a.hdr"), &bytes), FNL_ERROR_INVALID);
    assert_int_equal(fnl_image_save(&host, path_of("a.jpg"), &bytes), FNL_ERROR_UNSUPPORTED);
    assert_int_equal(fnl_image_save(&host, path_of("png"), &bytes), FNL_ERROR_UNSUPPORTED);
    assert_int_equal(fnl_image_save(&host, path_of("none/a.png"), &bytes), FNL_ERROR_FILE);
    assert_non_null(strstr(watch.line, "none/a.png"));
    bytes.width = 0;
    assert_int_equal(fnl_image_save(&host, path_of("a.png"), &bytes), FNL_ERROR_INVALID);
    bytes.width = 64;
    /* A folder has the name: found when the file is renamed. */
    assert_int_equal(mkdir(path_of("taken.png"), 0700), 0);
    assert_int_equal(mkdir(path_of("taken.exr"), 0700), 0);
    assert_int_equal(fnl_image_save(&host, path_of("taken.png"), &bytes), FNL_ERROR_FILE);
    assert_int_equal(fnl_image_save(&host, path_of("taken.exr"), &floats), FNL_ERROR_FILE);
    rmdir(path_of("taken.png"));
    rmdir(path_of("taken.exr"));
    fnl_image image;
    assert_int_equal(fnl_image_load(&host, path_of("missing.png"), &image), FNL_ERROR_FILE);
    assert_non_null(strstr(watch.line, "missing.png"));
    assert_int_equal(count_files(), 0);
    assert_int_equal(watch.live, 0);
    free(bytes.pixels);
    free(floats.pixels);
}

/* Every kind, on a disk that is full at once and in the middle: one line that names the file and the reason. */
static void test_saves_on_a_full_disk_leave_nothing(void **state) {
    UNUSED(state);
    static const rlim_t limits[] = {0, 100, 20000};
    struct watch watch;
    fnl_host host = watch_host(&watch);
    fnl_image bytes = make_image(256, 256, FNL_PIXEL_FORMAT_RGBA8, false, 1), floats = make_image(256, 256, FNL_PIXEL_FORMAT_RGBA32F, false, 1);
    const struct {
        const char *name;
        const fnl_image *image;
    } files[] = {{"a.png", &bytes}, {"a.exr", &floats}, {"a.hdr", &floats}};
    struct rlimit before, small;
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (size_t i = 0; i < COUNT_OF(files) * COUNT_OF(limits); i++) {
        char expected[1200];
        const char *path = path_of(files[i / COUNT_OF(limits)].name);
        small = before;
        small.rlim_cur = limits[i % COUNT_OF(limits)];
        watch.lines = 0;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
        const fnl_result result = fnl_image_save(&host, path, files[i / COUNT_OF(limits)].image);
        setrlimit(RLIMIT_FSIZE, &before);
        assert_int_equal(result, FNL_ERROR_FILE);
        snprintf(expected, sizeof expected, "%s: cannot be written: %s", path, strerror(EFBIG));
        assert_string_equal(watch.line, expected);
        assert_int_equal(watch.lines, 1);
        assert_int_equal(count_files(), 0);
    }
    /* A header larger than a stream's buffer, which OpenEXR writes under a lock. */
    static char names[100][200];
    fnl_exr_channel channels[100];
    for (int i = 0; i < 100; i++) {
        memset(names[i], 'a', 190);
        snprintf(names[i] + 190, 10, "%d", i);
        channels[i] = (fnl_exr_channel){names[i], floats.pixels, 1};
    }
    small = before;
    small.rlim_cur = 0;
    setrlimit(RLIMIT_FSIZE, &small);
    const fnl_result result = fnl_exr_save(&host, path_of("long.exr"), 4, 4, channels, 100);
    setrlimit(RLIMIT_FSIZE, &before);
    assert_int_equal(result, FNL_ERROR_FILE);
    assert_non_null(strstr(watch.line, "long.exr: cannot be written: File too large"));
    assert_int_equal(count_files(), 0);
    signal(SIGXFSZ, SIG_DFL);
    assert_int_equal(watch.live, 0);
    free(bytes.pixels);
    free(floats.pixels);
}

/* ---- pictures from other programs ---- */

/* A PNG that another encoder wrote: saved and read again it is the same. */
static fnl_image read_png(const void *bytes, size_t size, const char *name) {
    fnl_host host = host_resolve(NULL);
    fnl_image image, again;
    assert_int_equal(image_decode(&host, bytes, size, name, true, &image), FNL_OK);
    assert_int_equal(fnl_image_save(&host, path_of("again.png"), &image), FNL_OK);
    assert_int_equal(fnl_image_load(&host, path_of("again.png"), &again), FNL_OK);
    assert_true(near(&again, &image, 0));
    unlink(path_of("again.png"));
    fnl_image_free(&host, &again);
    return image;
}

static void test_real_png_files(void **state) {
    UNUSED(state);
    fnl_host host = host_resolve(NULL);
    const char *path = stand_in_sample("FlightHelmet");
    DIR *stream = path ? opendir(path) : NULL;
    char folder_path[1024], file[4096];
    snprintf(folder_path, sizeof folder_path, "%s", path ? path : "");
    uint64_t pixel_bytes = 0, file_bytes = 0;
    for (struct dirent *entry; stream && (entry = readdir(stream));) {
        if (!path_has_extension(entry->d_name, "png")) continue;
        snprintf(file, sizeof file, "%s/%s", folder_path, entry->d_name);
        struct file_view view;
        assert_int_equal(file_load(&host, file, &view), FNL_OK);
        fnl_image image = read_png(view.data, view.size, file);
        file_bytes += view.size;
        pixel_bytes += (uint64_t)image.width * image.height * 4;
        file_free(&host, &view);
        fnl_image_free(&host, &image);
    }
    if (stream) {
        closedir(stream);
        assert_true(pixel_bytes > 0);
        print_message("FlightHelmet: %.1f MB of PNG to %.1f MB of pixels\n", (double)file_bytes * 1e-6, (double)pixel_bytes * 1e-6);
    }
    /* Stand-ins, whose pixels are known; 151 pixels a row, and more than one deflate block. */
    for (uint32_t kind = 0; kind <= STAND_IN_DIRECTIONS; kind++) {
        fnl_image made = stand_in_picture((enum stand_in_texture)kind, 151, kind);
        size_t size;
        unsigned char *png = stand_in_png(&made, &size);
        fnl_image image = read_png(png, size, "stand-in.png");
        assert_true(image.format == FNL_PIXEL_FORMAT_RGBA8 && near(&image, &made, 0));
        free(png), free(made.pixels);
        fnl_image_free(&host, &image);
    }
}

/* A panorama that another program wrote. */
static void check_hdr(const fnl_image *image) {
    assert_int_equal(image->width, 1024);
    assert_int_equal(image->height, 512);
    double halves[2] = {0}, sun = 0;
    for (size_t i = 0; i < 1024 * 512; i++) {
        const float *pixel = (const float *)image->pixels + i * 4;
        assert_true(isfinite(pixel[0]) && pixel[0] >= 0 && pixel[3] == 1);
        halves[i / (1024 * 256)] += (double)(pixel[0] + pixel[1] + pixel[2]);
        sun = fmax(sun, (double)pixel[0]);
    }
    assert_true(halves[0] > halves[1]); /* sky over beach */
    assert_true(sun > 100);
    round_trip("beach.hdr", image, 0.5 / 127);
}

static void test_real_hdr_file(void **state) {
    UNUSED(state);
    static const char name[] = "spiaggia_di_mondello_1k.hdr";
    fnl_host host = host_resolve(NULL);
    const char *path = stand_in_sample(name);
    fnl_image image, made = stand_in_panorama(name);
    if (path) {
        assert_int_equal(fnl_image_load(&host, path, &image), FNL_OK);
        check_hdr(&image);
        fnl_image_free(&host, &image);
    }
    size_t size;
    unsigned char *hdr = stand_in_hdr(&made, &size);
    assert_int_equal(image_decode(&host, hdr, size, name, false, &image), FNL_OK);
    check_hdr(&image);
    /* RGBE truncates to 8-bit mantissas that share the largest exponent. */
    for (size_t i = 0; i < 1024 * 512; i++) {
        const float *want = (const float *)made.pixels + i * 4, *got = (const float *)image.pixels + i * 4;
        for (int c = 0; c < 3; c++) assert_true(fabsf(got[c] - want[c]) <= fmaxf(want[0], fmaxf(want[1], want[2])) / 128);
    }
    free(hdr), free(made.pixels);
    fnl_image_free(&host, &image);
}

/* With FANAL_SAMPLES set to a folder the samples are written there: seeds for the fuzzer. */
static int write_samples(const char *target) {
    fnl_host host = host_resolve(NULL);
    struct image_sample samples[IMAGE_SAMPLES_MAX];
    uint32_t count = image_samples_make(samples, 9, 3);
    int failures = 0;
    for (uint32_t i = 0; i < count; i++) {
        char path[4096];
        snprintf(path, sizeof path, "%s/%s", target, samples[i].name);
        failures += file_save(&host, path, samples[i].bytes, samples[i].size) != FNL_OK;
    }
    image_samples_free(samples, count);
    return failures;
}

int main(void) {
    if (getenv("FANAL_SAMPLES")) return write_samples(getenv("FANAL_SAMPLES"));
    snprintf(folder, sizeof folder, "/tmp/fanal-image-test-XXXXXX");
    if (!mkdtemp(folder)) return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_kind_is_read),
        cmocka_unit_test(test_forced_to_8_bits),
        cmocka_unit_test(test_files_cut_at_every_byte),
        cmocka_unit_test(test_damaged_files_do_no_harm),
        cmocka_unit_test(test_impossible_sizes_are_refused),
        cmocka_unit_test(test_unknown_and_unsupported_contents),
        cmocka_unit_test(test_decoders_run_in_parallel),
        cmocka_unit_test(test_what_is_saved_is_read_again),
        cmocka_unit_test(test_hdr_splits_long_runs),
        cmocka_unit_test(test_exr_keeps_what_is_not_finite),
        cmocka_unit_test(test_exr_that_does_not_shrink),
        cmocka_unit_test(test_hdr_clamps_what_it_cannot_hold),
        cmocka_unit_test(test_png_says_srgb_and_drops_full_alpha),
        cmocka_unit_test(test_exr_planes),
        cmocka_unit_test(test_exr_windows),
        cmocka_unit_test(test_exr_channels_that_are_missing),
        cmocka_unit_test(test_exr_of_dwa),
        cmocka_unit_test(test_primaries_become_those_of_rec709),
        cmocka_unit_test(test_failed_saves_leave_nothing),
        cmocka_unit_test(test_saves_on_a_full_disk_leave_nothing),
        cmocka_unit_test(test_real_png_files),
        cmocka_unit_test(test_real_hdr_file),
    };
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    rmdir(folder);
    return failures;
}
