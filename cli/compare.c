/* SPDX-License-Identifier: MIT */
/* fanal compare: how far two pictures are apart. */
#include "argument_next.h"
#include "arguments.h"
#include "commands.h"
#include "flip.h"
#include "json_text.h"
#include "leak.h"
#include "output.h"
#include "print.h"

#include "fanal/image.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

enum { EXIT_WITHIN = 0, EXIT_OVER = 1, EXIT_ERROR = 2 };

enum metric { METRIC_MAX, METRIC_MEAN, METRIC_PSNR, METRIC_SSIM, METRIC_FLIP, METRIC_LEAK, METRIC_COUNT };

static const struct {
    const char *option, *name;
    bool least; /* the limit is the smallest value that passes */
} metrics[METRIC_COUNT] = {
    [METRIC_MAX] = {"max-diff", "max", false},
    [METRIC_MEAN] = {"mean-diff", "mean", false},
    [METRIC_PSNR] = {"psnr", "psnr", true},
    [METRIC_SSIM] = {"ssim", "ssim", true},
    [METRIC_FLIP] = {"flip", "flip", false},
    [METRIC_LEAK] = {"leak", "leak", false},
};

struct comparison {
    const char *path[3], *output; /* the third: that of --lit, or NULL */
    fnl_image image[3];
    fnl_image_difference difference;
    double flip, leak; /* NAN: not known */
    bool alpha_differs, json, limited[METRIC_COUNT], has_max_memory;
    uint64_t max_memory; /* of all pictures together */
    double limit[METRIC_COUNT];
};

static void print_help(void) {
    puts("Usage: fanal compare [OPTIONS] A B\n"
         "\n"
         "Prints how far two pictures of one size are apart: the greatest difference of a channel and where it is, the\n"
         "mean, the root of the mean square (RMSE), PSNR in dB, and the structural similarity (SSIM, 1 is equal). The\n"
         "pictures are PNG, EXR, HDR, JPEG, WebP, KTX2 or DDS files; integer pixels are taken from 0 to 1, floats as they\n"
         "are. For two pictures with integer pixels also FLIP, which is how different they look to somebody who flips\n"
         "between them (0 to 1; Andersson et al. 2020). SSIM and FLIP leave alpha out; a note says so if it differs.\n"
         "\n"
         "  --max-diff X      the greatest difference may be X at most; X is a number or a fraction such as 2/255\n"
         "  --mean-diff X     the mean difference may be X at most\n"
         "  --psnr X          PSNR must be X dB at least\n"
         "  --ssim X          SSIM must be X at least\n"
         "  --flip X          FLIP may be X at most\n"
         "  --lit FILE        the scene without shadows: prints the leak, the sum of the differences of luminance between A and B\n"
         "                    as a part of the luminance that there would be without shadows. All three are linear (.exr)\n"
         "  --leak X          the leak may be X at most\n"
         "  -o, --output FILE writes a picture of the differences (.png), the greatest shown white\n"
         "  --max-memory SIZE limits the decoded pictures together: bytes, or with K, M or G (half of the machine's memory each)\n"
         "  --json            prints JSON; infinity is \"Infinity\" or \"-Infinity\"\n"
         "  -h, --help        prints this text\n"
         "\n"
         "Exit status: 0 within all limits, 1 over a limit, 2 on an error, such as sizes that differ.\n"
         "\n"
         "Examples:\n"
         "  fanal compare expected.png actual.png --max-diff 2/255\n"
         "  fanal compare a.exr b.exr --psnr 50 --ssim 0.99 -o difference.png\n"
         "  fanal compare a.png b.png --json");
}

/* A number, or two of them with a slash between. */
static bool parse_number(const char *text, double *out) {
    double divisor = 1;
    if (strcmp(text, "inf") == 0) { /* the ratio of equal pictures */
        *out = INFINITY;
        return true;
    }
    if (!argument_take_number(&text, out)) return false;
    if (*text == '/' && (++text, !argument_take_number(&text, &divisor) || divisor == 0)) return false;
    *out /= divisor;
    return !*text && isfinite(*out);
}

