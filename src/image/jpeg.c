/* SPDX-License-Identifier: MIT */
/* JPEG through libjpeg-turbo: baseline and progressive; grey, YCbCr, RGB, CMYK and YCCK. */
#include "image/codec.h"

#include <setjmp.h>

#include <jpeglib.h>

#include <jerror.h>

#ifndef JCS_EXTENSIONS
#error "libjpeg-turbo is needed: its output straight to RGBA"
#endif

/* A file of endless tiny scans over a large picture would take hours. Encoders make about ten; each component may be
   refined in at most 13 steps for each of 64 coefficients, but nothing in use comes near this. */
#define SCANS_MAX 200
/* Each block of 8x8 samples takes at least one bit in its first scan, and a component may lack the full size on each
   axis by up to the factor four in one direction. */
#define PIXELS_PER_BYTE_MAX 2048u

struct decoder {
    struct jpeg_decompress_struct jpeg;
    struct jpeg_error_mgr errors;
    struct jpeg_progress_mgr progress;
    jmp_buf escape;
    const struct image_source *source;
    fnl_result result;   /* why it escaped */
    fnl_image image;     /* freed when it escapes */
    JSAMPARRAY cmyk_row; /* from the decoder's own pool */
};

static void escape(struct decoder *decoder, fnl_result result) {
    decoder->result = result;
    longjmp(decoder->escape, 1);
}

static void fail_with_message(j_common_ptr jpeg) {
    struct decoder *decoder = jpeg->client_data;
    char message[JMSG_LENGTH_MAX];
    jpeg->err->format_message(jpeg, message);
    fnl_result result = jpeg->err->msg_code == JERR_OUT_OF_MEMORY ? FNL_ERROR_MEMORY : FNL_ERROR_FORMAT;
    escape(decoder, image_fail(decoder->source, result, "broken JPEG: %s", message));
}

/* The library goes on after warnings, with grey in place of what is missing; that is not a success. */
static void judge_warning(j_common_ptr jpeg, int level) {
    if (level >= 0) return; /* a trace message */
    switch (jpeg->err->msg_code) {
    case JWRN_HIT_MARKER:
    case JWRN_JPEG_EOF:
    case JWRN_HUFF_BAD_CODE:
    case JWRN_MUST_RESYNC:
    case JWRN_BOGUS_PROGRESSION:
        fail_with_message(jpeg);
        break;
    default:
        break;
    }
}

static void say_nothing(j_common_ptr jpeg) { UNUSED(jpeg); }

static void count_scans(j_common_ptr jpeg) {
    struct decoder *decoder = jpeg->client_data;
    if (decoder->jpeg.input_scan_number > SCANS_MAX)
        escape(decoder, image_fail(decoder->source, FNL_ERROR_UNSUPPORTED, "JPEG of more than %d scans", SCANS_MAX));
}

static void read_header(struct decoder *decoder) {
    const struct image_source *source = decoder->source;
    struct jpeg_decompress_struct *jpeg = &decoder->jpeg;
    jpeg_create_decompress(jpeg);
    decoder->progress.progress_monitor = count_scans;
    jpeg->progress = &decoder->progress;
    jpeg_mem_src(jpeg, source->bytes, (unsigned long)source->size);
    jpeg_read_header(jpeg, TRUE);
    fnl_result result = image_check_size(source, jpeg->image_width, jpeg->image_height);
    if (result != FNL_OK) escape(decoder, result);
    /* No browser reads these, and their length says nothing about the size of the picture. */
    if (jpeg->arith_code) escape(decoder, image_fail(source, FNL_ERROR_UNSUPPORTED, "JPEG with arithmetic coding"));
}

/* Adobe's programs store CMYK inverted, and only they mark their files (Adobe technical note 5116). */
static void cmyk_to_rgba(const uint8_t *cmyk, bool inverted, uint32_t count, uint8_t *rgba) {
    uint8_t flip = inverted ? 0 : 0xff;
    for (uint32_t i = 0; i < count; i++, cmyk += 4, rgba += 4) {
        uint32_t light = cmyk[3] ^ flip;
        for (int c = 0; c < 3; c++) rgba[c] = (uint8_t)(((uint32_t)(cmyk[c] ^ flip) * light + 127) / 255);
        rgba[3] = 0xff;
    }
}

static void read_pixels(struct decoder *decoder) {
    struct jpeg_decompress_struct *jpeg = &decoder->jpeg;
    bool cmyk = jpeg->jpeg_color_space == JCS_CMYK || jpeg->jpeg_color_space == JCS_YCCK;
    if (jpeg->jpeg_color_space == JCS_UNKNOWN)
        escape(decoder, image_fail(decoder->source, FNL_ERROR_UNSUPPORTED, "JPEG of %d unknown colour components",
                                   jpeg->num_components));
    fnl_result result = image_allocate(decoder->source, jpeg->image_width, jpeg->image_height, FNL_PIXEL_FORMAT_RGBA8,
                                       (uint64_t)decoder->source->size * PIXELS_PER_BYTE_MAX, &decoder->image);
    if (result != FNL_OK) escape(decoder, result);
    jpeg->out_color_space = cmyk ? JCS_CMYK : JCS_EXT_RGBA;
    jpeg_start_decompress(jpeg);
    if (cmyk) decoder->cmyk_row = jpeg->mem->alloc_sarray((j_common_ptr)jpeg, JPOOL_IMAGE, jpeg->output_width * 4, 1);
    size_t stride = (size_t)jpeg->output_width * 4;
    while (jpeg->output_scanline < jpeg->output_height) {
        uint8_t *row = (uint8_t *)decoder->image.pixels + jpeg->output_scanline * stride;
        if (cmyk) {
            jpeg_read_scanlines(jpeg, decoder->cmyk_row, 1);
            cmyk_to_rgba(decoder->cmyk_row[0], jpeg->saw_Adobe_marker, jpeg->output_width, row);
        } else {
            JSAMPROW rows[16];
            uint32_t count = MIN(COUNT_OF(rows), jpeg->output_height - jpeg->output_scanline);
            for (uint32_t i = 0; i < count; i++) rows[i] = row + i * stride;
            jpeg_read_scanlines(jpeg, rows, count);
        }
    }
    jpeg_finish_decompress(jpeg); /* reads up to the end mark */
}

static fnl_result run(struct decoder *decoder, const struct image_source *source, bool pixels) {
    decoder->source = source;
    decoder->jpeg.client_data = decoder;
    decoder->jpeg.err = jpeg_std_error(&decoder->errors);
    decoder->errors.error_exit = fail_with_message;
    decoder->errors.emit_message = judge_warning;
    decoder->errors.output_message = say_nothing;
    if (setjmp(decoder->escape) == 0) {
        read_header(decoder);
        if (pixels) read_pixels(decoder);
    } else {
        fnl_image_free(source->host, &decoder->image);
    }
    jpeg_destroy_decompress(&decoder->jpeg);
    return decoder->result;
}

fnl_result image_jpeg_peek(const struct image_source *source, struct image_file_info *out) {
    struct decoder decoder = {.result = FNL_OK};
    TRY(run(&decoder, source, false));
    *out = (struct image_file_info){.kind = IMAGE_FILE_JPEG, .width = decoder.jpeg.image_width, .height = decoder.jpeg.image_height, .pixel_bytes = 4};
    return FNL_OK;
}

fnl_result image_jpeg_decode(const struct image_source *source, fnl_image *out) {
    struct decoder decoder = {.result = FNL_OK};
    TRY(run(&decoder, source, true));
    *out = decoder.image;
    return FNL_OK;
}
