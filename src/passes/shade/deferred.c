/* SPDX-License-Identifier: MIT */
#include "passes/shade/classify.h"
#include "passes/shade/deferred.h"
#include "passes/shade/shade_shared.h"
#include "shaders.h"

#define MAX_VISITS (1ull << 32) /* of lights by the pixels of a dispatch */

void deferred_add(struct graph *graph, const struct shade_input *input, const struct gbuffer *gbuffer,
                  const struct shade_classes *classes, graph_image radiance) {
    const bool counts = input->counters.id, keeps_apart = input->apart.open.id, guided = input->guide.weights.id;
    const struct shade_classes none = {0}, *c = classes ? classes : &none;
    struct gpu_compute_params pipeline = {
        &shader_deferred_comp,
        BLOCK_SIZE_ID + 1,
        {[LIGHTING_ID] = input->lighting->bits | (keeps_apart ? GPU_LIGHTING_DENOISED : 0) | (guided ? GPU_LIGHTING_GUIDED : 0), [COUNT_LIGHTS_ID] = counts, [HAS_LIGHTS_ID] = 1, [HAS_METAL_ID] = 1, [BLOCK_SIZE_ID] = c->block_size}};
    gbuffer_specialise(gbuffer, pipeline.constants, &pipeline.constant_count);
    struct gpu_deferred_push push = {.lighting = input->lighting->address,
                                     .gbuffer = gbuffer_block(gbuffer),
                                     .block_count = c->block_count};
    /* Systems reset a device that stays with one piece of work for seconds; here every pixel might visit every light. */
    const uint32_t rows = DIVIDE_UP(input->height, 8u);
    const uint64_t visits = 8ull * input->width * MAX(input->light_count, 1u); /* of a row of groups */
    const uint32_t together = (uint32_t)CLAMP(MAX_VISITS / visits, 1ull, (uint64_t)rows);
    const uint32_t count = classes ? SHADE_CLASSES : DIVIDE_UP(rows, together);
    struct graph_pass *pass = NULL;
    for (uint32_t i = 0; i < count; i++) {
        struct graph_dispatch dispatch = {.pass = pass, .name = "deferred"};
        if (classes) {
            push.class_index = i;
            pipeline.constants[HAS_LIGHTS_ID] = (i & SHADE_LIGHTS) != 0;
            pipeline.constants[HAS_METAL_ID] = (i & SHADE_METAL) != 0;
            pipeline.constants[IS_FULL_ID] = (i & SHADE_FULL) != 0;
            dispatch.indirect = classes->dispatches;
            dispatch.indirect_offset = i * 12ull;
        } else {
            push.first_row = i * together * 8;
            dispatch.groups[0] = MIN(DIVIDE_UP(input->width, 8u), DEFERRED_STRIP);
            dispatch.groups[1] = MIN(together, rows - i * together);
            dispatch.groups[2] = DIVIDE_UP(input->width, 8u * DEFERRED_STRIP);
        }
        dispatch.pipeline = pipeline;
        dispatch.push = &push;
        dispatch.push_size = sizeof push;
        pass = graph_dispatch(graph, &dispatch);
        gbuffer_add_rows(pass, &push.gbuffer, gbuffer, GRAPH_SAMPLE_COMPUTE);
        graph_add_row(pass, graph_image_row(&push.radiance, radiance, GRAPH_READ_WRITE_COMPUTE));
        graph_add_row(pass, graph_row_if(keeps_apart, graph_stores(&push.open, input->apart.open)));
        graph_add_row(pass, graph_row_if(keeps_apart, graph_stores(&push.seen, input->apart.seen)));
        graph_add_row(pass, graph_row_if(keeps_apart, graph_stores(&push.drawn, input->apart.drawn)));
        graph_add_row(pass, graph_row_if(keeps_apart, graph_stores(&push.field, input->apart.field.current)));
        graph_add_row(pass, graph_row_if(guided, graph_samples(&push.guide_weights, input->guide.weights)));
        graph_add_row(pass, graph_row_if(guided, graph_image_row(&push.guide_seen, input->guide.seen, GRAPH_READ_WRITE_COMPUTE)));
        graph_add_row(pass, graph_row_if(counts, graph_changes(&push.counters, input->counters)));
        graph_add_row(pass, graph_row_if(classes, graph_reads(&push.sums, c->sums)));
        graph_add_row(pass, graph_row_if(classes, graph_reads(&push.blocks, c->blocks)));
    }
    lighting_use(pass, input->lighting, GRAPH_READ_COMPUTE);
}
