/* SPDX-License-Identifier: MIT */
/* fanal render: loads a scene, renders it, writes pictures and numbers. */
#include "render.h"

#include "arguments.h"
#include "bench.h" /* camera paths */
#include "commands.h"
#include "loading.h"
#include "output.h"

#include <errno.h>
#include <getopt.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

static void print_help(void) {
    puts("Usage: fanal render SCENE -o OUT.png|OUT.exr|- [-o ...] [OPTIONS]\n"
         "\n"
         "Renders SCENE, a .gltf or .glb file or builtin:NAME?key=value&... (NAME: city hall interior wall spheres pole "
         "lamps grass "
         "onetile\n"
         "nearplane sky glass). A .png holds the tone-mapped picture, an .exr linear radiance in cd/m^2.\n"
         "\n"
         "Picture\n"
         "  -o, --output FILE|-        file to write, or - for stdout; may be given several times\n"
         "  --format KIND              format of -o -: png exr raw y4m (png; for a sequence y4m)\n"
         "  --size WxH                 pixels (1280x720)\n"
         "  --camera NAME|INDEX        a camera of the scene (its first one, else one that frames the scene)\n"
         "  --camera-path KIND|FILE    renders a sequence along a path: orbit or turntable (:N sets the pictures per turn), or a\n"
         "                             file with lines 'seconds eye.x eye.y eye.z target.x target.y target.z'\n"
         "  --eye X,Y,Z --look-at X,Y,Z --fov DEGREES    a camera of your own\n"
         "  --exposure EV|auto|none    EV100 (auto)\n"
         "  --tonemap KIND             none khronos-neutral aces agx (khronos-neutral)\n"
         "  --background R,G,B         radiance of the background, cd/m^2\n"
         "  --ambient R,G,B            constant ambient light, cd/m^2 (a scene without lights gets some, and a sun)\n"
         "  --anisotropy N             maximum anisotropy of texture filtering, 1 to 16 (8)\n"
         "  --debug VIEW               shows this instead of the picture: albedo normal depth roughness lights cells\n"
         "                             overdraw overshading tile-normals backfaces layers motion decals gbuffer-0 … gbuffer-4\n"
         "                             material-id lit-forward edges halos coarse coarse-reason\n"
         "                             dais-addresses dais-triangles dais-failures clusters atlas pages\n"
         "  --aov LIST                 extra channels of the .exr: depth,normal,albedo,roughness,id,position,motion\n"
         "\n"
         "Scene\n"
         "  --lights N                 scatters N point and spot lights through the scene\n"
         "  --grow-metal N             grows the metallic areas of textures by N texels, against halos at their edges (0)\n"
         "  --light-seed S             random seed of --lights (1)\n"
         "  --light-shapes LIST        kinds of --lights: point,spot,capsule,wedge,box, each optionally with =SHARE (point=3,spot=1)\n"
         "  --light-scale X            multiplies their radius by X (1)\n"
         "  --range-roughness R        lights without a range reach as far as highlights on roughness R are visible (1)\n"
         "  --time SECONDS             time of the animation (0)\n"
         "  --animation NAME|INDEX     which animation (0)\n" LOADING_HELP);
    puts(
        "Method\n"
        "  --shading KIND             forward forward-prepass deferred deferred-volumes light-prepass pre-lighting\n"
        "                             low-res inferred light-indexed zioma visibility texturing\n"
        "                             virtual-texturing coarse dais mobile auto\n"
        "                             (deferred; with MSAA forward-prepass)\n"
        "  --lists KIND               how a pixel finds its lights; auto measures them and takes the fastest (auto)\n"
        "                             all tiled clustered clustered-cpu mesh batches multipass grid2d world halfz 2.5d\n"
        "                             enhanced tree backface fine sparse bvh raster zbin\n"
        "  --list-option KEY=VALUE,…  settings of the light lists; 'fanal render --list-option help' prints them\n"
        "  --light-lod PIXELS         lights with a smaller radius on screen are drawn as points and light nothing\n"
        "                             (0: off)\n"
        "  --deferred-pass KIND       pass type of deferred lighting: compute, or fragment with a stencil test (compute)\n"
        "  --gbuffer LAYOUT           for deferred orders: default siege killzone2 frostbite2 stalker clear-sky engel "
        "destiny;\n"
        "                             'fanal info --gbuffers' prints what each holds (default)\n"
        "  --normals ENCODING         in the G-buffer: layout octahedral xyz xy spherical sphere-map stereographic view\n"
        "                             best-fit float (layout: as the layout defines)\n"
        "  --chroma                   stores luma and alternating chroma instead of base colour in the default layout\n"
        "  --atlas-size N             virtual-texturing: maximum side of its atlas in texels (8192)\n"
        "  --gradients KIND           texturing: texture gradients: stored, or derived from neighbouring pixels, which is\n"
        "                             approximate (stored)\n"
        "  --gbuffer-prepass          orders with a G-buffer, texturing, mobile: depth prepass, so that hidden\n"
        "                             surfaces read no textures\n"
        "  --class-blocks N           deferred: sorts blocks of NxN pixels (8 or 4) by the shader features that they need (0: off)\n"
        "  --mobile-layout NAME       mobile: metallic-128 specular-160 metallic-256 specular-256 (metallic-128)\n"
        "  --visibility-sort KIND     visibility: what pixels are sorted by before shading: off class material (off)\n"
        "  --visibility-barycentrics  visibility, 1 sample: stores barycentrics, so that shading fetches no positions\n"
        "  --visibility-grid          visibility, 1 sample: draws ids at half the size with 4 samples, a quarter of the fragments;\n"
        "                             samples lie a quarter of a pixel off the pixel centres\n"
        "  --mobile-lights KIND       mobile: how a pixel finds its lights: lists volumes (lists)\n"
        "  --mobile LIST              mobile: any of gamma=srgb|sqrt|power, light=float|unorm, range=X, separate, recycle\n"
        "  --dais KIND                dais: where references to triangles are stored: target list (target)\n"
        "  --dais-multirate           dais: shades ambient light once per four pixels of a triangle: close, not equal\n"
        "  --dais-cache N             dais: buckets of the triangle cache, a power of two up to 4194304 (65536)");
    puts(
        "  --coarse LIST              coarse: any of size=2|4|1, criterion=z|id|minmax, depth-factor=X (1), normal-degrees=X (2),\n"
        "                             tolerance=X (0.05), albedo-tolerance=X (1), split=none|albedo|highlights|sharp,\n"
        "                             filter=mean|sampled|none, ao=METRES (0: off), gather; the first of each is the default\n"
        "  --shade-cost N             extra loop iterations per light evaluation, to imitate a more expensive material (0)\n"
        "  --msaa N                   samples per pixel: 1 2 4 8 (1)\n"
        "  --msaa-method KIND         deferred: which samples are shaded: all tiles stencil compact coverage aggregate\n"
        "                             (compact)\n"
        "  --msaa-groups N            aggregate: maximum number of surfaces per pixel, 2 or 3 (2)\n"
        "  --msaa-tolerance X         deferred: samples that differ by less than this, 0 to 1, count as one surface (0)");
    puts("  --decals KIND              how decals are applied: lists gbuffer off (lists); gbuffer is for deferred,\n"
         "                             deferred-volumes and mobile with one sample per pixel, everything else uses lists;\n"
         "                             'gbuffer,no-mip-fix' shows the fringe without the fix\n"
         "  --cull KIND                granularity of culling: instances clusters triangles (instances)\n"
         "  --geometry KIND            draws the remaining clusters by vertex shaders or mesh shaders: vertex mesh auto (vertex)\n"
         "  --occlusion                culls occluded geometry, by hierarchical depth in two phases\n"
         "  --transparency KIND        how blended surfaces are composed: sorted weighted linked (sorted)\n"
         "  --aa KIND                  antialiasing of edges: none mlaa smaa taa (none); taa collects 16 frames\n"
         "  --supersample N            averages N frames with different sample positions: ground truth\n"
         "\n"
         "Run\n"
         "  --frame-time SECONDS       time between the pictures of a sequence; an output with %d or %04d in its name is a\n"
         "                             sequence of --frames pictures (1/30)\n"
         "  --start-frame N            number of the first picture of a sequence (0); it ends where --frames says\n"
         "  --choose-seconds S         with --frames 2 or more: how long auto may measure first (20)\n"
         "  --frames N                 renders N frames and reports medians (1); 0: only the picture, as fast as possible\n"
         "  --stats FILE|-             writes the numbers as JSON; for a sequence one line per picture\n"
         "  --plan                     prints the frame graph\n"
         "  --traffic                  prints what each pass moves between images and memory\n"
         "  --device INDEX|NAME        as 'fanal devices' lists them (the best)\n"
         "  --validate                 Vulkan validation; any message makes the command fail\n"
         "  -q, --quiet                prints nothing but errors\n"
         "  -h, --help                 prints this text\n"
         "\n"
         "With -o - or --stats - all that is printed otherwise goes to stderr.\n"
         "Exit status: 0 when everything was written, 2 on an error; then no output file is left behind, of a sequence only\n"
         "whole pictures.\n"
         "\n"
         "Examples:\n"
         "  fanal render builtin:hall --lights 500 -o hall.png\n"
         "  fanal render \"builtin:city?lights=65536\" --shading deferred --lists tiled --frames 20 --stats city.json -o "
         "city.png\n"
         "  fanal render \"builtin:hall\" --aov depth,normal -o hall.exr --debug lights -o hall-lights.png\n"
         "  fanal render builtin:spheres --camera-path orbit:90 -o - --format y4m | ffmpeg -i - spheres.mp4");
}

