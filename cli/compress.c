/* SPDX-License-Identifier: MIT */
/* fanal compress: pictures of high dynamic range to BC6H and back. */
#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "output.h"
#include "print.h"

#include "fanal/device.h"
#include "fanal/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { EXIT_DONE = 0, EXIT_ERROR = 2 };

struct compression {
    const char *input, *output, *device;
    bool on_gpu, has_max_memory;
    uint64_t max_memory;
    fnl_compress_params params;
};

static void print_help(void) {
    puts("Usage: fanal compress [OPTIONS] PICTURE -o OUT.dds|OUT.ktx2\n"
         "       fanal compress IN.dds|IN.ktx2 -o OUT.exr|OUT.hdr\n"
         "\n"
         "Compresses a picture of high dynamic range (HDR, EXR; PNG, JPEG and WebP are taken as sRGB) as BC6H: 16 bytes for 4 x 4\n"
         "pixels, which GPUs sample as they are. Or decodes such a file. Prints how far the result is from the source: the root of the\n"
         "mean squared difference (RMSE) and the same of log(value + 1) (RMSLE), and how fast it was compressed.\n"
         "\n"
         "  -o, --output FILE      .dds or .ktx2 to compress, .exr or .hdr to decode\n"
         "  --quality QUALITY      fast: one of the format's modes; quality (default): seven of them; best: a search through all\n"
         "                         modes that takes thousands of times as long, on the CPU\n"
         "  --signed               keeps negative values, at half the precision\n"
         "  --mips                 all smaller levels too\n"
         "  --cube SIZE            makes a cube map of a panorama, with faces of SIZE pixels (1 to 4096); directions as --environment of\n"
         "                         fanal render has them: +X in the middle of the picture, +Z a quarter of the width to the right\n"
         "  --on cpu|gpu           what compresses (cpu); both give the same file\n"
         "  --device DEVICE        the Vulkan device, by index or part of its name, as 'fanal devices' lists them\n"
         "  --max-memory SIZE      limits the decoded picture: bytes, or with K, M or G (half of the machine's memory)\n"
         "  -h, --help             prints this text\n"
         "\n"
         "Exit status: 0 when the file was written, 2 on an error.\n"
         "\n"
         "Examples:\n"
         "  fanal compress sky.hdr -o sky.dds\n"
         "  fanal compress sky.hdr --cube 256 --mips --on gpu -o sky.ktx2\n"
         "  fanal compress sky.dds -o sky.exr");
}

static bool parse_value(const char *option, const char *text, const char *const *names, int count, int *out) {
    for (*out = 0; *out < count; ++*out)
        if (strcmp(text, names[*out]) == 0) return true;
    fprintf(stderr, "fanal: error: --%s: '%s' is none of:", option, text);
    for (int i = 0; i < count; i++) fprintf(stderr, "%s %s", i ? "," : "", names[i]);
    fputc('\n', stderr);
    return false;
}

static bool has_extension(const char *path, const char *extension) {
    const char *dot = strrchr(path, '.');
    return dot && strcasecmp(dot + 1, extension) == 0;
}
static bool is_texture(const char *path) { return has_extension(path, "dds") || has_extension(path, "ktx2"); }

