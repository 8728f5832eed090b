/* SPDX-License-Identifier: MIT */
#include "passes/mobile/mobile.h"

#include "base/check.h"
#include "passes/mobile/mobile_volume_shared.h"
#include "passes/post/post_shared.h"
#include "passes/transparency/transparency.h"
#include "shaders.h"

#include <math.h>

_Static_assert((int)FNL_MOBILE_METALLIC_128 == GPU_MOBILE_METALLIC_128 &&
                   (int)FNL_MOBILE_SPECULAR_160 == GPU_MOBILE_SPECULAR_160 &&
                   (int)FNL_MOBILE_METALLIC_256 == GPU_MOBILE_METALLIC_256 &&
                   (int)FNL_MOBILE_SPECULAR_256 == GPU_MOBILE_SPECULAR_256 &&
                   FNL_MOBILE_LAYOUT_COUNT == FNL_MOBILE_SPECULAR_256 + 1,
               "mobile_shared.h has the values of fnl_mobile_layout");
_Static_assert((uint32_t)FNL_MOBILE_GAMMA_SRGB == GPU_MOBILE_SRGB && (uint32_t)FNL_MOBILE_GAMMA_SQRT == GPU_MOBILE_SQRT &&
                   (uint32_t)FNL_MOBILE_GAMMA_POWER == GPU_MOBILE_POWER && FNL_MOBILE_GAMMA_COUNT == FNL_MOBILE_GAMMA_POWER + 1,
               "mobile_shared.h has the values of fnl_mobile_gamma");


static const float FLOAT11_MOST = 64512.0f; /* the largest 10-bit float, the smaller one of the two kinds in B10G11R11 */
static const float HALF_MOST = 65504.0f;
static const float SKY = 3e38f; /* positions of pixels that show nothing; beyond MOBILE_FAR of mobile.glsl */

/* ---- layouts ---- */

