/* SPDX-License-Identifier: MIT */
/*
 * Headers of OpenEXR: data and display windows, channels, sampling, chromaticities, compression. A header that is whole gives the picture that it
 * describes, pixel by pixel; with some of its bytes changed, a picture of the size that it says, or an error.
 */
#include "base/maths.h"
#include "image/image.h"
#include "tests/fuzz/fuzz.h"

enum { CAPACITY = 65536, CHANNELS = 5, SIDE_MOST = 12, NONE = 0 };

struct writer {
    uint8_t bytes[CAPACITY];
    size_t size;
};

static void put(struct writer *w, const void *bytes, size_t size) {
    if (size > sizeof w->bytes - w->size) abort();
    memcpy(w->bytes + w->size, bytes, size);
    w->size += size;
}

static void put_i32(struct writer *w, int32_t value) { put(w, &value, sizeof value); }

static void put_attribute(struct writer *w, const char *name, const char *type, const void *value, size_t size) {
    put(w, name, strlen(name) + 1);
    put(w, type, strlen(type) + 1);
    put_i32(w, (int32_t)size);
    put(w, value, size);
}

struct channel {
    const char *name;
    int32_t type; /* 0 uint, 1 half, 2 float */
    int32_t sampling;
};

struct header {
    int32_t data[4], display[4];
    struct channel channels[CHANNELS];
    uint32_t channel_count;
    uint8_t compression;
    bool chromatic;
    float primaries[8];
};

static void take_window(struct fuzz_input *in, int32_t out[4]) {
    out[0] = (int8_t)fuzz_byte(in);
    out[1] = (int8_t)fuzz_byte(in);
    out[2] = out[0] + fuzz_byte(in) % 13 - 1;
    out[3] = out[1] + fuzz_byte(in) % 13 - 1;
    if (fuzz_byte(in) != 255) return;
    const uint8_t edge = fuzz_byte(in) % 4;
    out[edge] = (int32_t)fuzz_u32(in);
}

static void take_header(struct fuzz_input *in, struct header *h) {
    static const char *const names[] = {"A", "B", "BY", "G", "R", "RY", "Y", "Z"}; /* sorted, as the format wants */
    memset(h, 0, sizeof *h);
    take_window(in, h->data);
    take_window(in, h->display);
    if (fuzz_byte(in) % 2) memcpy(h->display, h->data, sizeof h->data);
    const uint8_t chosen = fuzz_byte(in);
    for (size_t i = 0; i < COUNT_OF(names) && h->channel_count < CHANNELS; i++) {
        if (!(chosen >> i & 1)) continue;
        const uint8_t kind = fuzz_byte(in);
        h->channels[h->channel_count++] = (struct channel){names[i], kind % 4 == 3 ? (int32_t)(kind / 4) : kind % 4, kind >= 250 ? kind - 248 : 1};
    }
    const uint8_t how = fuzz_byte(in);
    h->compression = how < 128 ? NONE : how % 12;
    h->chromatic = how & 64;
    if (h->chromatic) fuzz_floats(in, h->primaries, 8);
}

static uint32_t element_size(const struct channel *c) { return c->type == 1 ? 2 : 4; }

static uint32_t stored(const struct channel *c, int32_t x, int32_t y, uint32_t index) {
    const uint32_t value = (uint32_t)(x + 16 * y) + 256 * index;
    const float number = (float)value;
    uint32_t bits;
    memcpy(&bits, &number, sizeof bits);
    return c->type == 1 ? 0x3000 + value % 1024 : c->type == 2 ? bits : value;
}

static float shown(const struct channel *c, uint32_t bits) {
    float number;
    memcpy(&number, &bits, sizeof number);
    return c->type == 1 ? half_to_float((uint16_t)bits) : c->type == 2 ? number : (float)bits;
}

static void write_header(struct writer *w, const struct header *h) {
    static struct writer channels;
    struct writer *list = &channels;
    const float one = 1, middle[2] = {0, 0};
    const uint8_t increasing = 0;
    list->size = 0;
    put_i32(w, 20000630);
    put_i32(w, 2);
    for (uint32_t i = 0; i < h->channel_count; i++) {
        put(list, h->channels[i].name, strlen(h->channels[i].name) + 1);
        put_i32(list, h->channels[i].type);
        put_i32(list, 0);
        put_i32(list, h->channels[i].sampling);
        put_i32(list, h->channels[i].sampling);
    }
    put(list, "", 1);
    put_attribute(w, "channels", "chlist", list->bytes, list->size);
    if (h->chromatic) put_attribute(w, "chromaticities", "chromaticities", h->primaries, sizeof h->primaries);
    put_attribute(w, "compression", "compression", &h->compression, 1);
    put_attribute(w, "dataWindow", "box2i", h->data, sizeof h->data);
    put_attribute(w, "displayWindow", "box2i", h->display, sizeof h->display);
    put_attribute(w, "lineOrder", "lineOrder", &increasing, 1);
    put_attribute(w, "pixelAspectRatio", "float", &one, sizeof one);
    put_attribute(w, "screenWindowCenter", "v2f", middle, sizeof middle);
    put_attribute(w, "screenWindowWidth", "float", &one, sizeof one);
    put(w, "", 1);
}