/* EXIT_DONE when the work can begin, EXIT_ERROR after a message; `*helped` when --help was all. */
static int parse_options(int argc, char **argv, struct compression *out, bool *helped) {
    enum { QUALITY = 256, SIGNED, MIPS, CUBE, ON, DEVICE, MAX_MEMORY };
    static const struct option options[] = {
        {"output", required_argument, NULL, 'o'}, {"quality", required_argument, NULL, QUALITY}, {"signed", no_argument, NULL, SIGNED},
        {"mips", no_argument, NULL, MIPS},        {"cube", required_argument, NULL, CUBE},       {"on", required_argument, NULL, ON},
        {"device", required_argument, NULL, DEVICE}, {"max-memory", required_argument, NULL, MAX_MEMORY}, {"help", no_argument, NULL, 'h'},           {0},
    };
    static const char *const qualities[] = {"fast", "quality", "best"}, *const processors[] = {"cpu", "gpu"};
    optind = 0; /* glibc: starts anew, whatever was parsed before */
    for (int key, value; (key = argument_next(argc, argv, "o:h", options)) != -1;) {
        switch (key) {
        case 'o':
            out->output = optarg;
            break;
        case QUALITY:
            if (!parse_value("quality", optarg, qualities, 3, &value)) return EXIT_ERROR;
            out->params.quality = (fnl_compress_quality)value;
            break;
        case SIGNED:
            out->params.is_signed = true;
            break;
        case MIPS:
            out->params.mips = true;
            break;
        case CUBE: {
            long long size;
            if (!argument_integer("cube", optarg, 1, 4096, &size)) return EXIT_ERROR;
            out->params.cube_size = (uint32_t)size;
            break;
        }
        case ON:
            if (!parse_value("on", optarg, processors, 2, &value)) return EXIT_ERROR;
            out->on_gpu = value == 1;
            break;
        case DEVICE:
            out->device = optarg;
            break;
        case MAX_MEMORY:
            if (!argument_bytes("max-memory", optarg, &out->max_memory)) return EXIT_ERROR;
            out->has_max_memory = true;
            break;
        case 'h':
            print_help();
            *helped = true;
            return EXIT_DONE;
        default:
            return EXIT_ERROR; /* getopt has said what is wrong */
        }
    }
    if (argc - optind != 1 || !out->output) {
        fprintf(stderr, "fanal: error: one picture and -o FILE are needed; see 'fanal compress --help'\n");
        return EXIT_ERROR;
    }
    out->input = argv[optind];
    if (!is_texture(out->output) && !(is_texture(out->input) && (has_extension(out->output, "exr") || has_extension(out->output, "hdr")))) {
        fprintf(stderr, "fanal: error: %s: a picture is compressed to .dds or .ktx2, and these are decoded to .exr or .hdr\n", out->output);
        return EXIT_ERROR;
    }
    if (!output_check(out->output)) return EXIT_ERROR;
    if (out->on_gpu && out->params.quality == FNL_COMPRESS_BEST) {
        fputs("fanal: error: --quality best is for --on cpu alone\n", stderr);
        return EXIT_ERROR;
    }
    if (out->device && !out->on_gpu) {
        fputs("fanal: error: --device goes with --on gpu\n", stderr);
        return EXIT_ERROR;
    }
    return EXIT_DONE;
}

static void print_stats(const struct compression *c, const fnl_compress_stats *s) {
    printf("size   %u x %u, %u face%s, %u mip%s\n", s->width, s->height, s->faces, s->faces > 1 ? "s" : "", s->mips, s->mips > 1 ? "s" : "");
    printf("rmse   %.6g\n", s->rmse);
    printf("rmsle  %.6g\n", s->rmsle);
    if (s->seconds > 0)
        printf("speed  %.4g MP/s (%.4g ms on the %s)\n", (double)s->pixels / s->seconds * 1e-6, s->seconds * 1e3, c->on_gpu ? "GPU" : "CPU");
    printf("modes ");
    for (int mode = 1; mode <= 14; mode++)
        if (s->blocks[mode]) printf(" %d: %llu", mode, (unsigned long long)s->blocks[mode]);
    printf("  (blocks)\n");
}

static int compress(struct compression *c, const fnl_image *image) {
    fnl_compress_stats stats;
    fnl_device *device = NULL;
    if (c->on_gpu) {
        fnl_device_params params = fnl_device_params_default();
        argument_device(c->device, &params);
        if (fnl_device_create(&params, &device) != FNL_OK) return EXIT_ERROR;
        c->params.device = device;
    }
    bool good = fnl_image_compress(NULL, c->output, image, &c->params, &stats) == FNL_OK;
    fnl_device_destroy(&device);
    if (good) print_stats(c, &stats);
    return good ? EXIT_DONE : EXIT_ERROR;
}

int command_compress(int argc, char **argv) {
    struct compression compression = {.params = fnl_compress_params_default()};
    bool helped = false;
    fnl_image image;
    int code = parse_options(argc, argv, &compression, &helped);
    if (code != EXIT_DONE || helped) return code;
    const fnl_result result = compression.has_max_memory ? fnl_image_load_within(NULL, compression.input, compression.max_memory, &image)
                                                         : fnl_image_load(NULL, compression.input, &image);
    if (result != FNL_OK) return EXIT_ERROR;
    if (is_texture(compression.output))
        code = compress(&compression, &image);
    else
        code = fnl_image_save(NULL, compression.output, &image) == FNL_OK ? EXIT_DONE : EXIT_ERROR;
    if (code == EXIT_DONE) printf("wrote %s\n", compression.output);
    fnl_image_free(NULL, &image);
    return code;
}