#define TARGET(name, format, used)                                                                                          \
    { name, VK_FORMAT_##format, 32, used }

struct mobile_layout mobile_layout(fnl_mobile_layout layout, fnl_mobile_gamma gamma, bool float_light) {
    struct mobile_target light = TARGET("mobile light", A2B10G10R10_UNORM_PACK32, 30);
    if (float_light) light = (struct mobile_target)TARGET("mobile light", B10G11R11_UFLOAT_PACK32, 32);
    const VkFormat color = gamma == FNL_MOBILE_GAMMA_SRGB ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
    switch (layout) {
    case FNL_MOBILE_SPECULAR_160:
        return (struct mobile_layout){.targets = {light,
                                                  TARGET("mobile depth", R32_SFLOAT, 32),
                                                  TARGET("mobile normal", R8G8B8A8_UNORM, 32),
                                                  {"mobile diffuse", color, 32, 24},
                                                  {"mobile specular", color, 32, 24}},
                                      .target_count = 5,
                                      .light_count = 1,
                                      .normal = 2};
    case FNL_MOBILE_METALLIC_256:
        return (struct mobile_layout){
            .targets = {TARGET("mobile x", R32_SFLOAT, 32), TARGET("mobile y", R32_SFLOAT, 32),
                        TARGET("mobile z", R32_SFLOAT, 32), TARGET("mobile light rg", R16G16_SFLOAT, 32),
                        TARGET("mobile light b, normal x", R16G16_SFLOAT, 32), TARGET("mobile normal yz", R16G16_SFLOAT, 32),
                        TARGET("mobile roughness", R16G16_SFLOAT, 32), TARGET("mobile color", B10G11R11_UFLOAT_PACK32, 32)},
            .target_count = 8,
            .lights = {3, 4},
            .light_count = 2,
            .normal = -1,
            .wide = true};
    case FNL_MOBILE_SPECULAR_256:
        return (struct mobile_layout){.targets = {TARGET("mobile x", R32_SFLOAT, 32), TARGET("mobile y", R32_SFLOAT, 32),
                                                  TARGET("mobile z", R32_SFLOAT, 32),
                                                  TARGET("mobile light rg", R16G16_SFLOAT, 32),
                                                  TARGET("mobile light b, roughness", R16G16_SFLOAT, 32),
                                                  TARGET("mobile normal", B10G11R11_UFLOAT_PACK32, 32),
                                                  TARGET("mobile diffuse", B10G11R11_UFLOAT_PACK32, 32),
                                                  TARGET("mobile specular", B10G11R11_UFLOAT_PACK32, 32)},
                                      .target_count = 8,
                                      .lights = {3, 4},
                                      .light_count = 2,
                                      .normal = -1,
                                      .wide = true};
    case FNL_MOBILE_METALLIC_128:
    default:
        return (struct mobile_layout){.targets = {light,
                                                  TARGET("mobile depth", R32_SFLOAT, 32),
                                                  TARGET("mobile normal", R8G8B8A8_UNORM, 32),
                                                  {"mobile color", color, 32, 32}},
                                      .target_count = 4,
                                      .light_count = 1,
                                      .normal = 2};
    }
}

uint32_t fnl_mobile_layout_targets(fnl_mobile_layout layout, fnl_mobile_target *out, uint32_t capacity) {
    if ((uint32_t)layout >= FNL_MOBILE_LAYOUT_COUNT) return 0;
    if (capacity && check_handle(__func__, "out", out) != FNL_OK) return 0;
    struct mobile_layout known = mobile_layout(layout, FNL_MOBILE_GAMMA_SRGB, false);
    for (uint32_t i = 0; i < MIN(known.target_count, capacity); i++)
        out[i] = (fnl_mobile_target){known.targets[i].name, known.targets[i].bits, known.targets[i].used_bits};
    return known.target_count;
}

struct mobile_scale mobile_scale(const struct mobile_params *params, float factor, float range) {
    bool wide = params->layout == FNL_MOBILE_METALLIC_256 || params->layout == FNL_MOBILE_SPECULAR_256;
    if (wide) return (struct mobile_scale){factor, HALF_MOST};
    if (params->float_light) return (struct mobile_scale){factor, FLOAT11_MOST};
    return (struct mobile_scale){factor / range, 1};
}

bool mobile_supported(const gpu_device *device, const struct mobile_params *params) {
    struct mobile_layout layout = mobile_layout(params->layout, params->gamma, params->float_light);
    for (uint32_t i = 0; i < layout.target_count; i++) {
        VkFormatFeatureFlags2 wanted = VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BIT | VK_FORMAT_FEATURE_2_SAMPLED_IMAGE_BIT;
        for (uint32_t k = 0; k < layout.light_count; k++)
            if (layout.lights[k] == i) wanted |= VK_FORMAT_FEATURE_2_COLOR_ATTACHMENT_BLEND_BIT;
        if (!gpu_format_supports(device, layout.targets[i].format, wanted)) return false;
    }
    return true;
}

/* ---- what the steps have in common ---- */

struct targets {
    struct mobile_layout layout;
    graph_image images[MOBILE_TARGETS];
};

struct step_data {
    struct targets targets;
    bool merged;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    struct gpu_graphics_params state;
    struct gpu_mobile_push push;
    uint32_t reads; /* targets that are sampled when separate, as bits */
    struct {
        graph_image image; /* id 0: none */
        uint32_t input;
    } others[2]; /* what else is */
};

static void set_formats(struct gpu_graphics_params *state, const struct mobile_layout *layout, const uint32_t *indices,
                        uint32_t count) {
    state->color_count = count;
    for (uint32_t i = 0; i < count; i++) state->color_formats[i] = layout->targets[indices ? indices[i] : i].format;
}

static void execute_screen(const struct graph_context *context, const void *data) {
    const struct step_data *d = data;
    struct gpu_mobile_push push = d->push;
    push.counters = d->counters.id ? graph_address(context, d->counters) : 0;
    for (uint32_t i = 0; i < d->targets.layout.target_count && !d->merged; i++)
        if (d->reads >> i & 1) push.images[i] = graph_sampled(context, d->targets.images[i]);
    for (uint32_t i = 0; i < COUNT_OF(d->others) && !d->merged; i++)
        if (d->others[i].image.id) push.images[d->others[i].input] = graph_sampled(context, d->others[i].image);
    gpu_bind(context->commands, graph_pipeline(context, &d->state));
    gpu_push(context->commands, &push, sizeof push);
    gpu_draw(context->commands, 3, 1, 0, 0);
}

static struct gpu_graphics_params screen_state(const struct gpu_shader *fragment) {
    return (struct gpu_graphics_params){.vertex = &shader_mobile_screen_vert,
                                        .fragment = fragment,
                                        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST,
                                        .samples = 1};
}

/* ---- geometry ---- */

struct gbuffer_data {
    const struct geometry_scene *scene;
    struct geometry_draws draws;
    VkDeviceAddress view, lighting;
    graph_buffer counters;
    enum geometry_set set;
    struct gpu_graphics_params state;
};

static void execute_geometry(const struct graph_context *context, const void *data) {
    const struct gbuffer_data *d = data;
    geometry_draw(context, d->scene, &d->draws, d->set, &d->state, NULL,
                  (struct gpu_geometry_push){.view = d->view,
                                             .lighting = d->lighting,
                                             .counters = d->counters.id ? graph_address(context, d->counters) : 0});
}

static void add_gbuffer(struct graph *graph, const struct shade_input *input, bool prepass, graph_image depth,
                        const struct mobile_params *params, const struct targets *targets) {
    static const struct gpu_shader *const shaders[] = {
        &shader_mobile_gbuffer_metallic_128_frag, &shader_mobile_gbuffer_specular_160_frag,
        &shader_mobile_gbuffer_metallic_256_frag, &shader_mobile_gbuffer_specular_256_frag};
    struct gbuffer_data data = {.scene = input->scene, .draws = *input->draws, .view = input->view, .set = GEOMETRY_OPAQUE};
    data.state =
        (struct gpu_graphics_params){.fragment = shaders[params->layout],
                                     .constant_count = GAMMA_ID + 1,
                                     .constants = {[LIGHTING_ID] = environment_kind(&input->environment), [HAS_LIGHTS_ID] = 1,
                                                   [HAS_METAL_ID] = 1, [GAMMA_ID] = (uint32_t)params->gamma},
                                     .depth_format = GEOMETRY_DEPTH_FORMAT,
                                     .depth_test = true,
                                     .depth_write = !prepass,
                                     .depth_compare = prepass ? VK_COMPARE_OP_EQUAL : VK_COMPARE_OP_GREATER_OR_EQUAL,
                                     .samples = 1};
    set_formats(&data.state, &targets->layout, NULL, targets->layout.target_count);
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile gbuffer", GRAPH_QUEUE_GRAPHICS, execute_geometry, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_OPAQUE);
    environment_use(pass, &input->environment, GRAPH_READ_FRAGMENT);
    float clears[MOBILE_TARGETS][4] = {{0}}, background[3];
    for (uint32_t i = 0; i < 3; i++) background[i] = fminf(input->background[i] * params->scale.scale, params->scale.most);
    if (targets->layout.wide) {
        clears[0][0] = SKY;
        memcpy(clears[3], background, 2 * sizeof(float));
        clears[4][0] = background[2];
    } else {
        memcpy(clears[0], background, 3 * sizeof(float));
    }
    for (uint32_t i = 0; i < targets->layout.target_count; i++)
        graph_color(pass, targets->images[i], VK_ATTACHMENT_LOAD_OP_CLEAR, clears[i]);
    if (prepass)
        graph_depth_read_only(pass, depth);
    else
        graph_depth(pass, depth, VK_ATTACHMENT_LOAD_OP_CLEAR, 0);
}

/* ---- decals ---- */

static bool is_light(const struct mobile_layout *layout, uint32_t target) {
    return target == layout->lights[0] || (layout->light_count > 1 && target == layout->lights[1]);
}

static void add_decals(struct graph *graph, const struct shade_input *input, const struct mobile_params *params, bool merged,
                       const struct mobile_decals *decals, struct targets *targets) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_decals_metallic_128_frag, &shader_mobile_decals_metallic_128_local_frag},
        {&shader_mobile_decals_specular_160_frag, &shader_mobile_decals_specular_160_local_frag},
        {&shader_mobile_decals_metallic_256_frag, &shader_mobile_decals_metallic_256_local_frag},
        {&shader_mobile_decals_specular_256_frag, &shader_mobile_decals_specular_256_local_frag}};
    const struct mobile_layout *layout = &targets->layout;
    struct step_data data = {.targets = *targets,
                             .merged = merged,
                             .reads = (1u << layout->target_count) - 1,
                             .state = screen_state(shaders[params->layout][merged])};
    data.push.view = input->view;
    data.state.constant_count = GAMMA_ID + 1;
    data.state.constants[LIGHTING_ID] = environment_kind(&input->environment);
    data.state.constants[HAS_LIGHTS_ID] = data.state.constants[HAS_METAL_ID] = 1;
    data.state.constants[GAMMA_ID] = (uint32_t)params->gamma;
    uint32_t changed[MOBILE_TARGETS], count = 0;
    for (uint32_t i = 0; i < layout->target_count; i++)
        if (!layout->wide || i < 1 || i > 2) changed[count++] = i; /* y and z stay; x or depth: the mark of what leans */
    set_formats(&data.state, layout, changed, count);
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile decals", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    light_list_use(pass, decals->list, GRAPH_READ_FRAGMENT);
    environment_use(pass, &input->environment, GRAPH_READ_FRAGMENT);
    graph_use_buffer(pass, decals->decals, GRAPH_READ_FRAGMENT);
    for (uint32_t i = 0, k = 0; i < layout->target_count; i++)
        if (k < count && changed[k] == i) {
            targets->images[i] = graph_local_rewrite(pass, i, targets->images[i]);
            k++;
        } else {
            graph_local_read(pass, i, targets->images[i]);
        }
}