/* EXIT_WITHIN when the work can begin, EXIT_ERROR after a message; `*helped` when --help was all. */
static int parse_options(int argc, char **argv, struct comparison *out, bool *helped) {
    static const struct option options[] = {
        {"max-diff", required_argument, NULL, 256 + METRIC_MAX},
        {"mean-diff", required_argument, NULL, 256 + METRIC_MEAN},
        {"psnr", required_argument, NULL, 256 + METRIC_PSNR},
        {"ssim", required_argument, NULL, 256 + METRIC_SSIM},
        {"flip", required_argument, NULL, 256 + METRIC_FLIP},
        {"leak", required_argument, NULL, 256 + METRIC_LEAK},
        {"lit", required_argument, NULL, 'l'},
        {"max-memory", required_argument, NULL, 'm'},
        {"output", required_argument, NULL, 'o'},
        {"json", no_argument, NULL, 'j'},
        {"help", no_argument, NULL, 'h'},
        {0},
    };
    optind = 0; /* glibc: starts anew, whatever was parsed before */
    for (int key; (key = argument_next(argc, argv, "o:h", options)) != -1;) {
        switch (key) {
        case 'o':
            out->output = optarg;
            break;
        case 'l':
            out->path[2] = optarg;
            break;
        case 'm':
            if (!argument_bytes("max-memory", optarg, &out->max_memory)) return EXIT_ERROR;
            out->has_max_memory = true;
            break;
        case 'j':
            out->json = true;
            break;
        case 'h':
            print_help();
            *helped = true;
            return EXIT_WITHIN;
        case '?':
            return EXIT_ERROR; /* getopt has said what is wrong */
        default:
            out->limited[key - 256] = true;
            if (parse_number(optarg, &out->limit[key - 256])) break;
            fprintf(stderr, "fanal: error: --%s: '%s' is not a number or fraction\n", metrics[key - 256].option, optarg);
            return EXIT_ERROR;
        }
    }
    if (argc - optind != 2) {
        fprintf(stderr, "fanal: error: two pictures are needed, %d given; see 'fanal compare --help'\n", argc - optind);
        return EXIT_ERROR;
    }
    if (out->limited[METRIC_LEAK] && !out->path[2]) {
        fputs("fanal: error: --leak needs --lit FILE, the scene without shadows\n", stderr);
        return EXIT_ERROR;
    }
    const char *dot = out->output ? strrchr(out->output, '.') : NULL;
    if (out->output && (!dot || strcasecmp(dot, ".png") != 0)) {
        fprintf(stderr, "fanal: error: %s: the picture of the differences is a .png file\n", out->output);
        return EXIT_ERROR;
    }
    if (out->output && !output_check(out->output)) return EXIT_ERROR;
    out->path[0] = argv[optind];
    out->path[1] = argv[optind + 1];
    return EXIT_WITHIN;
}

static double value_of(const struct comparison *comparison, enum metric metric) {
    const fnl_image_difference *difference = &comparison->difference;
    switch (metric) {
    case METRIC_FLIP:
        return comparison->flip;
    case METRIC_LEAK:
        return comparison->leak;
    case METRIC_MAX:
        return difference->max;
    case METRIC_MEAN:
        return difference->mean;
    case METRIC_PSNR:
        return difference->psnr;
    default:
        return difference->ssim;
    }
}

static bool is_broken(const struct comparison *comparison, enum metric metric) {
    double value = value_of(comparison, metric), limit = comparison->limit[metric];
    return comparison->limited[metric] && (metrics[metric].least ? value < limit : value > limit);
}

