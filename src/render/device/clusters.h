/* SPDX-License-Identifier: MIT */
/** Cuts meshes into clusters of triangles that lie together, for passes/geometry/clusters.h. */
#ifndef FNL_RENDER_DEVICE_CLUSTERS_H
#define FNL_RENDER_DEVICE_CLUSTERS_H

#include "passes/geometry/clusters_shared.h"
#include "scene/scene.h"
#include "scene_shared.h"

typedef ARRAY(struct gpu_cluster) gpu_cluster_list;
typedef ARRAY(uint32_t) gpu_word_list;

/**
 * Appends the clusters of a primitive of triangles and writes its triangles, cluster by cluster, to `out_indices` (as many as it has). Corners keep
 * their order within a triangle. `words` (or NULL) takes what mesh shaders read of each cluster: a word for each vertex and for each triangle, about
 * 6.5 bytes for each triangle. Cost: about a microsecond for each triangle.
 */
fnl_result device_clusters_build(const fnl_host *host, const struct scene_primitive *p, gpu_cluster_list *clusters,
                                 uint32_t *out_indices, gpu_word_list *words);

#endif