/* ---- reading arguments ---- */

static const char *shading_name(int i) { return fnl_shading_name((fnl_shading)i); }
static const char *lists_name(int i) { return fnl_light_lists_name((fnl_light_lists)i); }
static const char *msaa_method_name(int i) { return fnl_msaa_method_name((fnl_msaa_method)i); }
static const char *dais_mode_name(int i) { return fnl_dais_mode_name((fnl_dais_mode)i); }
static const char *transparency_name(int i) { return fnl_transparency_name((fnl_transparency)i); }
static const char *decals_name(int i) { return fnl_decals_name((fnl_decals)i); }
static const char *mobile_lights_name(int i) { return fnl_mobile_lights_name((fnl_mobile_lights)i); }
static const char *culling_name(int i) { return fnl_culling_name((fnl_culling)i); }
static const char *geometry_name(int i) { return fnl_geometry_name((fnl_geometry)i); }
static const char *mobile_layout_name(int i) { return fnl_mobile_layout_name((fnl_mobile_layout)i); }
static const char *antialiasing_name(int i) { return fnl_antialiasing_name((fnl_antialiasing)i); }
static const char *visibility_sort_name(int i) { return fnl_visibility_sort_name((fnl_visibility_sort)i); }
static const char *deferred_pass_name(int i) { return fnl_deferred_pass_name((fnl_deferred_pass)i); }
static const char *gbuffer_name(int i) { return fnl_gbuffer_name((fnl_gbuffer)i); }
static const char *normals_name(int i) { return fnl_normal_encoding_name((fnl_normal_encoding)i); }
static const char *gradients_name(int i) { return fnl_gradients_name((fnl_gradients)i); }
static const char *tonemap_name(int i) { return fnl_tonemap_name((fnl_tonemap)i); }
static const char *debug_name(int i) { return fnl_debug_view_name((fnl_debug_view)i); }

