/* SPDX-License-Identifier: MIT */
/* OpenEXR through the C library OpenEXRCore. */
#include "base/maths.h"
#include "image/codec.h"

#include <errno.h>
#include <openexr.h>

/* ZIP_LEVEL and COMPRESSION shape the bytes that are written; fixed here, not by the library's defaults. */
#define ZIP_LEVEL 4
#define COMPRESSION EXR_COMPRESSION_ZIP
#define CHANNEL_NAME_MAX 255 /* of the format's long names; the short ones end at 31 */

/* What the library's callbacks work on: a file in memory that is read, or a stream that is written. */
struct stream {
    const unsigned char *bytes;
    size_t size;
    FILE *file;
    uint64_t position;
    char message[256]; /* the first error */
};

/* The stream of this thread. The library reports errors with a lock of the context held, under which the context cannot be asked for its user data. */
static _Thread_local struct stream *current;

static void keep_message(exr_const_context_t exr, exr_result_t code, const char *message) {
    UNUSED(exr);
    if (current && !current->message[0])
        snprintf(current->message, sizeof current->message, "%s", message ? message : exr_get_default_error_message(code));
}

static const char *message_of(const struct stream *stream, exr_result_t code) {
    return stream->message[0] ? stream->message : exr_get_default_error_message(code);
}

/* ---- reading ---- */

static int64_t read_bytes(exr_const_context_t exr, void *user, void *buffer, uint64_t size, uint64_t offset,
                          exr_stream_error_func_ptr_t fail) {
    UNUSED(exr);
    UNUSED(fail);
    const struct stream *stream = user;
    if (offset >= stream->size) return 0;
    uint64_t count = MIN(size, stream->size - offset);
    memcpy(buffer, stream->bytes + offset, (size_t)count);
    return (int64_t)count;
}

static int64_t query_size(exr_const_context_t exr, void *user) {
    UNUSED(exr);
    return (int64_t)((const struct stream *)user)->size;
}

/* One open file: its first part. The picture is the display window; what the data window leaves of it is empty. */
struct reader {
    const struct image_source *source;
    struct stream stream;
    exr_context_t exr;
    exr_storage_t storage;
    exr_compression_t compression;
    int32_t x, y; /* upper left corner of the data window */
    uint32_t width, height;
    int64_t left, top; /* of the data window in the picture; may be negative */
    uint32_t picture_width, picture_height;
    char names[400]; /* of the channels */
};

static fnl_result fail(struct reader *reader, exr_result_t code) {
    const bool dwa = reader->compression == EXR_COMPRESSION_DWAA || reader->compression == EXR_COMPRESSION_DWAB;
    if (dwa && code == EXR_ERR_FEATURE_NOT_IMPLEMENTED)
        return image_fail(reader->source, FNL_ERROR_UNSUPPORTED, "is an EXR compressed as %s, which is not read; save it as ZIP, PIZ or uncompressed",
                          reader->compression == EXR_COMPRESSION_DWAA ? "DWAA" : "DWAB");
    fnl_result result = code == EXR_ERR_OUT_OF_MEMORY             ? FNL_ERROR_MEMORY
                        : code == EXR_ERR_FEATURE_NOT_IMPLEMENTED ? FNL_ERROR_UNSUPPORTED
                                                                  : FNL_ERROR_FORMAT;
    return image_fail(reader->source, result, "%s EXR: %s", result == FNL_ERROR_FORMAT ? "broken" : "unreadable",
                      message_of(&reader->stream, code));
}