/* ---- lights ---- */

static void add_lights(struct graph *graph, const struct shade_input *input, const struct mobile_params *params, bool merged,
                       struct targets *targets) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_light_metallic_128_frag, &shader_mobile_light_metallic_128_local_frag},
        {&shader_mobile_light_specular_160_frag, &shader_mobile_light_specular_160_local_frag},
        {&shader_mobile_light_metallic_256_frag, &shader_mobile_light_metallic_256_local_frag},
        {&shader_mobile_light_specular_256_frag, &shader_mobile_light_specular_256_local_frag}};
    const struct mobile_layout *layout = &targets->layout;
    struct step_data data = {.targets = *targets,
                             .merged = merged,
                             .counters = input->counters,
                             .reads = (1u << layout->target_count) - 1,
                             .state = screen_state(shaders[params->layout][merged])};
    data.push.view = input->view;
    data.push.lighting = input->lighting->address;
    data.state.constant_count = GAMMA_ID + 1;
    data.state.constants[LIGHTING_ID] = input->lighting->bits;
    data.state.constants[COUNT_LIGHTS_ID] = input->counters.id != 0;
    data.state.constants[HAS_LIGHTS_ID] = data.state.constants[HAS_METAL_ID] = 1;
    data.state.constants[GAMMA_ID] = (uint32_t)params->gamma;
    set_formats(&data.state, layout, layout->lights, layout->light_count);
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile lights", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    for (uint32_t i = 0; i < layout->target_count; i++) {
        if (is_light(layout, i))
            targets->images[i] = graph_local_rewrite(pass, i, targets->images[i]);
        else
            graph_local_read(pass, i, targets->images[i]);
    }
}