static bool parse_aov(const char *text, uint32_t *aovs) {
    char copy[128];
    if (strlen(text) >= sizeof copy) return argument_bad("aov", text, "a list such as depth,normal");
    strcpy(copy, text);
    for (char *part = strtok(copy, ","); part; part = strtok(NULL, ",")) {
        int index;
        if (!argument_name("aov", part, render_aov_name, &index)) return false;
        *aovs |= 1u << index;
    }
    return true;
}

static bool parse_exposure(const char *text, fnl_frame *frame) {
    double ev = 0;
    frame->exposure = strcmp(text, "auto") == 0   ? FNL_EXPOSURE_AUTO
                      : strcmp(text, "none") == 0 ? FNL_EXPOSURE_NONE
                                                  : FNL_EXPOSURE_EV;
    if (frame->exposure == FNL_EXPOSURE_EV && !argument_number("exposure", text, &ev)) return false;
    frame->ev = (float)ev;
    return true;
}

static bool add_output(struct render_options *o, const char *path) {
    if (!render_is_stdout(path) && !render_has_extension(path, "png") && !render_has_extension(path, "exr"))
        return argument_bad("output", path, "a file that ends in .png or .exr, nor -");
    if (o->output_count == RENDER_MAX_OUTPUTS) return argument_bad("output", path, "among the first 16 outputs");
    o->outputs[o->output_count++] = path;
    return true;
}

enum { OPTION_FIRST = 256 };
enum {
    O_SIZE = OPTION_FIRST,
    O_CAMERA,
    O_EYE,
    O_LOOK_AT,
    O_FOV,
    O_SHADING,
    O_LISTS,
    O_LIST_OPTION,
    O_MSAA,
    O_MSAA_METHOD,
    O_MSAA_GROUPS,
    O_MSAA_TOLERANCE,
    O_AA,
    O_GBUFFER_PREPASS,
    O_MOBILE,
    O_VISIBILITY_SORT,
    O_VISIBILITY_BARYCENTRICS,
    O_COARSE,
    O_SHADE_COST,
    O_VISIBILITY_GRID,
    O_GROW_METAL,
    O_MOBILE_LAYOUT,
    O_MOBILE_LIGHTS,
    O_DAIS,
    O_DAIS_MULTIRATE,
    O_DAIS_CACHE,
    O_TRAFFIC,
    O_TRANSPARENCY,
    O_DEFERRED_PASS,
    O_GBUFFER,
    O_NORMALS,
    O_CHROMA,
    O_GRADIENTS,
    O_ATLAS_SIZE,
    O_SUPERSAMPLE,
    O_FRAME_TIME,
    O_DECALS,
    O_CULL,
    O_OCCLUSION,
    O_GEOMETRY,
    O_CLASS_BLOCKS,
    O_LIGHTS,
    O_LIGHT_SEED,
    O_LIGHT_SHAPES,
    O_LIGHT_SCALE,
    O_RANGE_ROUGHNESS,
    O_LIGHT_LOD,
    O_CHOOSE_SECONDS,
    O_EXPOSURE,
    O_TONEMAP,
    O_BACKGROUND,
    O_AMBIENT,
    O_ANISOTROPY,
    O_TIME,
    O_ANIMATION,
    O_FRAMES,
    O_DEVICE,
    O_VALIDATE,
    O_DEBUG,
    O_AOV,
    O_STATS,
    O_PLAN,
    O_CAMERA_PATH,
    O_START_FRAME,
    O_FORMAT,
    OPTION_END
};