static fnl_result read_header(struct reader *reader) {
    current = &reader->stream;
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = keep_message;
    start.user_data = &reader->stream;
    start.read_fn = read_bytes;
    start.size_fn = query_size;
    /* A table of chunks that is not there must be an error, not a reason to search for what is left. */
    start.flags = EXR_CONTEXT_FLAG_DISABLE_CHUNK_RECONSTRUCTION;
    exr_result_t error = exr_start_read(&reader->exr, reader->source->name, &start);
    if (!error) error = exr_get_storage(reader->exr, 0, &reader->storage);
    if (!error && (reader->storage == EXR_STORAGE_DEEP_SCANLINE || reader->storage == EXR_STORAGE_DEEP_TILED))
        return image_fail(reader->source, FNL_ERROR_UNSUPPORTED, "is a deep EXR, which is not read; flatten it first");
    exr_attr_box2i_t window = {0}, display = {0};
    if (!error) error = exr_get_compression(reader->exr, 0, &reader->compression);
    if (!error) error = exr_get_data_window(reader->exr, 0, &window);
    if (!error) error = exr_get_display_window(reader->exr, 0, &display);
    if (error) return fail(reader, error);
    int64_t width = (int64_t)window.max.x - window.min.x + 1, height = (int64_t)window.max.y - window.min.y + 1;
    TRY(image_check_size(reader->source, (uint64_t)MAX(width, 0), (uint64_t)MAX(height, 0)));
    reader->x = window.min.x;
    reader->y = window.min.y;
    reader->width = (uint32_t)width;
    reader->height = (uint32_t)height;
    width = (int64_t)display.max.x - display.min.x + 1;
    height = (int64_t)display.max.y - display.min.y + 1;
    TRY(image_check_size(reader->source, (uint64_t)MAX(width, 0), (uint64_t)MAX(height, 0)));
    reader->left = (int64_t)window.min.x - display.min.x;
    reader->top = (int64_t)window.min.y - display.min.y;
    reader->picture_width = (uint32_t)width;
    reader->picture_height = (uint32_t)height;
    return FNL_OK;
}

fnl_result image_exr_peek(const struct image_source *source, struct image_file_info *out) {
    struct reader reader = {.source = source, .stream = {.bytes = source->bytes, .size = source->size}};
    fnl_result result = read_header(&reader);
    exr_finish(&reader.exr);
    current = NULL;
    if (result == FNL_OK) *out = (struct image_file_info){.kind = IMAGE_FILE_EXR, .width = reader.picture_width, .height = reader.picture_height, .pixel_bytes = 16};
    return result;
}

/* Most bytes that one stored byte can stand for. DWA keeps one value of 64 under deflate, deflate gives 1032 for one,
   and the other schemes stay below. */
static uint64_t ratio_max(exr_compression_t compression) {
    switch (compression) {
    case EXR_COMPRESSION_NONE:
        return 1;
    case EXR_COMPRESSION_DWAA:
    case EXR_COMPRESSION_DWAB:
        return 65536;
    default:
        return 2048;
    }
}

/* Where each channel goes in the pixel: a bit for each of R, G, B, A; 7 for a lone Y. */
static uint32_t channel_target(const char *name, bool grey) {
    if (strcmp(name, "A") == 0) return 8;
    if (grey) return strcmp(name, "Y") == 0 ? 7 : 0;
    const char *at = strlen(name) == 1 ? strchr("RGB", name[0]) : NULL;
    return at ? 1u << (at - "RGB") : 0;
}

/* Finds the channels of a colour picture. `pixel_bytes`: what a pixel takes in the file, all channels together. */
static fnl_result choose_channels(struct reader *reader, bool *grey, uint32_t *found, uint64_t *pixel_bytes) {
    const exr_attr_chlist_t *channels = NULL;
    exr_result_t error = exr_get_channels(reader->exr, 0, &channels);
    if (error) return fail(reader, error);
    char *names = reader->names;
    bool color = false, luminance = false, chroma = false;
    *pixel_bytes = 0;
    for (int i = 0; i < channels->num_channels; i++) {
        const char *name = channels->entries[i].name.str;
        color |= channel_target(name, false) & 7;
        luminance |= strcmp(name, "Y") == 0;
        chroma |= strcmp(name, "RY") == 0 || strcmp(name, "BY") == 0;
        *pixel_bytes += channels->entries[i].pixel_type == EXR_PIXEL_HALF ? 2 : 4;
        size_t used = strlen(names);
        snprintf(names + used, sizeof reader->names - used, "%s%s", i ? ", " : "", name);
    }
    if (!color && luminance && chroma)
        return image_fail(reader->source, FNL_ERROR_UNSUPPORTED, "is an EXR of luminance and chroma, which is not read");
    if (!color && !luminance)
        return image_fail(reader->source, FNL_ERROR_UNSUPPORTED, "EXR without channels R, G, B or Y; it has %s", names);
    *grey = !color;
    *found = 0;
    for (int i = 0; i < channels->num_channels; i++) {
        const exr_attr_chlist_entry_t *channel = &channels->entries[i];
        uint32_t target = channel_target(channel->name.str, *grey);
        *found |= target;
        if (target && (channel->x_sampling != 1 || channel->y_sampling != 1))
            return image_fail(reader->source, FNL_ERROR_UNSUPPORTED, "the channel %s of the EXR is subsampled",
                              channel->name.str);
    }
    return FNL_OK;
}