/* ---- lights as volumes ---- */

struct volume_data {
    struct targets targets;
    struct volumes volumes;
    bool merged;
    VkDeviceAddress view;
    graph_buffer counters;
    struct gpu_graphics_params state;
};

static void execute_volumes(const struct graph_context *context, const void *data) {
    const struct volume_data *d = data;
    struct gpu_graphics_params state = d->state;
    struct gpu_mobile_volume_push push = {.view = d->view,
                                          .counters = d->counters.id ? graph_address(context, d->counters) : 0};
    for (uint32_t i = 0; i < d->targets.layout.target_count && !d->merged; i++)
        push.images[i] = graph_sampled(context, d->targets.images[i]);
    volumes_draw(context, &d->volumes, &state, (struct gpu_volume_head *)&push, sizeof push);
}

_Static_assert(offsetof(struct gpu_mobile_volume_push, images) == sizeof(struct gpu_volume_head),
               "it begins as gpu_volume_head");

/* Into a sum of their own: in ten bits of light a pixel's faint lights would get lost one by one. */
static void add_volumes(struct graph *graph, const struct shade_input *input, const struct volumes *volumes,
                        const struct mobile_params *params, bool merged, graph_image depth, graph_image sum,
                        const struct targets *targets) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_volume_metallic_128_frag, &shader_mobile_volume_metallic_128_local_frag},
        {&shader_mobile_volume_specular_160_frag, &shader_mobile_volume_specular_160_local_frag},
        {&shader_mobile_volume_metallic_256_frag, &shader_mobile_volume_metallic_256_local_frag},
        {&shader_mobile_volume_specular_256_frag, &shader_mobile_volume_specular_256_local_frag}};
    struct volume_data data = {.targets = *targets,
                               .volumes = *volumes,
                               .merged = merged,
                               .view = input->view,
                               .counters = input->counters,
                               .state = {.fragment = shaders[params->layout][merged],
                                         .constant_count = VOLUME_BOUND_DEPTHS_ID + 1,
                                         .constants = {[LIGHTING_ID] = volumes->lighting.bits, [COUNT_LIGHTS_ID] = input->counters.id != 0, [HAS_LIGHTS_ID] = 1,
                                                       [HAS_METAL_ID] = 1},
                                         .color_count = 1,
                                         .color_formats = {graph_image_info(graph, sum).format},
                                         .blends = {GPU_BLEND_ADD}}};
    data.state.constants[GAMMA_ID] = (uint32_t)params->gamma;
    data.state.constants[VOLUME_BOUND_DEPTHS_ID] = volumes->shape == VOLUME_DEPTH_BOUNDS;
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile volumes", GRAPH_QUEUE_GRAPHICS, execute_volumes, &data, sizeof data);
    volumes_use(pass, volumes);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    for (uint32_t i = 0; i < targets->layout.target_count; i++) graph_local_read(pass, i, targets->images[i]);
    graph_color(pass, sum, VK_ATTACHMENT_LOAD_OP_CLEAR, (float[4]){0, 0, 0, 0});
    graph_depth_read_only(pass, depth);
}