/* "gbuffer,no-mip-fix": the way, and a switch that shows what it would be without. */
static bool parse_decals(const char *text, fnl_frame *frame) {
    static const char suffix[] = ",no-mip-fix";
    char way[32];
    size_t length = strlen(text), without = length >= sizeof suffix - 1 ? length - (sizeof suffix - 1) : 0;
    bool plain = !without || strcmp(text + without, suffix) != 0;
    snprintf(way, sizeof way, "%.*s", (int)(plain ? length : without), text);
    int index;
    if (!argument_name("decals", way, decals_name, &index)) return false;
    frame->decals = (fnl_decals)index;
    frame->decal_mip_fix = plain;
    return true;
}

static bool parse_option(struct render_options *o, int option, const char *value) {
    long long integer;
    double number;
    int index;
    switch (option) {
    case 'o':
        return add_output(o, value);
    case 'q':
        o->quiet = true;
        return true;
    case O_SIZE:
        return argument_size("size", value, &o->frame.width, &o->frame.height);
    case O_CAMERA:
        o->camera = value;
        return true;
    case O_EYE:
        o->has_eye = true;
        return argument_vector("eye", value, &o->eye);
    case O_LOOK_AT:
        o->has_look_at = true;
        return argument_vector("look-at", value, &o->look_at);
    case O_FOV:
        if (!argument_number("fov", value, &number)) return false;
        if (!(number > 0 && number < 180)) return argument_bad("fov", value, "an angle between 0 and 180 degrees");
        o->fov = (float)(number * 3.14159265358979323846 / 180);
        return true;
    case O_SHADING:
        o->has_shading = true;
        if (!argument_name("shading", value, shading_name, &index)) return false;
        o->frame.shading = (fnl_shading)index;
        return true;
    case O_LISTS:
        if (!argument_name("lists", value, lists_name, &index)) return false;
        o->frame.lists = (fnl_light_lists)index;
        return true;
    case O_LIST_OPTION:
        return argument_list_options("list-option", value, &o->frame.list_options);
    case O_MSAA:
        if (!argument_integer("msaa", value, 1, 8, &integer)) return false;
        if (integer & (integer - 1)) return argument_bad("msaa", value, "one of 1 2 4 8");
        o->frame.msaa = (uint32_t)integer;
        return true;
    case O_MSAA_METHOD:
        if (!argument_name("msaa-method", value, msaa_method_name, &index)) return false;
        o->frame.msaa_method = (fnl_msaa_method)index;
        return true;
    case O_MSAA_GROUPS:
        if (!argument_integer("msaa-groups", value, 2, 3, &integer)) return false;
        o->frame.msaa_groups = (uint32_t)integer;
        return true;
    case O_MSAA_TOLERANCE:
        if (!argument_number("msaa-tolerance", value, &number)) return false;
        if (!(number >= 0 && number <= 1)) return argument_bad("msaa-tolerance", value, "a number from 0 to 1");
        o->frame.msaa_tolerance = (float)number;
        return true;
    case O_GROW_METAL:
        if (!argument_integer("grow-metal", value, 0, 64, &integer)) return false;
        o->grow_metal = (uint32_t)integer;
        return true;
    case O_MOBILE:
        return argument_mobile("mobile", value, &o->frame.mobile);
    case O_VISIBILITY_GRID:
        o->frame.visibility.grid = true;
        return true;
    case O_VISIBILITY_BARYCENTRICS:
        o->frame.visibility.barycentrics = true;
        return true;
    case O_VISIBILITY_SORT:
        if (!argument_name("visibility-sort", value, visibility_sort_name, &index)) return false;
        o->frame.visibility.sort = (fnl_visibility_sort)index;
        return true;
    case O_COARSE:
        return argument_coarse("coarse", value, &o->frame.coarse);
    case O_SHADE_COST:
        if (!argument_integer("shade-cost", value, 0, 100000, &integer)) return false;
        o->frame.shade_cost = (uint32_t)integer;
        return true;
    case O_MOBILE_LAYOUT:
        if (!argument_name("mobile-layout", value, mobile_layout_name, &index)) return false;
        o->frame.mobile.layout = (fnl_mobile_layout)index;
        return true;
    case O_MOBILE_LIGHTS:
        if (!argument_name("mobile-lights", value, mobile_lights_name, &index)) return false;
        o->frame.mobile.lights = (fnl_mobile_lights)index;
        return true;
    case O_DAIS:
        if (!argument_name("dais", value, dais_mode_name, &index)) return false;
        o->frame.dais.mode = (fnl_dais_mode)index;
        return true;
    case O_DAIS_MULTIRATE:
        o->frame.dais.multirate = true;
        return true;
    case O_DAIS_CACHE:
        if (!argument_integer("dais-cache", value, 1, 1 << 22, &integer)) return false;
        if (integer & (integer - 1)) return argument_bad("dais-cache", value, "a power of two");
        o->frame.dais.cache_buckets = (uint32_t)integer;
        return true;
    case O_TRAFFIC:
        o->traffic = true;
        return true;
    case O_TRANSPARENCY:
        if (!argument_name("transparency", value, transparency_name, &index)) return false;
        o->frame.transparency = (fnl_transparency)index;
        return true;
    case O_DECALS:
        return parse_decals(value, &o->frame);
    case O_OCCLUSION:
        o->frame.occlusion = true;
        return true;
    case O_GEOMETRY:
        if (!argument_name("geometry", value, geometry_name, &index)) return false;
        o->frame.geometry = (fnl_geometry)index;
        return true;
    case O_CULL:
        if (!argument_name("cull", value, culling_name, &index)) return false;
        o->frame.culling = (fnl_culling)index;
        return true;
    case O_AA:
        if (!argument_name("aa", value, antialiasing_name, &index)) return false;
        o->frame.aa = (fnl_antialiasing)index;
        return true;
    case O_DEFERRED_PASS:
        if (!argument_name("deferred-pass", value, deferred_pass_name, &index)) return false;
        o->frame.deferred_pass = (fnl_deferred_pass)index;
        return true;
    case O_GBUFFER:
        if (!argument_name("gbuffer", value, gbuffer_name, &index)) return false;
        o->frame.gbuffer = (fnl_gbuffer)index;
        return true;
    case O_NORMALS:
        if (!argument_name("normals", value, normals_name, &index)) return false;
        o->frame.normals = (fnl_normal_encoding)index;
        return true;
    case O_ATLAS_SIZE:
        if (!argument_integer("atlas-size", value, 256, 8192, &integer)) return false;
        if (integer % 256) return argument_bad("atlas-size", value, "a multiple of 256");
        o->frame.atlas_size = (uint32_t)integer;
        return true;
    case O_GRADIENTS:
        if (!argument_name("gradients", value, gradients_name, &index)) return false;
        o->frame.gradients = (fnl_gradients)index;
        return true;
    case O_CHROMA:
        o->frame.chroma = true;
        return true;
    case O_SUPERSAMPLE:
        if (!argument_integer("supersample", value, 1, 4096, &integer)) return false;
        o->supersample = (uint32_t)integer;
        return true;
    case O_FRAME_TIME:
        if (!argument_number("frame-time", value, &o->frame_time)) return false;
        return (o->has_frame_time = o->frame_time >= 0) || argument_bad("frame-time", value, "a number of seconds");
    case O_GBUFFER_PREPASS:
        o->frame.gbuffer_prepass = true;
        return true;
    case O_CLASS_BLOCKS:
        if (!argument_integer("class-blocks", value, 0, 8, &integer)) return false;
        if (integer % 4) return argument_bad("class-blocks", value, "one of 0 4 8");
        o->frame.class_blocks = (uint32_t)integer;
        return true;
    case O_LIGHTS:
        if (!argument_integer("lights", value, 0, 1 << 24, &integer)) return false;
        o->scatter.count = (uint32_t)integer;
        return true;
    case O_LIGHT_SEED:
        if (!argument_integer("light-seed", value, 0, INT64_MAX, &integer)) return false;
        o->scatter.seed = (uint64_t)integer;
        return true;
    case O_LIGHT_SHAPES:
        return argument_light_shapes("light-shapes", value, &o->scatter);
    case O_LIGHT_SCALE:
        if (!argument_number("light-scale", value, &number)) return false;
        if (!(number > 0 && number <= 1e6)) return argument_bad("light-scale", value, "a factor above 0");
        o->scatter.radius_scale = (float)number;
        return true;
    case O_LIGHT_LOD:
        if (!argument_number("light-lod", value, &number)) return false;
        if (!(number >= 0 && number <= 1e6)) return argument_bad("light-lod", value, "a number of pixels");
        o->frame.light_lod = (float)number;
        return true;
    case O_CHOOSE_SECONDS:
        if (!argument_number("choose-seconds", value, &number)) return false;
        if (!(number >= 0 && number <= 1e6)) return argument_bad("choose-seconds", value, "a number of seconds");
        o->choose_seconds = number;
        return true;
    case O_RANGE_ROUGHNESS:
        if (!argument_number("range-roughness", value, &number)) return false;
        if (!(number >= 0 && number <= 1)) return argument_bad("range-roughness", value, "a number from 0 to 1");
        o->has_range_roughness = true;
        o->range_roughness = (float)number;
        return true;
    case O_EXPOSURE:
        return parse_exposure(value, &o->frame);
    case O_TONEMAP:
        if (!argument_name("tonemap", value, tonemap_name, &index)) return false;
        o->frame.tonemap = (fnl_tonemap)index;
        return true;
    case O_ANISOTROPY:
        if (!argument_number("anisotropy", value, &number)) return false;
        if (!(number >= 1 && number <= 16)) return argument_bad("anisotropy", value, "a number from 1 to 16");
        o->has_anisotropy = true;
        o->anisotropy = (float)number;
        return true;
    case O_BACKGROUND:
        o->has_background = true;
        return argument_vector("background", value, &o->background);
    case O_AMBIENT:
        o->has_ambient = true;
        return argument_vector("ambient", value, &o->ambient);
    case O_TIME:
        return argument_number("time", value, &o->time);
    case O_ANIMATION:
        o->animation = value;
        return true;
    case O_FRAMES:
        if (!argument_integer("frames", value, 0, 1000000, &integer)) return false;
        o->frame_count = (uint32_t)integer;
        o->has_frames = true;
        return true;
    case O_DEVICE:
        o->device = value;
        return true;
    case O_VALIDATE:
        o->validate = true;
        return true;
    case O_DEBUG:
        if (!argument_name("debug", value, debug_name, &index)) return false;
        o->frame.debug = (fnl_debug_view)index;
        return true;
    case O_AOV:
        return parse_aov(value, &o->aovs);
    case O_STATS:
        o->stats = value;
        return true;
    case O_PLAN:
        o->plan = true;
        return true;
    case O_CAMERA_PATH:
        o->camera_path = value;
        return true;
    case O_START_FRAME:
        if (!argument_integer("start-frame", value, 0, 999999, &integer)) return false;
        o->start_frame = (uint32_t)integer;
        return true;
    case O_FORMAT:
        if (!argument_name("format", value, render_format_name, &index)) return false;
        o->format = (enum render_format)index;
        o->has_format = true;
        return true;
    default:
        return false;
    }
}

