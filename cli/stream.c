/* SPDX-License-Identifier: MIT */
#include "stream.h"

#include "print.h"

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static int descriptor = -1;
static uint64_t bytes_written, pictures_written;
static bool failed;

bool stream_open(void) {
    fflush(stdout);
    signal(SIGPIPE, SIG_IGN);
    descriptor = fcntl(STDOUT_FILENO, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
    if (descriptor >= 0 && dup2(STDERR_FILENO, STDOUT_FILENO) == STDOUT_FILENO) return true;
    fprintf(stderr, "fanal: error: the standard output cannot be used: %s\n", strerror(errno));
    return false;
}

static bool fail(int reason) {
    if (!failed && reason == EPIPE)
        fprintf(stderr, "fanal: error: the standard output was closed by its reader after %llu bytes, %llu whole pictures\n",
                (unsigned long long)bytes_written, (unsigned long long)pictures_written);
    else if (!failed)
        fprintf(stderr, "fanal: error: the standard output cannot be written: %s\n", strerror(reason));
    failed = true;
    return false;
}

bool stream_write(const void *bytes, size_t size) {
    for (const char *next = bytes; size > 0 && !failed;) {
        ssize_t count = write(descriptor, next, size);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return fail(errno);
        next += count;
        size -= (size_t)count;
        bytes_written += (uint64_t)count;
    }
    return !failed;
}

bool stream_file(const char *path) {
    FILE *file = fopen(path, "rb");
    char block[1 << 16];
    bool good = file != NULL || fail(errno);
    for (size_t got; good && (got = fread(block, 1, sizeof block, file)) > 0;) good = stream_write(block, got);
    if (good && ferror(file)) good = fail(EIO);
    if (file) fclose(file);
    pictures_written += good;
    return good;
}

bool stream_raw(const fnl_image *picture) {
    bool good = stream_write(picture->pixels, (size_t)picture->width * picture->height * 4);
    pictures_written += good;
    return good;
}

/* Halves upwards, for negative numbers too; divisor > 0. */
static int64_t divide(int64_t value, int64_t divisor) {
    int64_t twice = 2 * value + divisor, whole = twice / (2 * divisor);
    return whole - (twice % (2 * divisor) < 0);
}

size_t y4m_size(uint32_t width, uint32_t height, enum y4m_chroma chroma) {
    const size_t count = (size_t)width * height;
    return chroma == Y4M_420 ? count + count / 2 : 3 * count;
}

void y4m_convert(const uint8_t *pixels, uint32_t width, uint32_t height, enum y4m_chroma chroma, uint8_t *planes) {
    const uint32_t side = chroma == Y4M_420 ? 2 : 1, area = side * side; /* of the pixels that share their chroma */
    const size_t count = (size_t)width * height;
    uint8_t *blue = planes + count, *red = blue + count / area;
    for (size_t i = 0; i < count; i++) {
        const uint8_t *p = pixels + 4 * i;
        planes[i] = (uint8_t)(16 + divide(219 * (2126 * p[0] + 7152 * p[1] + 722 * p[2]), 255 * 10000));
    }
    for (uint32_t y = 0; y < height; y += side)
        for (uint32_t x = 0; x < width; x += side) {
            int64_t sum[3] = {0};
            for (uint32_t k = 0; k < area; k++) {
                const uint8_t *p = pixels + 4 * ((size_t)(y + k / side) * width + x + k % side);
                for (int c = 0; c < 3; c++) sum[c] += p[c];
            }
            const int64_t luma = 2126 * sum[0] + 7152 * sum[1] + 722 * sum[2]; /* 0 .. area * 255 * 10000 */
            *blue++ = (uint8_t)(128 + divide(224 * (10000 * sum[2] - luma), (int64_t)area * 255 * 18556));
            *red++ = (uint8_t)(128 + divide(224 * (10000 * sum[0] - luma), (int64_t)area * 255 * 15748));
        }
}

/* Frames a second as a fraction: whole, or as television has them, N * 1000 / 1001, or the first that comes near enough. */
static void find_rate(double frame_time, uint32_t *numerator, uint32_t *denominator) {
    double rate = frame_time > 0 ? fmin(fmax(1 / frame_time, 1e-3), 1e6) : 30;
    const double near = 2e-6, television = floor(rate * 1.001 + 0.5);
    if (fabs(rate * 1.001 / fmax(television, 1) - 1) < near) {
        *numerator = (uint32_t)television * 1000;
        *denominator = 1001;
        return;
    }
    for (*denominator = 1; *denominator <= 1001; ++*denominator) {
        double whole = fmax(floor(rate * *denominator + 0.5), 1);
        *numerator = (uint32_t)whole;
        if (fabs(whole / (rate * *denominator) - 1) < near) return;
    }
    *denominator = 1001;
}

void y4m_header(char *text, size_t capacity, uint32_t width, uint32_t height, enum y4m_chroma chroma, double frame_time) {
    uint32_t numerator, denominator;
    find_rate(frame_time, &numerator, &denominator);
    snprintf(text, capacity, "YUV4MPEG2 W%u H%u F%u:%u Ip A1:1 C%s XCOLORRANGE=LIMITED\n", width, height, numerator, denominator,
             chroma == Y4M_420 ? "420jpeg" : "444");
}

bool y4m_check_size(uint32_t width, uint32_t height, enum y4m_chroma chroma) {
    const uint32_t even_width = width + width % 2, even_height = height + height % 2;
    if (chroma == Y4M_444 || (even_width == width && even_height == height)) return true;
    fprintf(stderr, "fanal: error: --size: y4m requires an even width and height, not %ux%u: use %ux%u, or --format y4m444 for any size\n", width, height,
            even_width, even_height);
    return false;
}

bool stream_y4m(const fnl_image *picture, enum y4m_chroma chroma, double frame_time) {
    static const char frame[] = "FRAME\n";
    char header[128] = "";
    if (!y4m_check_size(picture->width, picture->height, chroma)) return false;
    const size_t size = y4m_size(picture->width, picture->height, chroma);
    uint8_t *planes = malloc(size);
    if (!planes) return fail(ENOMEM);
    y4m_convert(picture->pixels, picture->width, picture->height, chroma, planes);
    if (pictures_written == 0) y4m_header(header, sizeof header, picture->width, picture->height, chroma, frame_time);
    bool good = stream_write(header, strlen(header)) && stream_write(frame, strlen(frame)) && stream_write(planes, size);
    free(planes);
    pictures_written += good;
    return good;
}
