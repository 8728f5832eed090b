/* SPDX-License-Identifier: MIT */
/* The scene's environment on the device, and what is kept of it between runs: a file for each picture, named by its content. */
#include "render/device/scene.h"

#define KEPT_STEM "environment-"
enum { KEPT_BYTES_MOST = 256 << 20 }; /* of all such files in the folder */

/* In front of the bytes of environment_kept_bytes(). */
struct kept_header {
    char magic[8];
    uint64_t key, size, hash; /* size and hash of what follows */
};
static const char kept_magic[8] = "FNLENVI1";
enum { PIECE = 1 << 18 }; /* bytes that are hashed, and read, at once */

/* ---- files ---- */

static bool is_compressed(const struct device_scene *d) { return d->scene->environment.compressed && gpu_info(d->device)->texture_compression; }

/* Of all that the maps depend on; bright sources have left the picture by now. */
static uint64_t key_of(const struct device_scene *d, const struct panorama *p) {
    const uint64_t parts[] = {environment_version(), p->width, p->height, is_compressed(d)};
    const uint64_t start = hash_bytes(parts, sizeof parts, HASH_SEED), unit = hash_bytes(&d->scene->environment.unit, sizeof(float), start);
    return hash_bytes(p->texels, (size_t)p->width * p->height * 3 * sizeof(float), unit);
}

static void name_kept(uint64_t key, char out[40]) { snprintf(out, 40, KEPT_STEM "%016llx", (unsigned long long)key); }

/* Of the bytes that follow the header. */
static bool read_kept(FILE *file, unsigned char *piece, const struct kept_header *header, unsigned char *out) {
    uint64_t hash = header->key;
    for (uint64_t at = 0; at < header->size; at += PIECE) {
        const size_t size = (size_t)MIN(header->size - at, (uint64_t)PIECE);
        if (fread(piece, 1, size, file) != size) return false;
        hash = hash_bytes(piece, size, hash);
        memcpy(out + at, piece, size); /* memory for the device, which it may be slow to read from */
    }
    return hash == header->hash && fgetc(file) == EOF;
}

/* Takes the maps from a file, if there is one that is whole. */
static fnl_result take_kept(struct device_scene *d, FILE *file, uint32_t side) {
    struct kept_header header;
    const uint64_t size = environment_kept_bytes(side, is_compressed(d));
    if (fread(&header, 1, sizeof header, file) != sizeof header || memcmp(header.magic, kept_magic, sizeof kept_magic) != 0 ||
        header.key != d->environment_key || header.size != size)
        return FNL_OK;
    TRY(environment_prepare_kept(d->device, side, is_compressed(d), &d->environment));
    unsigned char *piece = host_allocate(&d->host, PIECE);
    if (!piece) return FNL_ERROR_MEMORY;
    d->environment.is_kept = read_kept(file, piece, &header, d->environment.kept.mapped);
    host_free(&d->host, piece, PIECE);
    return FNL_OK;
}

static fnl_result find_kept(struct device_scene *d, uint32_t side) {
    char name[40];
    name_kept(d->environment_key, name);
    FILE *file = gpu_cache_open(d->device, name);
    if (!file) return FNL_OK;
    const fnl_result result = take_kept(d, file, side);
    fclose(file);
    if (result == FNL_OK && !d->environment.is_kept) log_debug(&d->host, "%s: what was kept of an environment is damaged; it is made anew", name);
    return result;
}

static void save_kept(struct device_scene *d) {
    const struct gpu_buffer *kept = &d->environment.kept;
    const uint64_t bytes = kept->size;
    struct kept_header header = {.key = d->environment_key, .size = bytes, .hash = d->environment_key};
    const size_t size = sizeof header + (size_t)bytes;
    unsigned char *whole = host_allocate(&d->host, size);
    char name[40];
    if (!whole) return;
    memcpy(whole + sizeof header, kept->mapped, (size_t)bytes);
    for (uint64_t at = 0; at < bytes; at += PIECE) header.hash = hash_bytes(whole + sizeof header + at, (size_t)MIN(bytes - at, (uint64_t)PIECE), header.hash);
    memcpy(header.magic, kept_magic, sizeof kept_magic);
    memcpy(whole, &header, sizeof header);
    name_kept(d->environment_key, name);
    gpu_cache_save(d->device, name, whole, size);
    gpu_cache_trim(d->device, KEPT_STEM, KEPT_BYTES_MOST);
    host_free(&d->host, whole, size);
}