static const struct option long_options[] = {{"output", required_argument, NULL, 'o'},
                                             {"quiet", no_argument, NULL, 'q'},
                                             {"help", no_argument, NULL, 'h'},
                                             {"size", required_argument, NULL, O_SIZE},
                                             {"camera", required_argument, NULL, O_CAMERA},
                                             {"eye", required_argument, NULL, O_EYE},
                                             {"look-at", required_argument, NULL, O_LOOK_AT},
                                             {"fov", required_argument, NULL, O_FOV},
                                             {"shading", required_argument, NULL, O_SHADING},
                                             {"lists", required_argument, NULL, O_LISTS},
                                             {"list-option", required_argument, NULL, O_LIST_OPTION},
                                             {"msaa", required_argument, NULL, O_MSAA},
                                             {"msaa-method", required_argument, NULL, O_MSAA_METHOD},
                                             {"msaa-groups", required_argument, NULL, O_MSAA_GROUPS},
                                             {"msaa-tolerance", required_argument, NULL, O_MSAA_TOLERANCE},
                                             {"aa", required_argument, NULL, O_AA},
                                             {"coarse", required_argument, NULL, O_COARSE},
                                             {"shade-cost", required_argument, NULL, O_SHADE_COST},
                                             {"deferred-pass", required_argument, NULL, O_DEFERRED_PASS},
                                             {"gbuffer", required_argument, NULL, O_GBUFFER},
                                             {"normals", required_argument, NULL, O_NORMALS},
                                             {"chroma", no_argument, NULL, O_CHROMA},
                                             {"atlas-size", required_argument, NULL, O_ATLAS_SIZE},
                                             {"gradients", required_argument, NULL, O_GRADIENTS},
                                             {"supersample", required_argument, NULL, O_SUPERSAMPLE},
                                             {"frame-time", required_argument, NULL, O_FRAME_TIME},
                                             {"gbuffer-prepass", no_argument, NULL, O_GBUFFER_PREPASS},
                                             {"transparency", required_argument, NULL, O_TRANSPARENCY},
                                             {"decals", required_argument, NULL, O_DECALS},
                                             {"occlusion", no_argument, NULL, O_OCCLUSION},
                                             {"cull", required_argument, NULL, O_CULL},
                                             {"geometry", required_argument, NULL, O_GEOMETRY},
                                             {"mobile", required_argument, NULL, O_MOBILE},
                                             {"visibility-sort", required_argument, NULL, O_VISIBILITY_SORT},
                                             {"visibility-barycentrics", no_argument, NULL, O_VISIBILITY_BARYCENTRICS},
                                             {"visibility-grid", no_argument, NULL, O_VISIBILITY_GRID},
                                             {"grow-metal", required_argument, NULL, O_GROW_METAL},
                                             {"mobile-layout", required_argument, NULL, O_MOBILE_LAYOUT},
                                             {"mobile-lights", required_argument, NULL, O_MOBILE_LIGHTS},
                                             {"dais", required_argument, NULL, O_DAIS},
                                             {"dais-multirate", no_argument, NULL, O_DAIS_MULTIRATE},
                                             {"dais-cache", required_argument, NULL, O_DAIS_CACHE},
                                             {"traffic", no_argument, NULL, O_TRAFFIC},
                                             {"class-blocks", required_argument, NULL, O_CLASS_BLOCKS},
                                             {"lights", required_argument, NULL, O_LIGHTS},
                                             {"light-seed", required_argument, NULL, O_LIGHT_SEED},
                                             {"light-shapes", required_argument, NULL, O_LIGHT_SHAPES},
                                             {"light-scale", required_argument, NULL, O_LIGHT_SCALE},
                                             {"range-roughness", required_argument, NULL, O_RANGE_ROUGHNESS},
                                             {"light-lod", required_argument, NULL, O_LIGHT_LOD},
                                             {"choose-seconds", required_argument, NULL, O_CHOOSE_SECONDS},
                                             {"exposure", required_argument, NULL, O_EXPOSURE},
                                             {"tonemap", required_argument, NULL, O_TONEMAP},
                                             {"anisotropy", required_argument, NULL, O_ANISOTROPY},
                                             {"background", required_argument, NULL, O_BACKGROUND},
                                             {"ambient", required_argument, NULL, O_AMBIENT},
                                             {"time", required_argument, NULL, O_TIME},
                                             {"animation", required_argument, NULL, O_ANIMATION},
                                             {"frames", required_argument, NULL, O_FRAMES},
                                             {"device", required_argument, NULL, O_DEVICE},
                                             {"validate", no_argument, NULL, O_VALIDATE},
                                             {"debug", required_argument, NULL, O_DEBUG},
                                             {"aov", required_argument, NULL, O_AOV},
                                             {"stats", required_argument, NULL, O_STATS},
                                             {"plan", no_argument, NULL, O_PLAN},
                                             {"camera-path", required_argument, NULL, O_CAMERA_PATH},
                                             {"start-frame", required_argument, NULL, O_START_FRAME},
                                             {"format", required_argument, NULL, O_FORMAT},
                                             LOADING_OPTIONS,
                                             {NULL, 0, NULL, 0}};

