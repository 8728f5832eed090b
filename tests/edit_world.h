/* SPDX-License-Identifier: MIT */
/** A small world that can be edited at random, for tests of scenes that change while they are shown. */
#ifndef FNL_TESTS_EDIT_WORLD_H
#define FNL_TESTS_EDIT_WORLD_H

#include "tests/render_harness.h"
#include "tests/render_test.h"

enum { MESHES = 40, INSTANCES = 48, LIGHTS = 24, DECALS = 8, IMAGES = 12 };

struct world {
    struct stage stage;
    struct random_state random;
    fnl_mesh_id meshes[MESHES];
    fnl_material_id materials[MESHES]; /* of each mesh */
    fnl_image_id images[IMAGES];
    fnl_instance_id instances[INSTANCES];
    fnl_light_id lights[LIGHTS];
    fnl_decal_id decals[DECALS];
    bool instance_there[INSTANCES], light_there[LIGHTS], decal_there[DECALS];
    uint32_t mesh_count, image_count, morphed_mesh; /* the latter: index in the scene */
    bool keeps_handedness;                          /* instances do not begin or cease to mirror */
};

/** Images, meshes (one with morph targets), instances, lights; 65x37, no exposure, radiance. Closed by stage_close(&w.stage). */
struct world world_open(void);
/** One edit at random: of an instance, light, decal, pose, material, mesh, or something comes. */
void world_edit(struct world *w);
/** An instance comes, goes, is hidden, shown, moved, or gets other receivers. */
void world_edit_instance(struct world *w);

void world_add_image(struct world *w);
void world_add_mesh(struct world *w, uint32_t side, bool plain);
void world_add_instance(struct world *w, uint32_t i);
void world_add_light(struct world *w, uint32_t i);
fnl_mat4 world_pose(struct world *w);
fnl_material_params world_look(struct world *w, bool plain);
/** A bumpy sheet of side * side squares, on both sides where its material is. Free its arrays by world_free_sheet(). */
fnl_mesh_params world_sheet(struct world *w, uint32_t side);
void world_free_sheet(const fnl_mesh_params *sheet);

#endif