static void print_text(const struct comparison *comparison) {
    const fnl_image_difference *d = &comparison->difference;
    const fnl_image *image = &comparison->image[0];
    uint64_t pixels = (uint64_t)image->width * image->height;
    printf("size   %u x %u\n", image->width, image->height);
    printf("max    %.9g (%.2f/255) at %u, %u\n", d->max, d->max * 255, d->max_x, d->max_y);
    printf("mean   %.9g\n", d->mean);
    printf("rmse   %.9g\n", d->rmse);
    printf("psnr   %.4f dB\n", d->psnr);
    printf("ssim   %.9f\n", d->ssim);
    if (!isnan(comparison->flip)) printf("flip   %.9f\n", comparison->flip);
    if (!isnan(comparison->leak)) printf("leak   %.9g\n", comparison->leak);
    printf("pixels %llu of %llu differ\n", (unsigned long long)d->differing_pixels, (unsigned long long)pixels);
    if (comparison->alpha_differs) printf("note   alpha differs; %s not count it\n", isnan(comparison->flip) ? "ssim does" : "ssim and flip do");
    for (enum metric m = METRIC_MAX; m < METRIC_COUNT; m++)
        if (is_broken(comparison, m))
            printf("over   %s is %.9g, the limit --%s is %.9g\n", metrics[m].name, value_of(comparison, m), metrics[m].option,
                   comparison->limit[m]);
}

static json_t *json_number(double value) { return isfinite(value) ? json_real(value) : isnan(value) ? json_null() : json_string(value > 0 ? "Infinity" : "-Infinity"); }

static bool print_json(const struct comparison *comparison) {
    const fnl_image_difference *d = &comparison->difference;
    json_t *over = json_array();
    for (enum metric m = METRIC_MAX; m < METRIC_COUNT; m++)
        if (is_broken(comparison, m)) json_array_append_new(over, json_string(metrics[m].option));
    json_t *root =
        json_pack("{s:[oo], s:i, s:i, s:o, s:[ii], s:o, s:o, s:o, s:o, s:I, s:b, s:o}", "files", json_text(comparison->path[0]),
                  json_text(comparison->path[1]), "width", (int)comparison->image[0].width, "height", (int)comparison->image[0].height,
                  "max", json_number(d->max), "max_at", (int)d->max_x, (int)d->max_y, "mean", json_number(d->mean), "rmse",
                  json_number(d->rmse), "psnr", json_number(d->psnr), "ssim", json_number(d->ssim), "differing_pixels",
                  (json_int_t)d->differing_pixels, "alpha_differs", (int)comparison->alpha_differs, "over", over);
    if (root && !isnan(comparison->flip)) json_object_set_new(root, "flip", json_real(comparison->flip));
    if (root && !isnan(comparison->leak)) json_object_set_new(root, "leak", json_number(comparison->leak));
    const bool printed = json_text_print(root, JSON_INDENT(2) | JSON_REAL_PRECISION(9));
    json_decref(root);
    if (!printed) fputs("fanal: error: the JSON could not be written\n", stderr);
    return printed;
}

static bool save_picture(const struct comparison *comparison) {
    fnl_image picture;
    if (fnl_image_difference_picture(NULL, &comparison->image[0], &comparison->image[1], 0, &picture) != FNL_OK)
        return false;
    bool saved = fnl_image_save(NULL, comparison->output, &picture) == FNL_OK;
    fnl_image_free(NULL, &picture);
    return saved;
}

static bool load(struct comparison *comparison) {
    const fnl_image *a = &comparison->image[0];
    for (int i = 0; i < 3; i++) {
        const fnl_image *image = &comparison->image[i];
        if (!comparison->path[i]) continue;
        const fnl_result result = comparison->has_max_memory ? fnl_image_load_within(NULL, comparison->path[i], comparison->max_memory, &comparison->image[i])
                                                             : fnl_image_load(NULL, comparison->path[i], &comparison->image[i]);
        if (result != FNL_OK) return false;
        comparison->max_memory -= comparison->has_max_memory ? (uint64_t)image->width * image->height * fnl_pixel_size(image->format) : 0;
        if (a->width == image->width && a->height == image->height) continue;
        fprintf(stderr, "fanal: error: the sizes differ: %s is %u x %u, %s is %u x %u\n", comparison->path[0], a->width, a->height,
                comparison->path[i], image->width, image->height);
        return false;
    }
    return true;
}