/* Of two outputs that are one file the first would be lost. Patterns of sequences count without the widths of their numbers. */
static bool is_same_file(const char *a, const char *b) {
    char plain[2][4096];
    for (int i = 0; i < 2; i++) {
        const char *path = i ? b : a, *percent = strchr(path, '%');
        int before = percent ? (int)(percent + 1 - path) : (int)strlen(path);
        const char *after = path + before + strspn(path + before, percent ? "0123456789" : "");
        snprintf(plain[i], sizeof plain[i], "%.*s%s", before, path, after);
    }
    return output_is_same(plain[0], plain[1]);
}

static bool check_files(const struct render_options *o) {
    const char *files[RENDER_MAX_OUTPUTS + 2];
    int count = 0;
    for (; count < o->output_count; count++) files[count] = o->outputs[count];
    if (o->stats) files[count++] = o->stats;
    int written = count;
    files[count++] = o->scene;
    for (int i = 0; i < written; i++)
        for (int k = i + 1; k < count; k++) {
            if (!is_same_file(files[i], files[k])) continue;
            fprintf(stderr, "fanal: error: %s and %s are one file%s\n", files[i], files[k],
                    k < written ? ", which would be written twice" : ": the scene would be overwritten");
            return false;
        }
    return true;
}

/* What only makes sense together. */
static bool check_options(struct render_options *o) {
    const char *problem = NULL;
    bool has_exr = false, has_stdout = false, sequence = render_makes_sequence(o);
    uint32_t circle = 0;
    for (int i = 0; i < o->output_count; i++) {
        enum render_format format = render_format_of(o, o->outputs[i]);
        bool is_stdout = render_is_stdout(o->outputs[i]);
        has_exr = has_exr || format == RENDER_EXR;
        if (is_stdout && has_stdout) problem = "-o - may be given once";
        has_stdout = has_stdout || is_stdout;
        if (sequence && is_stdout && format != RENDER_RAW && format != RENDER_Y4M)
            problem = "a sequence goes to stdout as --format raw or y4m";
        if (sequence && !is_stdout && !render_is_sequence(o->outputs[i]))
            problem = "each output of a sequence has one %d, or as %04d, for the frame's number";
    }
    if (o->output_count == 0 && !o->stats && !o->plan && !o->traffic)
        problem = "no output was asked for: give -o FILE, --stats FILE, --plan or --traffic";
    if (o->has_format && !has_stdout) problem = "--format is for -o -: files have it in their names";
    if (has_stdout && o->stats && render_is_stdout(o->stats)) problem = "stdout takes the picture or --stats, not both";
    if (o->has_eye != o->has_look_at) problem = "--eye and --look-at belong together";
    if (o->camera && o->has_eye) problem = "--camera and --eye exclude one another";
    if (o->camera_path && o->has_eye) problem = "--camera-path and --eye exclude one another";
    if (o->camera_path && !o->has_frames && bench_path_is_circle(o->camera_path, &circle) && circle == 0)
        problem = "--camera-path orbit and turntable need --frames, or as orbit:N the pictures once round";
    if (o->aovs && !has_exr) problem = "--aov needs an .exr output";
    if (o->supersample > 1 && o->frame.aa == FNL_ANTIALIASING_TAA) problem = "--supersample is no --aa taa";
    if (o->frame_count == 0 && (o->stats || sequence)) problem = "--frames 0 is a picture without numbers: not with --stats, nor for a sequence";
    if (o->has_frame_time && !sequence) problem = "--frame-time is for sequences: -o NAME-%04d.png";
    if (o->start_frame > 0 && !sequence) problem = "--start-frame is for sequences: -o NAME-%04d.png";
    if (problem) fprintf(stderr, "fanal: error: %s; see 'fanal render --help'\n", problem);
    return !problem;
}

