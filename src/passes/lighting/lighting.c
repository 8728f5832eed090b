/* SPDX-License-Identifier: MIT */
#include "passes/lighting/lighting.h"

static uvec2 words_of(VkDeviceAddress address) { return (uvec2){(uint32_t)address, (uint32_t)(address >> 32)}; }

static uint32_t shadow_bits(const struct shadows *shadows) {
    const uint32_t beside_rays = GPU_LIGHTING_SOFT | GPU_LIGHTING_SAMPLED | GPU_LIGHTING_CUBEMAP, beside_maps = GPU_LIGHTING_FILTERED;
    uint32_t bits = shadows->bits & ~((shadows->rays.address ? 0 : beside_rays) | (shadows->maps.address ? 0 : beside_maps));
    if (shadows->rays.address) bits |= GPU_LIGHTING_RAYS | (shadows->rays.top.id ? GPU_LIGHTING_RAY_QUERY : 0);
    if (shadows->maps.address) bits |= GPU_LIGHTING_MAPS;
    if (shadows->contact.id) bits |= GPU_LIGHTING_CONTACT;
    return bits;
}

static uint32_t bits_of(const struct lighting *l) {
    uint32_t bits = l->list.kind | shadow_bits(&l->shadows) | environment_kind(&l->environment);
    if (l->lights.simple || l->lights.local_count == 0) bits |= GPU_LIGHTING_SIMPLE;
    if (l->lights.masks) bits |= GPU_LIGHTING_MASKS;
    if (l->lights.profiles) bits |= GPU_LIGHTING_PROFILES;
    if (l->lights.lobes) bits |= GPU_LIGHTING_AREA_LIGHTS;
    if (l->layered) bits |= GPU_LIGHTING_LAYERS;
    return bits;
}

struct lighting lighting_add(struct graph *graph, gpu_device *device, const struct lighting *scopes, const struct light_list *list) {
    struct lighting l = *scopes;
    l.list = list ? *list : (struct light_list){.lights = scopes->lights.buffer};
    l.bits = bits_of(&l);
    const bool contact = l.shadows.contact.id;
    const struct gpu_slice slice = gpu_frame_allocate(device, sizeof(struct gpu_lighting));
    l.address = slice.address;
    l.memory = slice.data;
    if (l.memory)
        *l.memory = (struct gpu_lighting){.lights = light_set_block(&l.lights),
                                          .list = l.list.header,
                                          .view = l.view,
                                          .shadows = {.rays = words_of(l.shadows.rays.address),
                                                      .maps = words_of(l.shadows.maps.address),
                                                      .rooms = words_of(l.shadows.rooms.address),
                                                      .ray_count = l.shadows.ray_count,
                                                      .seed = l.shadows.seed,
                                                      .contact_samples = contact ? MAX(graph_image_info(graph, l.shadows.contact).samples, 1u) : 0,
                                                      .contact_length = l.shadows.contact_length}};
    if (l.memory && contact) graph_put_sampled(graph, &l.memory->shadows.contact, l.shadows.contact);
    return l;
}

void lighting_use(struct graph_pass *pass, const struct lighting *lighting, enum graph_use use) {
    light_list_use(pass, &lighting->list, use);
    environment_use(pass, &lighting->environment, use);
    if (lighting->shadows.rays.address) rays_use(pass, &lighting->shadows.rays, use);
    if (lighting->shadows.maps.address) shadow_maps_use(pass, &lighting->shadows.maps, use);
    if (lighting->shadows.contact.id)
        graph_use_image(pass, lighting->shadows.contact, use == GRAPH_READ_COMPUTE ? GRAPH_SAMPLE_COMPUTE : GRAPH_SAMPLE_FRAGMENT);
    if (lighting->shadows.rooms.address) probes_use(pass, &lighting->shadows.rooms, use);
}