struct chunk_decoder {
    exr_decode_pipeline_t pipeline;
    bool begun, grey;
    fnl_image *image;
    const struct reader *reader;
    uint32_t left, top; /* of the chunk, in the data window */
};

static uint32_t load_little(const uint8_t *at, int bytes) {
    uint32_t value = 0;
    for (int i = 0; i < bytes; i++) value |= (uint32_t)at[i] << 8 * i;
    return value;
}

static float to_float(uint32_t stored, uint16_t type) {
    float value;
    switch (type) {
    case EXR_PIXEL_HALF:
        return half_to_float((uint16_t)stored);
    case EXR_PIXEL_UINT:
        return (float)stored;
    default:
        memcpy(&value, &stored, sizeof value);
        return value;
    }
}

/*
 * Takes a decompressed chunk apart: rows of the channels one after the other, little endian. The library's own routine
 * is not used, because that of OpenEXR 3.1 swaps channels of interleaved half floats.
 */
static exr_result_t unpack_chunk(exr_decode_pipeline_t *pipeline) {
    struct chunk_decoder *decoder = pipeline->decoding_user_data;
    const uint8_t *at = pipeline->unpacked_buffer, *end = at + pipeline->chunk.unpacked_size;
    for (int32_t y = 0; y < pipeline->chunk.height; y++) {
        const int64_t row = decoder->reader->top + decoder->top + y, left = decoder->reader->left + decoder->left;
        const bool shown = row >= 0 && row < decoder->image->height;
        for (int i = 0; i < pipeline->channel_count; i++) {
            const exr_coding_channel_info_t *channel = &pipeline->channels[i];
            if (channel->y_samples > 1 && ((int64_t)pipeline->chunk.start_y + y) % channel->y_samples != 0) continue;
            size_t size = (size_t)channel->width * (size_t)channel->bytes_per_element;
            if ((size_t)(end - at) < size) return EXR_ERR_CORRUPT_CHUNK;
            uint32_t target = channel_target(channel->channel_name, decoder->grey);
            const int64_t first = MAX(-left, (int64_t)0), stop = MIN((int64_t)channel->width, (int64_t)decoder->image->width - left);
            float *pixel = (float *)decoder->image->pixels + (target == 8 ? 3 : target == 4 ? 2 : target == 2);
            for (int64_t x = first; target && shown && x < stop; x++)
                pixel[(row * decoder->image->width + left + x) * 4] =
                    to_float(load_little(at + (size_t)x * (size_t)channel->bytes_per_element, channel->bytes_per_element),
                             channel->data_type);
            at += size;
        }
    }
    return EXR_ERR_SUCCESS;
}

static exr_result_t decode_chunk(struct reader *reader, struct chunk_decoder *decoder, const exr_chunk_info_t *chunk,
                                 uint32_t left, uint32_t top) {
    if (chunk->unpacked_size / ratio_max(reader->compression) > chunk->packed_size) return EXR_ERR_CORRUPT_CHUNK;
    if ((uint64_t)left + (uint32_t)chunk->width > reader->width || (uint64_t)top + (uint32_t)chunk->height > reader->height)
        return EXR_ERR_CORRUPT_CHUNK;
    exr_decode_pipeline_t *pipeline = &decoder->pipeline;
    exr_result_t error = decoder->begun ? exr_decoding_update(reader->exr, 0, chunk, pipeline)
                                        : exr_decoding_initialize(reader->exr, 0, chunk, pipeline);
    if (error) return error;
    if (!decoder->begun) error = exr_decoding_choose_default_routines(reader->exr, 0, pipeline);
    decoder->begun = true; /* from here on there is something to destroy */
    if (error) return error;
    decoder->left = left;
    decoder->top = top;
    pipeline->decoding_user_data = decoder;
    pipeline->unpack_and_convert_fn = unpack_chunk;
    return exr_decoding_run(reader->exr, 0, pipeline);
}

static exr_result_t decode_scanlines(struct reader *reader, struct chunk_decoder *decoder) {
    int32_t step = 0;
    exr_result_t error = exr_get_scanlines_per_chunk(reader->exr, 0, &step);
    if (!error && step < 1) error = EXR_ERR_INVALID_ATTR;
    for (uint32_t top = 0; !error && top < reader->height; top += (uint32_t)step) {
        exr_chunk_info_t chunk;
        error = exr_read_scanline_chunk_info(reader->exr, 0, (int)((int64_t)reader->y + top), &chunk);
        if (!error) error = decode_chunk(reader, decoder, &chunk, 0, top);
    }
    return error;
}