/* A row in a chunk, which is what files without compression have. */
static void write_rows(struct writer *w, const struct header *h, int32_t width, int32_t height) {
    uint32_t row = 0;
    for (uint32_t i = 0; i < h->channel_count; i++) row += (uint32_t)width * element_size(&h->channels[i]);
    for (int32_t y = 0; y < height; y++) {
        const uint64_t place = w->size + 8 * (uint64_t)(height - y) + (uint64_t)y * (8 + row);
        put(w, &place, sizeof place);
    }
    for (int32_t y = 0; y < height; y++) {
        put_i32(w, h->data[1] + y);
        put_i32(w, (int32_t)row);
        for (uint32_t i = 0; i < h->channel_count; i++)
            for (int32_t x = 0; x < width; x++) {
                const uint32_t bits = stored(&h->channels[i], x, y, i);
                put(w, &bits, element_size(&h->channels[i]));
            }
    }
}

static const struct channel *find(const struct header *h, const char *name) {
    for (uint32_t i = 0; i < h->channel_count; i++)
        if (strcmp(h->channels[i].name, name) == 0) return &h->channels[i];
    return NULL;
}

/* Whether the file is one that is read: nothing but what the header says decides it. */
static bool readable(const struct header *h) {
    const bool color = find(h, "R") || find(h, "G") || find(h, "B");
    for (uint32_t i = 0; i < h->channel_count; i++)
        if (h->channels[i].type > 2 || h->channels[i].sampling != 1) return false;
    for (int c = 0; c < 2; c++) {
        const int64_t data = (int64_t)h->data[c + 2] - h->data[c] + 1, display = (int64_t)h->display[c + 2] - h->display[c] + 1;
        if (data < 1 || data > SIDE_MOST || display < 1 || display > 1000) return false;
    }
    return h->compression == NONE && (color || (find(h, "Y") && !find(h, "RY") && !find(h, "BY")));
}

static void check_pixels(const struct header *h, const fnl_image *image) {
    static const char *const colors[] = {"R", "G", "B"};
    const bool color = find(h, "R") || find(h, "G") || find(h, "B");
    if ((int32_t)image->width != h->display[2] - h->display[0] + 1 || (int32_t)image->height != h->display[3] - h->display[1] + 1) abort();
    const float *pixel = image->pixels;
    for (int32_t y = h->display[1]; y <= h->display[3]; y++)
        for (int32_t x = h->display[0]; x <= h->display[2]; x++, pixel += 4)
            for (int c = 0; c < 3; c++) {
                const struct channel *channel = find(h, color ? colors[c] : "Y");
                const bool inside = x >= h->data[0] && x <= h->data[2] && y >= h->data[1] && y <= h->data[3] && channel;
                const float expected = inside ? shown(channel, stored(channel, x - h->data[0], y - h->data[1], (uint32_t)(channel - h->channels))) : 0;
                if (pixel[c] != expected) abort();
            }
}

int LLVMFuzzerTestOneInput(const uint8_t *bytes, size_t size) {
    static struct writer w;
    struct fuzz_input in = {bytes, size};
    struct header h;
    fnl_host host = fuzz_host();
    struct image_file_info info;
    fnl_image image = {0};
    w.size = 0;
    take_header(&in, &h);
    write_header(&w, &h);
    const int64_t width = (int64_t)h.data[2] - h.data[0] + 1, height = (int64_t)h.data[3] - h.data[1] + 1;
    if (width > 0 && height > 0 && width <= SIDE_MOST && height <= SIDE_MOST) write_rows(&w, &h, (int32_t)width, (int32_t)height);
    bool whole = true;
    for (uint32_t changes = fuzz_byte(&in) % 8; changes > 0 && in.size > 0; changes--, whole = false) {
        const uint32_t place = fuzz_u32(&in) % (uint32_t)w.size;
        w.bytes[place] = fuzz_byte(&in);
    }
    if (image_peek(&host, w.bytes, w.size, "input", &info) != FNL_OK) {
        if (whole && readable(&h)) abort();
        return 0;
    }
    if ((uint64_t)info.width * info.height > 1u << 20) return 0; /* larger pictures are slow, not different */
    const fnl_result result = image_decode(&host, w.bytes, w.size, "input", false, &image);
    if (result != FNL_OK && image.pixels) abort();
    if (result != FNL_OK && whole && readable(&h) && !h.chromatic) abort();
    if (result == FNL_OK && (image.width != info.width || image.height != info.height)) abort();
    if (result == FNL_OK && whole && readable(&h) && !h.chromatic) check_pixels(&h, &image);
    if (result == FNL_OK) fnl_image_free(&host, &image);
    return 0;
}