/* Settings of orders that are not rendered with are harmless, but hardly what was meant. auto may take any order, so it may need any. */
static void warn_of_unused(const struct render_options *o, const bool *given) {
#define ORDER(order) (1u << FNL_SHADING_##order)
    static const struct {
        const char *name;
        int option;
        uint32_t orders;
    } settings[] = {{"visibility-sort", O_VISIBILITY_SORT, ORDER(VISIBILITY)},
                    {"visibility-barycentrics", O_VISIBILITY_BARYCENTRICS, ORDER(VISIBILITY)},
                    {"visibility-grid", O_VISIBILITY_GRID, ORDER(VISIBILITY)},
                    {"gradients", O_GRADIENTS, ORDER(TEXTURING)},
                    {"atlas-size", O_ATLAS_SIZE, ORDER(VIRTUAL_TEXTURING)},
                    {"coarse", O_COARSE, ORDER(COARSE)},
                    {"dais", O_DAIS, ORDER(DAIS)},
                    {"dais-multirate", O_DAIS_MULTIRATE, ORDER(DAIS)},
                    {"dais-cache", O_DAIS_CACHE, ORDER(DAIS)},
                    {"mobile", O_MOBILE, ORDER(MOBILE)},
                    {"mobile-layout", O_MOBILE_LAYOUT, ORDER(MOBILE)},
                    {"mobile-lights", O_MOBILE_LIGHTS, ORDER(MOBILE)},
                    {"class-blocks", O_CLASS_BLOCKS, ORDER(DEFERRED)},
                    {"deferred-pass", O_DEFERRED_PASS, ORDER(DEFERRED)},
                    {"msaa-method", O_MSAA_METHOD, ORDER(DEFERRED)},
                    {"msaa-groups", O_MSAA_GROUPS, ORDER(DEFERRED)},
                    {"msaa-tolerance", O_MSAA_TOLERANCE, ORDER(DEFERRED)},
                    {"gbuffer", O_GBUFFER, ORDER(DEFERRED) | ORDER(DEFERRED_VOLUMES)},
                    {"normals", O_NORMALS, ORDER(DEFERRED) | ORDER(DEFERRED_VOLUMES)},
                    {"chroma", O_CHROMA, ORDER(DEFERRED) | ORDER(DEFERRED_VOLUMES)},
                    {"gbuffer-prepass", O_GBUFFER_PREPASS,
                     ~(ORDER(FORWARD) | ORDER(FORWARD_PREPASS) | ORDER(INFERRED) | ORDER(LIGHT_INDEXED) | ORDER(ZIOMA) |
                       ORDER(VISIBILITY) | ORDER(DAIS))},
                    {"occlusion", O_OCCLUSION, ~(ORDER(LOW_RES) | ORDER(INFERRED))}};
#undef ORDER
    if (o->frame.shading == FNL_SHADING_AUTO || o->quiet) return;
    for (size_t i = 0; i < sizeof settings / sizeof *settings; i++)
        if (given[settings[i].option - OPTION_FIRST] && !(settings[i].orders >> o->frame.shading & 1))
            fprintf(stderr, "fanal: warning: --%s has no effect with --shading %s\n", settings[i].name,
                    fnl_shading_name(o->frame.shading));
}