static void add_sum(struct graph *graph, const struct shade_input *input, bool merged, graph_image sum,
                    struct targets *targets) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_sum_narrow_frag, &shader_mobile_sum_narrow_local_frag},
        {&shader_mobile_sum_wide_frag, &shader_mobile_sum_wide_local_frag}};
    const struct mobile_layout *layout = &targets->layout;
    const uint32_t at = layout->wide ? 0 : 1; /* MOBILE_SUM of mobile_sum.glsl */
    struct step_data data = {
        .targets = *targets, .merged = merged, .others = {{sum, at}}, .state = screen_state(shaders[layout->wide][merged])};
    for (uint32_t i = 0; i < layout->light_count; i++) data.reads |= 1u << layout->lights[i];
    data.push.view = input->view;
    set_formats(&data.state, layout, layout->lights, layout->light_count);
    struct graph_pass *pass = graph_add_pass(graph, "mobile sum", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    graph_local_read(pass, at, sum);
    for (uint32_t i = 0; i < layout->light_count; i++) {
        uint32_t light = layout->lights[i];
        targets->images[light] = graph_local_rewrite(pass, light, targets->images[light]);
    }
}

/* ---- blended surfaces ---- */

static void add_glass(struct graph *graph, const struct shade_input *input, graph_image depth,
                      const struct targets *targets) {
    const struct mobile_layout *layout = &targets->layout;
    struct gbuffer_data data = {.scene = input->scene,
                                .draws = *input->draws,
                                .view = input->view,
                                .lighting = input->lighting->address,
                                .counters = input->counters,
                                .set = GEOMETRY_BLEND};
    data.state = (struct gpu_graphics_params){.fragment = layout->wide ? &shader_mobile_glass_wide_frag
                                                                       : &shader_mobile_glass_narrow_frag,
                                              .constant_count = 2,
                                              .constants = {[LIGHTING_ID] = input->lighting->bits, [COUNT_LIGHTS_ID] = input->counters.id != 0},
                                              .blends = {GPU_BLEND_ALPHA, GPU_BLEND_ALPHA},
                                              .depth_format = GEOMETRY_DEPTH_FORMAT,
                                              .depth_test = true,
                                              .depth_compare = VK_COMPARE_OP_GREATER,
                                              .samples = 1};
    set_formats(&data.state, layout, layout->lights, layout->light_count);
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile blend", GRAPH_QUEUE_GRAPHICS, execute_geometry, &data, sizeof data);
    geometry_use(pass, input->scene, input->draws, GEOMETRY_BLEND);
    lighting_use(pass, input->lighting, GRAPH_READ_FRAGMENT);
    if (input->counters.id) graph_use_buffer(pass, input->counters, GRAPH_READ_WRITE_FRAGMENT);
    for (uint32_t i = 0; i < layout->light_count; i++)
        graph_color(pass, targets->images[layout->lights[i]], VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
    graph_depth_read_only(pass, depth);
}

static void add_weighted(struct graph *graph, const struct mobile_blend *blend, bool merged, graph_image depth,
                         const struct targets *targets) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_weighted_narrow_frag, &shader_mobile_weighted_narrow_local_frag},
        {&shader_mobile_weighted_wide_frag, &shader_mobile_weighted_wide_local_frag}};
    const struct mobile_layout *layout = &targets->layout;
    struct weighted_sums sums = weighted_sums_add(graph, blend->input, blend->half, depth);
    struct step_data data = {.targets = *targets,
                             .merged = merged,
                             .others = {{sums.sum, 0}, {sums.density, 1}},
                             .state = screen_state(shaders[layout->wide][merged])};
    data.push.view = blend->input->view;
    data.state.blends[0] = data.state.blends[1] = GPU_BLEND_ALPHA;
    set_formats(&data.state, layout, layout->lights, layout->light_count);
    struct graph_pass *pass =
        graph_add_pass(graph, "mobile weighted", GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    graph_local_read(pass, 0, sums.sum);
    graph_local_read(pass, 1, sums.density);
    for (uint32_t i = 0; i < layout->light_count; i++)
        graph_color(pass, targets->images[layout->lights[i]], VK_ATTACHMENT_LOAD_OP_LOAD, NULL);
}