/* What a frame has left in `kept` goes into a file. Not before that frame is over: `wait` for it, or come again. */
static bool keep(struct device_scene *d, bool wait) {
    const uint64_t frame = d->sent.environment_frame;
    if (frame == 0) return true;
    if (!wait && frame + GPU_FRAMES_IN_FLIGHT > gpu_frame_number(d->device)) return false;
    if (gpu_frame_wait(d->device, frame) == FNL_OK && d->environment.kept.handle) save_kept(d);
    d->sent.environment_frame = 0;
    return true;
}

/* ---- outside of frames ---- */

static fnl_result send_picture(struct device_scene *d, const struct panorama *p) {
    const size_t count = (size_t)p->width * p->height, bytes = count * 4 * sizeof(uint16_t);
    const uint16_t one = half_from_float(1);
    const float scale = 1 / d->scene->environment.unit;
    uint16_t *pixels = host_allocate(&d->host, bytes);
    if (!pixels) return FNL_ERROR_MEMORY;
    for (size_t i = 0; i < count; i++) {
        for (size_t c = 0; c < 3; c++) pixels[4 * i + c] = half_from_float(p->texels[3 * i + c] * scale);
        pixels[4 * i + 3] = one;
    }
    const fnl_result result = environment_prepare(d->device, pixels, p->width, p->height, is_compressed(d), &d->environment);
    host_free(&d->host, pixels, bytes);
    d->bytes_uploaded += bytes;
    return result;
}

static fnl_result prepare(struct device_scene *d, const struct panorama *p) {
    const bool keeps = gpu_cache_has_folder(d->device);
    environment_release(d->device, &d->environment); /* what another picture may have left */
    if (keeps) {
        d->environment_key = key_of(d, p);
        TRY(find_kept(d, environment_side(p->width)));
        if (d->environment.is_kept) return FNL_OK;
    }
    TRY(send_picture(d, p));
    return keeps ? environment_keep(d->device, &d->environment) : FNL_OK;
}

static bool needs_table(const struct device_scene *d) { return d->conserves || device_has_layers(d) || scene_has_reflections(d->scene); }

fnl_result device_environment_prepare(struct device_scene *d) {
    const struct scene_environment *e = &d->scene->environment;
    if (e->panorama.width == 0 && needs_table(d)) TRY(environment_prepare_table(d->device, &d->environment));
    if (d->environment_version == e->version) {
        if (d->sent.environment == e->version && keep(d, false)) environment_release(d->device, &d->environment);
        return FNL_OK;
    }
    keep(d, true);
    d->environment_version = d->sent.environment = UINT64_MAX;
    if (e->panorama.width > 0) TRY(prepare(d, &e->panorama));
    d->environment_version = e->version;
    return FNL_OK;
}

void device_environment_finish(struct device_scene *d) {
    keep(d, true);
    environment_finish_maps(d->device, &d->environment);
    d->environment_version = UINT64_MAX;
    d->sent.table = false;
}

/* ---- inside a frame ---- */

struct environment_light device_environment_add(struct device_scene *d, struct graph *graph) {
    const struct scene_environment *e = &d->scene->environment;
    d->environment_made = DEVICE_ENVIRONMENT_THERE;
    if (e->panorama.width == 0) {
        if (!needs_table(d)) return (struct environment_light){0};
        const bool fill = !d->sent.table;
        d->sent.table = true;
        return environment_add_table(graph, &d->environment, fill);
    }
    const bool make = d->sent.environment != e->version;
    d->sent.environment = e->version;
    d->sent.table |= make;
    if (make) {
        d->environment_made = d->environment.is_kept ? DEVICE_ENVIRONMENT_KEPT : DEVICE_ENVIRONMENT_FILTERED;
        d->sent.environment_frame = !d->environment.is_kept && d->environment.kept.handle ? gpu_frame_number(d->device) : 0;
    }
    return environment_add(graph, d->device, &d->environment, make);
}