static exr_result_t decode_tiles(struct reader *reader, struct chunk_decoder *decoder) {
    int32_t tile_width = 0, tile_height = 0;
    exr_result_t error = exr_get_tile_sizes(reader->exr, 0, 0, 0, &tile_width, &tile_height);
    if (!error && (tile_width < 1 || tile_height < 1)) error = EXR_ERR_INVALID_ATTR;
    for (int row = 0; !error && (uint64_t)row * (uint32_t)tile_height < reader->height; row++)
        for (int column = 0; !error && (uint64_t)column * (uint32_t)tile_width < reader->width; column++) {
            exr_chunk_info_t chunk;
            error = exr_read_tile_chunk_info(reader->exr, 0, column, row, 0, 0, &chunk);
            if (!error)
                error = decode_chunk(reader, decoder, &chunk, (uint32_t)column * (uint32_t)tile_width,
                                     (uint32_t)row * (uint32_t)tile_height);
        }
    return error;
}

static void fill_missing(fnl_image *image, bool grey, uint32_t found) {
    float *pixel = image->pixels;
    for (size_t i = (size_t)image->width * image->height; i > 0; i--, pixel += 4) {
        if (grey) pixel[1] = pixel[2] = pixel[0];
        for (int c = 0; c < 3; c++)
            if (!(found & 1u << c)) pixel[c] = 0;
        if (!(found & 8)) pixel[3] = 1;
    }
}

/* A picture of R alone is red, not gray. */
static void warn_of_missing(const struct reader *reader, uint32_t found) {
    char missing[8] = "";
    for (int c = 0; c < 3; c++)
        if (!(found & 1u << c)) snprintf(missing + strlen(missing), sizeof missing - strlen(missing), "%s%c", missing[0] ? ", " : "", "RGB"[c]);
    if (missing[0]) log_warning(reader->source->host, "%s: EXR without the channel%s %s, read as 0; it has %s", reader->source->name, missing[1] ? "s" : "", missing, reader->names);
}

/* Colors of other primaries become those of Rec. 709. Gray stays gray. */
static fnl_result convert_primaries(struct reader *reader, bool grey, fnl_image *image) {
    exr_attr_chromaticities_t c;
    float matrix[9];
    if (grey || exr_attr_get_chromaticities(reader->exr, 0, "chromaticities", &c) != EXR_ERR_SUCCESS) return FNL_OK;
    const float primaries[8] = {c.red_x, c.red_y, c.green_x, c.green_y, c.blue_x, c.blue_y, c.white_x, c.white_y};
    const enum primaries kind = primaries_matrix(primaries, matrix);
    if (kind == PRIMARIES_BAD) return image_fail(reader->source, FNL_ERROR_FORMAT, "broken EXR: its chromaticities are not usable");
    if (kind == PRIMARIES_OTHER) primaries_convert(matrix, image->pixels, (size_t)image->width * image->height);
    return FNL_OK;
}

/* A small data window in a large picture is no reason to refuse it; but a header alone gets no more than 64 MiB. */
static uint64_t held_pixels(const struct reader *reader, uint64_t pixel_bytes) {
    const uint64_t held = (uint64_t)reader->source->size * ratio_max(reader->compression) / pixel_bytes;
    return (uint64_t)reader->width * reader->height > held ? held : MAX(held, (uint64_t)4 << 20);
}

