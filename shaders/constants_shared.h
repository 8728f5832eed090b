/* SPDX-License-Identifier: MIT */
/**
 * Ids of the specialisation constants of shaders that shade, or draw what is shaded. One table, because the constants of all files that go into a
 * shader must differ, and so that C and GLSL agree; families that never meet in a shader use the same numbers. Shaders with no other
 * constants than one or two of their own count them from 0.
 */
#ifndef FNL_SHADERS_CONSTANTS_SHARED_H
#define FNL_SHADERS_CONSTANTS_SHARED_H

/* Everything that shades (shade.glsl, lights/iterate.glsl, brdf.glsl). */
#define LIGHTING_ID 0u
#define COUNT_LIGHTS_ID 1u
#define HAS_LIGHTS_ID 2u
#define HAS_METAL_ID 3u

/* Everything that draws the scene's geometry: GPU_FEATURE_… bits, beside the numbered constants (GPU_FEATURES_ID of gpu.h). */
#define FEATURES_ID 31u

/* deferred, by classes of blocks */
#define IS_FULL_ID 4u
#define BLOCK_SIZE_ID 5u
/* coarse */
#define COARSE_SIZE_ID 4u
#define COARSE_FIND_ID 5u
#define COARSE_SPLIT_ID 7u
#define COARSE_FLAGS_ID 9u
/* batches and multipass */
#define FIXED_LIGHTS_ID 6u
#define MULTIPASS_STEP_ID 7u

/* G-buffers: see also GBUFFER_CONSTANT and GBUFFER_EXTRA_CONSTANT of gbuffer_shared.h, 8 and 10 */
#define HOLES_ARE_CUT_ID 9u
/* requests of pages of shadow maps, beside the samples, 1 */
#define SHADOW_WEIGHS_ID 2u
/* samples.glsl, and others that know the samples of a target; deferred_msaa */
#define SAMPLES_ID 9u
#define MSAA_METHOD_ID 10u
#define FLOATS_ID 11u
#define MSAA_STEP_ID 12u
#define MSAA_MERGED_ID 13u

/* light-prepass and inferred */
#define LIGHT_BUFFER_ID 13u
#define LIGHT_SCALE_ID 14u
#define STIPPLED_ID 14u
#define SURFACE_HOLES_ARE_CUT_ID 15u
/* light-indexed, zioma */
#define INDEXED_PACKING_ID 13u
#define INDEXED_STEP_ID 14u
#define ZIOMA_LAYER_ID 13u
/* volumes, those of mobile too; mobile */
#define VOLUME_BATCH_ID 12u
#define VOLUME_BOUND_DEPTHS_ID 13u
#define VOLUME_MASKED_ID 14u
#define VOLUME_FRONTS_ID 15u
#define GAMMA_ID 12u

/* Materials that are found by a stored number (MATERIAL_GRADIENTS): visibility, texturing, dais */
#define GRADIENT_TAPS_ID 8u
#define FOUND_FEATURES_ID 9u
#define HAS_TEXTURES_ID 10u
#define HAS_NORMAL_MAP_ID 11u
/* visible.glsl: which pixels, or samples, are shaded at once */
#define VISIBLE_LISTED_ID 12u
#define VISIBLE_SAMPLES_ID 13u
#define VISIBLE_FLOATS_ID 14u
/* visibility: the id pass, and shading */
#define TRIANGLE_BITS_ID 7u
#define COUNT_FRAGMENTS_ID 8u
#define VISIBILITY_GRID_ID 7u
#define STORED_WEIGHTS_ID 15u
/* texturing */
#define TEXTURING_FORM_ID 4u
#define SHOWS_LEVELS_ID 5u
/* dais: storing, and shading */
#define DAIS_STORE_SHARED_ID 7u
#define DAIS_COLORS_ID 8u
#define DAIS_ATTEMPTS_ID 10u
#define DAIS_SAMPLES_ID 4u
#define DAIS_LISTS_ID 5u
#define DAIS_SHARED_ID 12u
#define DAIS_FLOATS_ID 13u
#define DAIS_SHOW_ID 14u

#endif