/* ---- the end ---- */

enum { COVERS_ID = 13 }; /* of mobile_finish.frag.glsl */

static graph_image add_finish(struct graph *graph, const struct shade_input *input, bool merged,
                              const struct targets *targets, const struct mobile_params *params,
                              const struct mobile_finish *finish) {
    static const struct gpu_shader *const shaders[][2] = {
        {&shader_mobile_finish_narrow_frag, &shader_mobile_finish_narrow_local_frag},
        {&shader_mobile_finish_wide_frag, &shader_mobile_finish_wide_local_frag}};
    const struct mobile_layout *layout = &targets->layout;
    bool recycle =
        params->recycle && layout->normal >= 0 && finish->format == VK_FORMAT_R8G8B8A8_UNORM && !finish->target.id;
    graph_image target = recycle ? targets->images[layout->normal] : finish->target;
    if (!target.id)
        target = graph_create_image(graph, &(struct graph_image_params){.name = finish->picture ? "color" : "radiance",
                                                                        .format = finish->format,
                                                                        .width = input->width,
                                                                        .height = input->height});
    struct step_data data = {.targets = *targets, .merged = merged, .state = screen_state(shaders[layout->wide][merged])};
    const uint32_t place = layout->wide ? 0 : 1; /* a position or depth: whether there is a surface */
    if (!finish->picture) data.reads = 1u << place;
    for (uint32_t i = 0; i < layout->light_count; i++) data.reads |= 1u << layout->lights[i];
    data.push.view = input->view;
    data.push.factor = finish->picture ? finish->tonemap.factor : 1;
    data.push.tonemap = finish->tonemap.tonemap;
    data.push.encode = !finish->picture ? 0 : finish->tonemap.linear ? 2 : 1;
    data.push.swap = finish->picture && finish->tonemap.swap;
    data.state.constant_count = COVERS_ID + 1;
    data.state.constants[COVERS_ID] = !finish->picture;
    data.state.color_count = 1;
    data.state.color_formats[0] = finish->format;
    struct graph_pass *pass = graph_add_pass(graph, finish->picture ? "mobile tonemap" : "mobile radiance",
                                             GRAPH_QUEUE_GRAPHICS, execute_screen, &data, sizeof data);
    if (!finish->picture) graph_local_read(pass, place, targets->images[place]);
    for (uint32_t i = 0; i < layout->light_count; i++)
        graph_local_read(pass, layout->lights[i], targets->images[layout->lights[i]]);
    graph_color(pass, target, VK_ATTACHMENT_LOAD_OP_DONT_CARE, NULL);
    return target;
}