int command_render(int argc, char **argv) {
    struct render_options o = {.frame = fnl_frame_default(),
                               .scatter = fnl_scatter_params_default(),
                               .loading = fnl_load_params_default(),
                               .frame_count = 1,
                               .frame_time = 1 / 30.0,
                               .choose_seconds = 20};
    bool given[OPTION_END - OPTION_FIRST] = {false};
    optind = 0;
    for (int option; (option = getopt_long(argc, argv, "o:qh", long_options, NULL)) != -1;) {
        if (option >= OPTION_FIRST) given[option - OPTION_FIRST] = true;
        if (option == 'h') {
            print_help();
            return 0;
        }
        if (option == '?') {
            fputs("fanal: see 'fanal render --help'\n", stderr);
            return 2;
        }
        if (!(loading_has(option) ? loading_parse(option, optarg, &o.loading) : parse_option(&o, option, optarg))) return 2;
    }
    if (argc - optind != 1) {
        fprintf(stderr, "fanal: error: one scene is needed, %d were given; see 'fanal render --help'\n", argc - optind);
        return 2;
    }
    o.scene = argv[optind];
    if (!check_options(&o) || !check_files(&o)) return 2;
    if (!o.has_shading && o.frame.msaa > 1) o.frame.shading = FNL_SHADING_FORWARD_PREPASS;
    warn_of_unused(&o, given);
    return render_run(&o);
}