static fnl_result decode_pixels(struct reader *reader, fnl_image *out) {
    bool grey = false;
    uint32_t found = 0;
    uint64_t pixel_bytes = 1;
    TRY(choose_channels(reader, &grey, &found, &pixel_bytes));
    int32_t chunk_count = 0;
    exr_result_t error = exr_get_chunk_count(reader->exr, 0, &chunk_count);
    if (error) return fail(reader, error);
    /* The table has 8 bytes for each chunk. */
    if (chunk_count < 1 || (uint64_t)chunk_count > reader->source->size / 8)
        return image_fail(reader->source, FNL_ERROR_FORMAT, "broken EXR: the file is too short for its %d chunks",
                          chunk_count);
    fnl_image image;
    const uint64_t held = held_pixels(reader, pixel_bytes);
    if ((uint64_t)reader->width * reader->height > held)
        return image_fail(reader->source, FNL_ERROR_FORMAT, "broken: %zu bytes cannot hold the %u x %u pixels of the header", reader->source->size, reader->width, reader->height);
    TRY(image_allocate(reader->source, reader->picture_width, reader->picture_height, FNL_PIXEL_FORMAT_RGBA32F, held, &image));
    if (reader->left > 0 || reader->top > 0 || reader->left + reader->width < image.width || reader->top + reader->height < image.height)
        memset(image.pixels, 0, (size_t)image.width * image.height * 16);
    struct chunk_decoder decoder = {.pipeline = EXR_DECODE_PIPELINE_INITIALIZER, .grey = grey, .image = &image, .reader = reader};
    error = reader->storage == EXR_STORAGE_TILED ? decode_tiles(reader, &decoder) : decode_scanlines(reader, &decoder);
    if (decoder.begun) exr_decoding_destroy(reader->exr, &decoder.pipeline);
    if (error) {
        fnl_image_free(reader->source->host, &image);
        return fail(reader, error);
    }
    if (grey || found != 15) fill_missing(&image, grey, found);
    const fnl_result result = convert_primaries(reader, grey, &image);
    if (result != FNL_OK) {
        fnl_image_free(reader->source->host, &image);
        return result;
    }
    if (!grey) warn_of_missing(reader, found);
    *out = image;
    return FNL_OK;
}

fnl_result image_exr_decode(const struct image_source *source, fnl_image *out) {
    struct reader reader = {.source = source, .stream = {.bytes = source->bytes, .size = source->size}};
    fnl_result result = read_header(&reader);
    if (result == FNL_OK) result = decode_pixels(&reader, out);
    exr_finish(&reader.exr);
    current = NULL;
    return result;
}

/* ---- writing ---- */

static int64_t write_bytes(exr_const_context_t exr, void *user, const void *buffer, uint64_t size, uint64_t offset,
                           exr_stream_error_func_ptr_t fail_with) {
    struct stream *stream = user;
    if ((offset != stream->position && fseeko(stream->file, (off_t)offset, SEEK_SET) != 0) ||
        fwrite(buffer, 1, (size_t)size, stream->file) != size) {
        snprintf(stream->message, sizeof stream->message, "%s", strerror(errno));
        fail_with(exr, EXR_ERR_WRITE_IO, stream->message);
        return -1;
    }
    stream->position = offset + size;
    return (int64_t)size;
}

static const fnl_exr_channel *find_channel(const fnl_exr_channel *channels, uint32_t count, const char *name) {
    for (uint32_t i = 0; i < count; i++)
        if (strcmp(channels[i].name, name) == 0) return &channels[i];
    return NULL;
}

static exr_result_t write_header(exr_context_t exr, uint32_t width, uint32_t height, const fnl_exr_channel *channels,
                                 uint32_t count) {
    int part;
    exr_result_t error = exr_set_longname_support(exr, 1);
    if (!error) error = exr_add_part(exr, NULL, EXR_STORAGE_SCANLINE, &part);
    if (!error) error = exr_initialize_required_attr_simple(exr, 0, (int32_t)width, (int32_t)height, COMPRESSION);
    for (uint32_t i = 0; !error && i < count; i++)
        error = exr_add_channel(exr, 0, channels[i].name, EXR_PIXEL_FLOAT, EXR_PERCEPTUALLY_LINEAR, 1, 1);
    return error ? error : exr_write_header(exr);
}

/*
 * A chunk as long as its data counts as not compressed, but OpenEXR 3.1 stores compressed bytes when they are exactly as many: then the data
 * itself is to be stored.
 */
static exr_result_t compress_chunk(exr_encode_pipeline_t *pipeline) {
    exr_result_t (*const *compress)(exr_encode_pipeline_t *) = pipeline->encoding_user_data;
    exr_result_t error = (*compress)(pipeline);
    if (!error && pipeline->compressed_bytes == pipeline->packed_bytes)
        memcpy(pipeline->compressed_buffer, pipeline->packed_buffer, (size_t)pipeline->packed_bytes);
    return error;
}