static double alpha_of(const fnl_image *image, size_t pixel) {
    switch (image->format) {
    case FNL_PIXEL_FORMAT_RGBA8:
        return ((const unsigned char *)image->pixels)[4 * pixel + 3] / 255.0;
    case FNL_PIXEL_FORMAT_RGBA16:
        return ((const uint16_t *)image->pixels)[4 * pixel + 3] / 65535.0;
    default:
        return (double)((const float *)image->pixels)[4 * pixel + 3];
    }
}

static bool alpha_differs(const fnl_image *a, const fnl_image *b) {
    const size_t count = (size_t)a->width * a->height;
    for (size_t i = 0; i < count; i++) {
        const double x = alpha_of(a, i), y = alpha_of(b, i);
        if (fabs(x - y) > 1e-6 || isnan(x) != isnan(y)) return true;
    }
    return false;
}

static bool find_flip(struct comparison *comparison) {
    const fnl_image *a = &comparison->image[0], *b = &comparison->image[1];
    const char *floats = a->format == FNL_PIXEL_FORMAT_RGBA32F   ? comparison->path[0]
                         : b->format == FNL_PIXEL_FORMAT_RGBA32F ? comparison->path[1]
                                                                 : NULL;
    comparison->flip = NAN;
    if (floats && !comparison->limited[METRIC_FLIP]) return true;
    if (!floats) comparison->flip = flip_compare(a, b, FLIP_PIXELS_PER_DEGREE, NULL);
    if (floats)
        fprintf(stderr, "fanal: error: --flip is for pictures as a screen shows them, such as .png: %s holds linear light\n", floats);
    else if (comparison->flip < 0)
        fputs("fanal: error: memory ran out\n", stderr);
    return comparison->flip >= 0;
}

static bool find_leak(struct comparison *comparison) {
    comparison->leak = NAN;
    if (!comparison->path[2]) return true;
    for (int i = 0; i < 3; i++)
        if (comparison->image[i].format != FNL_PIXEL_FORMAT_RGBA32F) {
            fprintf(stderr, "fanal: error: --lit compares linear light, as in .exr: %s holds none\n", comparison->path[i]);
            return false;
        }
    comparison->leak = leak_compare(&comparison->image[0], &comparison->image[1], &comparison->image[2]);
    return true;
}

static int compare(struct comparison *comparison) {
    const fnl_image *a = &comparison->image[0], *b = &comparison->image[1];
    if (!load(comparison)) return EXIT_ERROR;
    if (fnl_image_compare(NULL, a, b, &comparison->difference) != FNL_OK || !find_flip(comparison) || !find_leak(comparison))
        return EXIT_ERROR;
    comparison->alpha_differs = alpha_differs(a, b);
    if (comparison->output && !save_picture(comparison)) return EXIT_ERROR;
    if (!comparison->json)
        print_text(comparison);
    else if (!print_json(comparison))
        return EXIT_ERROR;
    if (comparison->output && !comparison->json) printf("wrote %s\n", comparison->output);
    for (enum metric m = METRIC_MAX; m < METRIC_COUNT; m++)
        if (is_broken(comparison, m)) return EXIT_OVER;
    return EXIT_WITHIN;
}

int command_compare(int argc, char **argv) {
    struct comparison comparison = {0};
    bool helped = false;
    int code = parse_options(argc, argv, &comparison, &helped);
    if (code == EXIT_WITHIN && !helped) code = compare(&comparison);
    for (int i = 0; i < 3; i++) fnl_image_free(NULL, &comparison.image[i]);
    return code;
}