/* ---- the whole ---- */

struct mobile_result mobile_add(struct graph *graph, const struct shade_input *input, const struct mobile_blend *blend,
                                const struct volumes *volumes, bool prepass, graph_image depth,
                                const struct mobile_params *params, const struct mobile_decals *decals,
                                const struct mobile_finish *finish) {
    struct targets targets = {.layout = mobile_layout(params->layout, params->gamma, params->float_light)};
    struct mobile_result result = {.bits = 0};
    for (uint32_t i = 0; i < targets.layout.target_count; i++) {
        targets.images[i] =
            graph_create_image(graph, &(struct graph_image_params){.name = targets.layout.targets[i].name,
                                                                   .format = targets.layout.targets[i].format,
                                                                   .width = input->width,
                                                                   .height = input->height});
        result.bits += targets.layout.targets[i].bits;
    }
    graph_image sum = {0};
    if (volumes)
        sum = graph_create_image(
            graph, &(struct graph_image_params){
                       .name = "mobile sum", .format = params->sum_format, .width = input->width, .height = input->height});
    const struct graph_scope_params scope = {.name = "mobile",
                                             .most_colors = targets.layout.target_count,
                                             .most_inputs = targets.layout.target_count,
                                             .separate = params->separate};
    result.merged = graph_begin_scope(graph, &scope);
    add_gbuffer(graph, input, prepass, depth, params, &targets);
    if (decals) add_decals(graph, input, params, result.merged, decals, &targets);
    if (input->lighting) add_lights(graph, input, params, result.merged, &targets);
    if (volumes) {
        add_volumes(graph, input, volumes, params, result.merged, depth, sum, &targets);
        add_sum(graph, input, result.merged, sum, &targets);
    }
    if (blend && blend->weighted) add_weighted(graph, blend, result.merged, depth, &targets);
    if (blend && !blend->weighted) add_glass(graph, blend->input, depth, &targets);
    result.target = add_finish(graph, input, result.merged, &targets, params, finish);
    graph_end_scope(graph);
    result.target_count = targets.layout.target_count;
    memcpy(result.targets, targets.images, sizeof result.targets);
    return result;
}