static exr_result_t write_chunks(exr_context_t exr, uint32_t width, uint32_t height, const fnl_exr_channel *channels,
                                 uint32_t count) {
    int32_t step = 0;
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    exr_result_t error = exr_get_scanlines_per_chunk(exr, 0, &step);
    exr_result_t (*compress)(exr_encode_pipeline_t *) = NULL;
    bool begun = false;
    for (uint32_t y = 0; !error && y < height; y += (uint32_t)step) {
        exr_chunk_info_t chunk;
        error = exr_write_scanline_chunk_info(exr, 0, (int)y, &chunk);
        if (error) break;
        error = begun ? exr_encoding_update(exr, 0, &chunk, &pipeline) : exr_encoding_initialize(exr, 0, &chunk, &pipeline);
        for (int i = 0; !error && i < pipeline.channel_count; i++) {
            exr_coding_channel_info_t *target = &pipeline.channels[i];
            const fnl_exr_channel *channel = find_channel(channels, count, target->channel_name);
            target->encode_from_ptr = (const uint8_t *)(channel->values + (size_t)y * width * channel->stride);
            target->user_pixel_stride = (int32_t)(channel->stride * 4);
            target->user_line_stride = (int32_t)(channel->stride * 4 * width);
            target->user_bytes_per_element = 4;
            target->user_data_type = EXR_PIXEL_FLOAT;
        }
        if (!error && !begun) error = exr_encoding_choose_default_routines(exr, 0, &pipeline);
        if (!error && !begun && pipeline.compress_fn) {
            compress = pipeline.compress_fn;
            pipeline.encoding_user_data = &compress;
            pipeline.compress_fn = compress_chunk;
        }
        begun = true;
        if (!error) error = exr_encoding_run(exr, 0, &pipeline);
    }
    if (begun) exr_encoding_destroy(exr, &pipeline);
    return error;
}

static fnl_result check_channels(const struct call *call, uint32_t width, const fnl_exr_channel *channels, uint32_t count) {
    for (uint32_t i = 0; i < count; i++) {
        const fnl_exr_channel *channel = &channels[i];
        if (!channel->name || !channel->values)
            return misuse(call, "channels[%u].%s is NULL", i, channel->name ? "values" : "name");
        size_t length = strlen(channel->name);
        if (length < 1 || length > CHANNEL_NAME_MAX)
            return misuse(call, "channels[%u].name has %zu bytes, must have 1 .. %d", i, length, CHANNEL_NAME_MAX);
        char field[64];
        snprintf(field, sizeof field, "channels[%u].stride", i);
        TRY(check_count(call, field, channel->stride, 1, INT32_MAX / 4 / width));
        if (find_channel(channels, i, channel->name))
            return misuse(call, "channels[%u].name is '%s', which another channel is called already", i, channel->name);
    }
    return FNL_OK;
}

fnl_result fnl_exr_save(const fnl_host *host, const char *path, uint32_t width, uint32_t height,
                        const fnl_exr_channel *channels, uint32_t channel_count) {
    fnl_host resolved = host_resolve(host);
    const struct call *call = CALL(&resolved);
    TRY(check_pointer(call, "path", path));
    TRY(check_count(call, "width", width, 1, IMAGE_SIDE_MAX));
    TRY(check_count(call, "height", height, 1, IMAGE_SIDE_MAX));
    TRY(check_pointer(call, "channels", channels));
    TRY(check_count(call, "channel_count", channel_count, 1, UINT32_MAX));
    TRY(check_channels(call, width, channels, channel_count));

    struct file_writer writer;
    TRY(file_write_begin(&resolved, path, &writer));
    struct stream stream = {.file = writer.stream};
    exr_context_initializer_t start = EXR_DEFAULT_CONTEXT_INITIALIZER;
    start.error_handler_fn = keep_message;
    start.user_data = &stream;
    start.write_fn = write_bytes;
    start.zip_level = ZIP_LEVEL;
    exr_context_t exr = NULL;
    current = &stream;
    exr_result_t error = exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, &start);
    if (!error) error = write_header(exr, width, height, channels, channel_count);
    if (!error) error = write_chunks(exr, width, height, channels, channel_count);
    exr_result_t finished = exr_finish(&exr); /* writes the table of chunks */
    if (!error) error = finished;
    current = NULL;
    if (!error) return file_write_commit(&writer);
    log_error(&resolved, "%s: cannot be written: %s", path, message_of(&stream, error));
    file_write_abandon(&writer);
    return error == EXR_ERR_OUT_OF_MEMORY ? FNL_ERROR_MEMORY : FNL_ERROR_FILE;
}
